// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track-time.hpp"

#include <array>
#include <ctime>

namespace haptic {

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm date{};
  gmtime_r(&now, &date);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &date);
  return text.data();
}

} // namespace haptic
