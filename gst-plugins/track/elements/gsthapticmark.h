/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/base/gstbasetransform.h>

G_BEGIN_DECLS

#define GST_TYPE_HAPTIC_MARK (gst_haptic_mark_get_type())
G_DECLARE_FINAL_TYPE(GstHapticMark, gst_haptic_mark, GST, HAPTIC_MARK, GstBaseTransform)

GST_ELEMENT_REGISTER_DECLARE(hapticmark)

G_END_DECLS
