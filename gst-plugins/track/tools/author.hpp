// SPDX-License-Identifier: LGPL-2.1-or-later
// Many videos: one process for each, some at a time, and what the user sees of it.
#pragma once

#include "author-file.hpp"

#include <string>
#include <vector>

namespace haptic {

/// The exit status: 0 if all copies are there. GStreamer must not have been initialized: this
/// process forks.
int author(const std::vector<std::string> &files, const AuthorOptions &options, unsigned jobs);

} // namespace haptic
