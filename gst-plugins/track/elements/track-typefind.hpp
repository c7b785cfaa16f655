// SPDX-License-Identifier: LGPL-2.1-or-later
// Recognises .hmpg and .hjif by their content.
#pragma once

#include <gst/gst.h>

namespace haptic {

gboolean register_track_typefinders(GstPlugin *plugin);

} // namespace haptic
