/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* One measured patch: plain C, so that readers of the metadata need neither C++ nor the tracker. */
#pragma once

/* The most patches of one frame. */
#define GST_HAPTIC_MOTION_META_MAX_PATCHES 64

/**
 * GstHapticPatch:
 * @x, @y: centre in the earlier frame, px from its top left corner (pixel i covers i..i+1)
 * @width, @height: size, px
 * @dx, @dy: displacement from the earlier to the later frame, px, y down
 * @precision_xx, @precision_xy, @precision_yy: inverse covariance of (dx, dy), 1/px². One
 *   direction without precision is the aperture problem; 0 in all means unknown.
 * @residual: rms grey-level difference that the displacement leaves, 8-bit steps
 * @share: part of the region whose pixels move with this patch, 0..1; 0 in all patches: not counted
 */
typedef struct _GstHapticPatch {
  float x, y;
  float width, height;
  float dx, dy;
  float precision_xx, precision_xy, precision_yy;
  float residual;
  float share;
} GstHapticPatch;
