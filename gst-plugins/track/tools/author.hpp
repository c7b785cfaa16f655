// SPDX-License-Identifier: LGPL-2.1-or-later
// Authors many videos: one process for each, some at a time, with a progress bar.
#pragma once

#include "author-file.hpp"

#include <string>
#include <vector>

namespace haptic {

/// Returns the exit status: 0 if all copies are there. Forks, so GStreamer must not have been
/// initialized.
int author(const std::vector<std::string> &files, const AuthorOptions &options, unsigned jobs);

} // namespace haptic
