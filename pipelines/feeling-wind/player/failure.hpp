// SPDX-License-Identifier: LGPL-2.1-or-later
// Errors of GStreamer as a sentence with its cure.
#pragma once

#include "player/source.hpp"

#include <gst/gst.h>
#include <string>

namespace program {

/// Returns why the source does not play, or plays no further. `missing`: as missing_plugin()
/// returned it, or empty.
std::string failure_sentence(const GError &error, const Source &source, const std::string &missing);

/// Returns what a message says is missing and the package that has it, in a sentence. Empty if it
/// is another message.
std::string missing_plugin(GstMessage *message);

} // namespace program
