/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/base/gstbasetransform.h>

G_BEGIN_DECLS

#define GST_TYPE_HAPTIC_CONVERT (gst_haptic_convert_get_type())
G_DECLARE_FINAL_TYPE(GstHapticConvert, gst_haptic_convert, GST, HAPTIC_CONVERT, GstBaseTransform)

GST_ELEMENT_REGISTER_DECLARE(hapticconvert)

G_END_DECLS
