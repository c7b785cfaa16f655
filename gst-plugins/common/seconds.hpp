// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <concepts>

namespace haptic {

/// Times are ns; what is computed with them, and shown, is s.
constexpr double seconds(std::integral auto nanoseconds) noexcept {
  return static_cast<double>(nanoseconds) * 1e-9;
}

} // namespace haptic
