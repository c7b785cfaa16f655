// SPDX-License-Identifier: LGPL-2.1-or-later
// Who has a file open, as far as this user may know.
#pragma once

#include <string>

namespace spidar {

/// "vlc (process 1234)", or words for somebody who cannot be seen.
std::string holder_of(const std::string &path);

} // namespace spidar
