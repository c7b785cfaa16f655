// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/hand-path.hpp"

#include <algorithm>

namespace haptic {

PointerPosition place_at(const std::vector<TimedPlace> &path, double time) {
  const auto after = std::ranges::upper_bound(path, time, {}, &TimedPlace::time);
  return (after == path.begin() ? after : after - 1)->position();
}

PointerPosition TimedPlace::position() const {
  PointerPosition position;
  position.x = x;
  position.y = y;
  position.z = z;
  return position;
}

} // namespace haptic
