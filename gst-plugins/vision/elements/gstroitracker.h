/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/video/gstvideofilter.h>

G_BEGIN_DECLS

#define GST_TYPE_ROI_TRACKER (gst_roi_tracker_get_type())
G_DECLARE_FINAL_TYPE(GstRoiTracker, gst_roi_tracker, GST, ROI_TRACKER, GstVideoFilter)

GST_ELEMENT_REGISTER_DECLARE(roitracker)

G_END_DECLS
