// SPDX-License-Identifier: LGPL-2.1-or-later
// Finds the program that has a file open, as far as this user may see.
#pragma once

#include <string>

namespace spidar {

/// Name and number, "vlc (process 1234)", or a text for a process that is not visible.
std::string holder_of(const std::string &path);

} // namespace spidar
