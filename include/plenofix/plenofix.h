/* SPDX-License-Identifier: MIT
 * Everything of the core in one include. */
#ifndef PLENOFIX_PLENOFIX_H
#define PLENOFIX_PLENOFIX_H

#include "plenofix/version.h"
#include "plenofix/base.h"
#include "plenofix/image.h"
#include "plenofix/raw.h"
#include "plenofix/lut.h"
#include "plenofix/view.h"
#include "plenofix/plan.h"
#include "plenofix/sweep.h"
#include "plenofix/drift.h"
#include "plenofix/frame.h"
#include "plenofix/preset.h"
#include "plenofix/viewcheck.h"
#include "plenofix/gradient.h"
#include "plenofix/fuse.h"
#include "plenofix/depth.h"
#include "plenofix/refocus.h"
#include "plenofix/stream.h"
#include "plenofix/packet.h"
#include "plenofix/modal.h"
#include "plenofix/roi.h"

#endif
