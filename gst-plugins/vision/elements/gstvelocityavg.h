/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/base/gstbasetransform.h>

G_BEGIN_DECLS

#define GST_TYPE_VELOCITY_AVG (gst_velocity_avg_get_type())
G_DECLARE_FINAL_TYPE(GstVelocityAvg, gst_velocity_avg, GST, VELOCITY_AVG, GstBaseTransform)

GST_ELEMENT_REGISTER_DECLARE(velocityavg)

G_END_DECLS
