/* SPDX-License-Identifier: MIT
 * Regions as files: CSV with columns i,j,hx,hy and perhaps reference, in lenses, and
 * perhaps x_mm,y_mm,z_mm, where the region lies on the object. */
#ifndef PLFT_REGIONS_H
#define PLFT_REGIONS_H

#include "plenofix/roi.h"

/* Fill cfg->regions and cfg->region.  0 or PLFT_DATA with a message that names the
 * line. */
int plft_regions_read(plfx_roi_cfg *cfg, const char *path);

/* place[region] of as many regions as plft_regions_read() found; *known 0 when the file
 * has none of the three columns.  0 or PLFT_DATA. */
int plft_regions_places(const char *path, double place[PLFX_ROI_MAX][3], int *known);

/* 0 or PLFT_DATA. */
int plft_regions_write(const plfx_roi_region *region, int n, const char *path);

#endif
