// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mock-unit.hpp"

namespace test {

class MockUnit::Hand final : public spidar::HandScript {
public:
  bool target(double, const spidar::Vector3 &workspace_half,
              spidar::Vector3 &target) const noexcept override {
    target = place.cwiseProduct(workspace_half);
    return true;
  }
  spidar::Vector3 place = spidar::Vector3::Zero();
};

MockUnit::MockUnit(Model model, int rotary_switch)
    : model_(model), hand_(new Hand),
      unit_(1, {model, rotary_switch,
                emulator::Plant(spidar::load_geometry(spidar::kDefaultGeometry),
                                std::unique_ptr<spidar::HandScript>(hand_),
                                emulator::Plant::Pace::question),
                1}) {
  unit_.plug(emulator::Clock::now());
}

void MockUnit::move_hand(const spidar::Vector3 &target) {
  const std::lock_guard lock(mutex_);
  hand_->place = target;
}

spidar::DacWords MockUnit::words() const {
  const std::lock_guard lock(mutex_);
  return unit_.firmware().words();
}

spidar::Pose MockUnit::pose() const {
  const std::lock_guard lock(mutex_);
  return unit_.firmware().plant().pose();
}

void MockUnit::leave_reply(Bytes bytes) {
  const std::lock_guard lock(mutex_);
  unit_.firmware().queue_stale_reply(std::move(bytes), emulator::Clock::now());
}

} // namespace test
