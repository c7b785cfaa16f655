// SPDX-License-Identifier: LGPL-2.1-or-later
// Dark or light, as the user or the desktop wants it.
#pragma once

#include <string>

namespace program {

/// `choice`: "system", "light" or "dark". "system" follows the desktop's portal, also while it
/// changes; without one, GTK's own setting stays.
void set_appearance(const std::string &choice);

} // namespace program
