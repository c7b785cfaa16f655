/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_TYPE_POINTER_EXTRACT (gst_pointer_extract_get_type())
G_DECLARE_FINAL_TYPE(GstPointerExtract, gst_pointer_extract, GST, POINTER_EXTRACT, GstElement)

GST_ELEMENT_REGISTER_DECLARE(pointerextract)

G_END_DECLS
