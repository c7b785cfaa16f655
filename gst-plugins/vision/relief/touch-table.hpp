// SPDX-License-Identifier: LGPL-2.1-or-later
// From colours to what a hand feels there (docs/formats/touch-table.md).
#pragma once

#include "samples/relief-field.hpp"

#include <array>
#include <string>
#include <vector>

namespace haptic {

/// A colour in CIELAB (ISO/CIE 11664-4), white point D65.
struct LabColour {
  double lightness = 0; ///< L*, 0..100
  double a = 0;
  double b = 0;
};

/// Red, green and blue as parts of full intensity, not those of sRGB: linear light.
using LinearColour = std::array<double, 3>;

/// The linear light of the 256 numbers of a component of sRGB (IEC 61966-2-1).
const std::array<float, 256> &linear_light();

LabColour lab_of(const LinearColour &colour);

struct TouchEntry {
  LabColour colour;
  double height = 0;    ///< m
  double stiffness = 0; ///< N/m
  double friction = 0;  ///< Coulomb coefficient
};

class TouchTable {
public:
  /// `by_lightness`: only the lightness counts, and between two entries all is linear. Else the
  /// distance of colours counts.
  TouchTable(std::vector<TouchEntry> entries, bool by_lightness);

  /// With validity 1.
  ReliefCell at(const LabColour &colour) const;

private:
  std::vector<TouchEntry> entries_; // by lightness: in its order
  bool by_lightness_;
};

inline constexpr std::size_t kMostTouchEntries = 64;

/// `name`: a path, if it has a slash or ends in .ini, else a built-in table. Throws
/// std::runtime_error with a message for a user.
TouchTable load_touch_table(const std::string &name);

} // namespace haptic
