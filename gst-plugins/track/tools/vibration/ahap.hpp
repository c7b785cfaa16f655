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

/// Measures the amplitude of a vibration as it comes: the energy of all its channels over windows
/// of two periods of the carrier, in their middles.
class IntensityMeter {
public:
  /// `rate`: frames a second; `carrier` in Hz.
  IntensityMeter(int channels, int rate, double carrier);

  /// Adds frames, interleaved; full scale 1.
  void push(std::span<const float> samples);
  const std::vector<Intensity> &intensities() const noexcept { return intensities_; }

private:
  std::size_t samples_; // of a window, of all channels
  double window_;       // s
  double channels_;
  std::size_t count_ = 0; // samples of the window that comes
  double squares_ = 0;    // their sum
  std::vector<Intensity> intensities_;
};

/// Returns the intensity over time, of one actuator: continuous events of at most 30 s, whose
/// intensity is a curve of lines, and a transient event for what lasts less than 50 ms. Intensity
/// is the square root of the amplitude, as in Meta's converter of .haptic files to AHAP; Apple
/// names no curve. The amplitude that a player makes of it is never off by more than 0.02. The
/// carrier and the places are lost: a telephone has its own.
std::string write_ahap(std::span<const Intensity> all);

} // namespace haptic
