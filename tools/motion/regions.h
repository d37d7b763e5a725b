/* SPDX-License-Identifier: MIT
 * Regions as files: CSV with columns i,j,hx,hy and perhaps reference, in lenses. */
#ifndef PLFT_REGIONS_H
#define PLFT_REGIONS_H

#include "plenofix/roi.h"

/* Fill cfg->regions and cfg->region.  0 or PLFT_DATA with a message that names the
 * line. */
int plft_regions_read(plfx_roi_cfg *cfg, const char *path);

/* 0 or PLFT_DATA. */
int plft_regions_write(const plfx_roi_region *region, int n, const char *path);

#endif
