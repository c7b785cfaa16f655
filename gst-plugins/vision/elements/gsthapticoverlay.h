/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/video/gstvideofilter.h>

G_BEGIN_DECLS

#define GST_TYPE_HAPTIC_OVERLAY (gst_haptic_overlay_get_type())
G_DECLARE_FINAL_TYPE(GstHapticOverlay, gst_haptic_overlay, GST, HAPTIC_OVERLAY, GstVideoFilter)

GST_ELEMENT_REGISTER_DECLARE(hapticoverlay)

G_END_DECLS
