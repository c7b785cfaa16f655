// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "elements/gstreliefmaker.h"

G_BEGIN_DECLS

#define GST_TYPE_DEPTH_FIELD (gst_depth_field_get_type())
G_DECLARE_FINAL_TYPE(GstDepthField, gst_depth_field, GST, DEPTH_FIELD, GstReliefMaker)

GST_ELEMENT_REGISTER_DECLARE(depthfield)

G_END_DECLS
