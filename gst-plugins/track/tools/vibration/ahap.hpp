// SPDX-License-Identifier: LGPL-2.1-or-later
// Vibrations in the form of Apple's Core Haptics, AHAP (Apple Haptic and Audio Pattern 1.0).
#pragma once

#include <span>
#include <string>
#include <vector>

namespace haptic {

struct Intensity {
  double time = 0;      ///< s
  double amplitude = 0; ///< 0..1, of the carrier
};

/// Returns the amplitude of some periods of a vibration, interleaved, full scale 1: by the energy
/// of all its channels.
double amplitude_of(std::span<const float> samples, int channels);

/// Returns the intensity over time, of one actuator: continuous events of at most 30 s, whose
/// intensity is a curve of lines, and a transient event for what lasts less than 50 ms. Intensity
/// is the square root of the amplitude, as in Meta's converter of .haptic files to AHAP; Apple
/// names no curve. The amplitude that a player makes of it is never off by more than 0.02. The
/// carrier and the places are lost: a telephone has its own.
std::string write_ahap(std::span<const Intensity> all);

} // namespace haptic
