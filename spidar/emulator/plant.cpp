// SPDX-License-Identifier: LGPL-2.1-or-later
#include "plant.hpp"

#include <algorithm>

namespace emulator {

namespace {

using Seconds = std::chrono::duration<double>;

// Half of the host's period: the words of one exchange have moved the grip at the next.
constexpr auto kStep = std::chrono::microseconds(500);
constexpr auto kQuestionStep = std::chrono::milliseconds(1);

// To catch up with a longer silence would make the next reply late.
constexpr auto kLongestGap = std::chrono::milliseconds(20);

} // namespace

Plant::Plant(const spidar::Geometry &geometry, std::unique_ptr<spidar::HandScript> hand, Pace pace)
    : pace_(pace), dac_limit_(geometry.dac_limit),
      wired_(geometry.button ? static_cast<std::uint16_t>(1U << geometry.button->bit) : 0),
      simulator_(std::make_unique<spidar::Simulator>(
          geometry, std::move(hand),
          Seconds(pace == Pace::question ? Seconds(kQuestionStep) : Seconds(kStep)).count())) {}

void Plant::advance(Time now) {
  if (!started_) {
    started_ = true;
    simulated_ = now;
    simulator_->exchange(words_, counts_);
  }
  simulated_ = std::max(simulated_, now - kLongestGap);
  for (; simulated_ + kStep <= now; simulated_ += kStep)
    simulator_->exchange(words_, counts_);
}

void Plant::set(const spidar::DacWords &words, Time now) {
  if (pace_ == Pace::machine_clock)
    advance(now);
  for (std::size_t i = 0; i < spidar::kStrings; ++i)
    words_[i] =
        static_cast<std::int16_t>(std::clamp(static_cast<int>(words[i]), -dac_limit_, dac_limit_));
}

const spidar::Counts &Plant::counts(Time now) {
  if (pace_ == Pace::machine_clock)
    advance(now);
  else
    simulator_->exchange(words_, counts_);
  return counts_;
}

} // namespace emulator
