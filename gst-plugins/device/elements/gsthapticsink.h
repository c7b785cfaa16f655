/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* The element hapticsink: motion samples in, force on the hand out. */
#pragma once

#include <gst/base/gstbasesink.h>

G_BEGIN_DECLS

#define GST_TYPE_HAPTIC_SINK (gst_haptic_sink_get_type())
G_DECLARE_FINAL_TYPE(GstHapticSink, gst_haptic_sink, GST, HAPTIC_SINK, GstBaseSink)

GST_ELEMENT_REGISTER_DECLARE(hapticsink)

G_END_DECLS
