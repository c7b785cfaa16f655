/* Metadata that roitracker attaches to each picture: what was measured between it and an earlier
 * one. */
#pragma once

#include "haptic-patch.h"

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_HAPTIC_MOTION_META_MAX_PATCHES 64

/**
 * GstHapticMotionFlags:
 * @GST_HAPTIC_MOTION_STILL: the pixels of the region did not change
 * @GST_HAPTIC_MOTION_DUPLICATE: the picture repeats the one before (as in 3:2 pulldown); nothing
 * was measured and the velocity of before goes on
 * @GST_HAPTIC_MOTION_CUT: another scene began
 * @GST_HAPTIC_MOTION_DISCONTINUITY: there was no earlier picture to compare with
 */
typedef enum {
  GST_HAPTIC_MOTION_STILL = 1 << 0,
  GST_HAPTIC_MOTION_DUPLICATE = 1 << 1,
  GST_HAPTIC_MOTION_CUT = 1 << 2,
  GST_HAPTIC_MOTION_DISCONTINUITY = 1 << 3,
} GstHapticMotionFlags;

/**
 * GstHapticMotionMeta:
 * @flags: #GstHapticMotionFlags
 * @picture_width, @picture_height: px, the picture that the coordinates refer to
 * @region_x, @region_y, @region_width, @region_height: region of interest, px, clipped at the
 * picture
 * @pointer_x, @pointer_y: pointer in use, px
 * @interval: time between the two pictures from their time stamps, 0 when there is none
 * @n_patches: used entries of @patches
 */
typedef struct _GstHapticMotionMeta {
  GstMeta meta;

  guint flags;
  guint picture_width, picture_height;
  gfloat region_x, region_y, region_width, region_height;
  gfloat pointer_x, pointer_y;
  GstClockTime interval;
  guint n_patches;
  GstHapticPatch patches[GST_HAPTIC_MOTION_META_MAX_PATCHES];
} GstHapticMotionMeta;

GType gst_haptic_motion_meta_api_get_type(void);
#define GST_HAPTIC_MOTION_META_API_TYPE (gst_haptic_motion_meta_api_get_type())
const GstMetaInfo *gst_haptic_motion_meta_get_info(void);

/* The buffer must be writable. All fields but the header start at zero. */
GstHapticMotionMeta *gst_buffer_add_haptic_motion_meta(GstBuffer *buffer);
GstHapticMotionMeta *gst_buffer_get_haptic_motion_meta(GstBuffer *buffer);

G_END_DECLS
