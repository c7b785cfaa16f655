// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "elements/gstreliefmaker.h"

G_BEGIN_DECLS

#define GST_TYPE_RELIEF_MAP (gst_relief_map_get_type())
G_DECLARE_FINAL_TYPE(GstReliefMap, gst_relief_map, GST, RELIEF_MAP, GstReliefMaker)

GST_ELEMENT_REGISTER_DECLARE(reliefmap)

G_END_DECLS
