/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* The element hapticarray: motion in, one channel of vibration for each actuator out. */
#pragma once

#include <gst/base/gstaggregator.h>

G_BEGIN_DECLS

#define GST_TYPE_HAPTIC_ARRAY (gst_haptic_array_get_type())
G_DECLARE_FINAL_TYPE(GstHapticArray, gst_haptic_array, GST, HAPTIC_ARRAY, GstAggregator)

GST_ELEMENT_REGISTER_DECLARE(hapticarray)

G_END_DECLS
