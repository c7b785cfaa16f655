/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* Metadata that roitracker attaches to each frame: the measurement between it and an earlier one. A
 * reader needs this header alone. */
#pragma once

#include "haptic-patch.h"

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_HAPTIC_MOTION_META_NAME "GstHapticMotionMeta"

/**
 * GstHapticMotionFlags:
 * @GST_HAPTIC_MOTION_STILL: the pixels of the region did not change
 * @GST_HAPTIC_MOTION_DUPLICATE: the frame repeats the one before (as in 3:2 pulldown); nothing
 * was measured and the velocity of before goes on
 * @GST_HAPTIC_MOTION_CUT: another scene began
 * @GST_HAPTIC_MOTION_DISCONTINUITY: there was no earlier frame to compare with
 * @GST_HAPTIC_MOTION_TILED: the patches cover the region evenly, and each displacement is the mean
 * over the pixels of its patch
 */
typedef enum {
  GST_HAPTIC_MOTION_STILL = 1 << 0,
  GST_HAPTIC_MOTION_DUPLICATE = 1 << 1,
  GST_HAPTIC_MOTION_CUT = 1 << 2,
  GST_HAPTIC_MOTION_DISCONTINUITY = 1 << 3,
  GST_HAPTIC_MOTION_TILED = 1 << 8,
} GstHapticMotionFlags;

/**
 * GstHapticHold:
 * @GST_HAPTIC_HOLD_NONE: nothing is pressed
 * @GST_HAPTIC_HOLD_HELD: the thing itself is seen
 * @GST_HAPTIC_HOLD_ABOUT: what moves about the place is followed; which thing it is cannot be told
 * @GST_HAPTIC_HOLD_HIDDEN: something is before the thing; the place is a guess
 * @GST_HAPTIC_HOLD_LOST: it was not found again
 * @GST_HAPTIC_HOLD_REFUSED: there was nothing to hold
 */
typedef enum {
  GST_HAPTIC_HOLD_NONE,
  GST_HAPTIC_HOLD_HELD,
  GST_HAPTIC_HOLD_ABOUT,
  GST_HAPTIC_HOLD_HIDDEN,
  GST_HAPTIC_HOLD_LOST,
  GST_HAPTIC_HOLD_REFUSED,
} GstHapticHold;

/**
 * GstHapticMotionMeta:
 * @flags: #GstHapticMotionFlags
 * @frame_width, @frame_height: px, the frame that the coordinates refer to
 * @region_x, @region_y, @region_width, @region_height: region of interest, px, clipped at the
 * frame
 * @pointer_x, @pointer_y: pointer in use, px
 * @interval: ns between the two frames from their time stamps, 0 when there is none
 * @n_candidates: patches that were tried; @patches has those of them that could be trusted
 * @n_patches: used entries of @patches
 * @force_x, @force_y, @force_z: force that the device was commanded to exert when the frame came,
 * N, x to the right, y up, z towards the user; NaN: unknown
 * @proxy_x, @proxy_y: where the hand is held on the relief that it touches, px; NaN: no relief can
 * be touched
 * @depth: m, from the hand to there; 0: it touches nothing; NaN: no relief can be touched
 * @hold: #GstHapticHold, what became of the thing that was taken by a press
 * @held_x, @held_y: where the thing is, px; where it was last, if it is lost
 * @held_radius: what is followed lies within it, px
 * @held_time: ns since the frame in which the thing was taken
 */
typedef struct _GstHapticMotionMeta {
  GstMeta meta;

  guint flags;
  guint frame_width, frame_height;
  gfloat region_x, region_y, region_width, region_height;
  gfloat pointer_x, pointer_y;
  GstClockTime interval;
  guint n_candidates;
  guint n_patches;
  GstHapticPatch patches[GST_HAPTIC_MOTION_META_MAX_PATCHES];
  gfloat force_x, force_y, force_z;
  gfloat proxy_x, proxy_y, depth;
  guint hold;
  gfloat held_x, held_y, held_radius;
  GstClockTime held_time;
} GstHapticMotionMeta;

/* By name, so that readers do not link to the plugin. NULL if the buffer has none. */
static inline GstHapticMotionMeta *gst_buffer_get_haptic_motion_meta(GstBuffer *buffer) {
  const GstMetaInfo *info = gst_meta_get_info(GST_HAPTIC_MOTION_META_NAME);
  return info ? (GstHapticMotionMeta *)(void *)gst_buffer_get_meta(buffer, info->api) : NULL;
}

/* Inside the plugin that registers the metadata. The buffer must be writable. All fields but the
 * header start at zero, and force and proxy are unknown. */
GstHapticMotionMeta *gst_buffer_add_haptic_motion_meta(GstBuffer *buffer);

G_END_DECLS
