/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/base/gstbasetransform.h>

G_BEGIN_DECLS

#define GST_TYPE_MOTION_FIELD (gst_motion_field_get_type())
G_DECLARE_FINAL_TYPE(GstMotionField, gst_motion_field, GST, MOTION_FIELD, GstBaseTransform)

GST_ELEMENT_REGISTER_DECLARE(motionfield)

G_END_DECLS
