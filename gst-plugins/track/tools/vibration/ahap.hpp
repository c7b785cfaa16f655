// SPDX-License-Identifier: LGPL-2.1-or-later
// Vibrations in the form of Apple's Core Haptics, AHAP (Apple Haptic and Audio Pattern 1.0).
#pragma once

#include <span>
#include <string>

namespace haptic {

/// Frames of a vibration, interleaved.
struct Vibration {
  std::span<const float> samples; ///< full scale 1
  int channels = 1;
  int rate = 1; ///< frames a second
};

/// Returns the energy of all channels as intensity over time, of one actuator: continuous events of
/// at most 30 s, whose intensity is a curve of lines that is never off by more than 0.02, and a
/// transient event for what lasts less than 50 ms. The carrier and the places are lost: a telephone
/// has its own. `carrier` in Hz.
std::string write_ahap(const Vibration &vibration, double carrier);

} // namespace haptic
