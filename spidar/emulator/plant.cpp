// SPDX-License-Identifier: LGPL-2.1-or-later
#include "plant.hpp"

#include <algorithm>

namespace emulator {

namespace {

// A half of the host's tick, so that what it sets is felt at the next.
constexpr auto kStep = std::chrono::microseconds(500);
constexpr double kStepSeconds = std::chrono::duration<double>(kStep).count();

// A longer time without a question is not made up for: the answer to the next one would be late.
constexpr auto kLongestGap = std::chrono::milliseconds(20);

} // namespace

Plant::Plant(const spidar::Geometry &geometry, std::unique_ptr<spidar::HandScript> hand)
    : dac_limit_(geometry.dac_limit),
      simulator_(std::make_unique<spidar::Simulator>(geometry, std::move(hand), kStepSeconds)) {}

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
  advance(now);
  for (std::size_t i = 0; i < spidar::kStrings; ++i)
    words_[i] =
        static_cast<std::int16_t>(std::clamp(static_cast<int>(words[i]), -dac_limit_, dac_limit_));
}

const spidar::Counts &Plant::counts(Time now) {
  advance(now);
  return counts_;
}

} // namespace emulator
