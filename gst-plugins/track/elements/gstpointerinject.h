/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_TYPE_POINTER_INJECT (gst_pointer_inject_get_type())
G_DECLARE_FINAL_TYPE(GstPointerInject, gst_pointer_inject, GST, POINTER_INJECT, GstElement)

GST_ELEMENT_REGISTER_DECLARE(pointerinject)

G_END_DECLS
