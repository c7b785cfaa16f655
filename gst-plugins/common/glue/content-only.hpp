// SPDX-License-Identifier: LGPL-2.1-or-later
// A file's content opens nothing: neither other files nor addresses.
#pragma once

#include <gst/gst.h>

namespace haptic {

/// Lets a parsebin, decodebin or uridecodebin choose no element that opens what the content names,
/// such as a playlist or a description of a session. The pipeline then ends with an error of this
/// text, which is a constant.
void open_content_only(GstElement *autoplugger, const char *error);

} // namespace haptic
