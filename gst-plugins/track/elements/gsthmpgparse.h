/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once

#include <gst/base/gstbaseparse.h>

G_BEGIN_DECLS

#define GST_TYPE_HMPG_PARSE (gst_hmpg_parse_get_type())
G_DECLARE_FINAL_TYPE(GstHmpgParse, gst_hmpg_parse, GST, HMPG_PARSE, GstBaseParse)

GST_ELEMENT_REGISTER_DECLARE(hmpgparse)

G_END_DECLS
