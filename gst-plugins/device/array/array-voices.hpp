// SPDX-License-Identifier: LGPL-2.1-or-later
// The vibrations of an array: a carrier for each actuator, whose amplitude follows a wanted one
// within the limits of safety.
#pragma once

#include "array/array-layout.hpp"
#include "safety/continuous-force.hpp"

#include <complex>
#include <span>
#include <vector>

namespace haptic {

struct VoiceLimits {
  double level = 1;            ///< highest amplitude, of full scale
  double continuous_level = 0; ///< rms of the amplitude over a minute, of full scale; 0: any
};

/// One thread; never allocates after construction.
class ArrayVoices {
public:
  /// Frames from one amplitude to the next.
  static constexpr int kStep = 64;
  /// The amplitude changes by no more than this, of full scale per second: 20 ms from 0 to 1.
  static constexpr double kSlew = 50;

  /// `rate` in frames a second.
  ArrayVoices(const ArrayLayout &layout, int rate);

  /// Makes kStep frames, interleaved, full scale 1: from the amplitudes of before to `wanted`
  /// (0..1, one for each actuator, before its gain) along a raised cosine, so that nothing clicks.
  /// An amplitude that is not finite counts as 0. A voice whose amplitude is 0 is digital zero.
  void make(std::span<const double> wanted, const VoiceLimits &limits, std::span<float> frames);

  /// Goes on with another rate. Amplitudes and what is left of the budgets are kept.
  void set_rate(int rate) noexcept;

  /// Whether all amplitudes are 0.
  bool silent() const noexcept;

  /// Begins anew from silence, after nothing was made for so many seconds. What is left of the
  /// budgets is kept.
  void restart(double rested = 0) noexcept;

private:
  struct Voice {
    std::complex<float> phasor{1, 0};
    std::complex<float> turn; // from frame to frame
    double carrier;           // Hz
    double gain;
    double amplitude = 0;
    ContinuousForce budget; // of an amplitude instead of a force
  };

  std::vector<Voice> voices_;
  std::vector<float> blend_; // 0 to 1 over kStep frames
  double step_time_ = 0;     // s
};

} // namespace haptic
