// SPDX-License-Identifier: LGPL-2.1-or-later
#include "array/array-voices.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptic {

namespace {
constexpr double kPi = std::numbers::pi;
} // namespace

ArrayVoices::ArrayVoices(const ArrayLayout &layout, int rate) : blend_(kStep) {
  for (const Actuator &actuator : layout.actuators)
    voices_.push_back({.carrier = actuator.carrier, .gain = actuator.gain});
  set_rate(rate);
  for (int i = 0; i < kStep; ++i)
    blend_[static_cast<std::size_t>(i)] =
        static_cast<float>((1 - std::cos(kPi * (i + 1) / kStep)) / 2);
}

void ArrayVoices::set_rate(int rate) noexcept {
  step_time_ = static_cast<double>(kStep) / rate;
  for (Voice &voice : voices_) {
    const double angle = 2 * kPi * voice.carrier / rate;
    voice.turn = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  }
}

void ArrayVoices::make(std::span<const double> wanted, const VoiceLimits &limits,
                       std::span<float> frames) {
  const double slew = kSlew * step_time_;
  const std::size_t count = voices_.size();
  for (std::size_t i = 0; i < count; ++i) {
    Voice &voice = voices_[i];
    const double budget = voice.budget.step(voice.amplitude, limits.continuous_level, step_time_);
    const double highest = std::min({1.0, limits.level, limits.continuous_level > 0 ? budget : 1});
    const double target = std::isfinite(wanted[i]) ? std::clamp(wanted[i], 0.0, highest) : 0;
    const double next = std::clamp(target, voice.amplitude - slew, voice.amplitude + slew);
    const auto from = static_cast<float>(voice.gain * voice.amplitude);
    const auto change = static_cast<float>(voice.gain * (next - voice.amplitude));
    voice.amplitude = next;
    if (from == 0 && change == 0) {
      voice.phasor = {1, 0}; // the next vibration begins at a zero
      for (std::size_t frame = 0; frame < kStep; ++frame)
        frames[frame * count + i] = 0;
      continue;
    }
    std::complex<float> phasor = voice.phasor;
    for (std::size_t frame = 0; frame < kStep; ++frame) {
      // Written out: the product of the library also looks for numbers that are not finite.
      phasor = {phasor.real() * voice.turn.real() - phasor.imag() * voice.turn.imag(),
                phasor.real() * voice.turn.imag() + phasor.imag() * voice.turn.real()};
      frames[frame * count + i] = (from + change * blend_[frame]) * phasor.imag();
    }
    voice.phasor = phasor / std::abs(phasor); // rounding must not add up
  }
}

bool ArrayVoices::silent() const noexcept {
  return std::ranges::all_of(voices_, [](const Voice &voice) { return voice.amplitude == 0; });
}

void ArrayVoices::restart(double rested) noexcept {
  for (Voice &voice : voices_) {
    voice.budget.step(0, rested);
    voice.amplitude = 0;
    voice.phasor = {1, 0};
  }
}

} // namespace haptic
