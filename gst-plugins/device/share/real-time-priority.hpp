// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace haptic {

/// What the loop asks the kernel for, and the services where it refuses: above what desktops use,
/// below the kernel's threads.
inline constexpr int kRealTimePriority = 50;

} // namespace haptic
