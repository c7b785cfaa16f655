// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the actuators of an array are on the skin (docs/formats/array-layout.md).
#pragma once

#include <string>
#include <vector>

namespace haptic {

inline constexpr std::size_t kFewestActuators = 2;
inline constexpr std::size_t kMostActuators = 64;

/// One actuator. The skin is unrolled to a plane: x to the right and y up, as the person sees the
/// film.
struct Actuator {
  double x = 0;       ///< m
  double y = 0;       ///< m
  double carrier = 0; ///< Hz, the vibration it makes best
  double gain = 1;    ///< 0..1, of its channel
  bool operator==(const Actuator &) const = default;
};

struct ArrayLayout {
  std::vector<Actuator> actuators; ///< in the order of the channels
  bool operator==(const ArrayLayout &) const = default;
};

/// `name`: a path, if it has a slash or ends in .ini, else a built-in layout. Throws
/// std::runtime_error with a message for a user.
ArrayLayout load_array_layout(const std::string &name);

} // namespace haptic
