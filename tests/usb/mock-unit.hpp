// SPDX-License-Identifier: LGPL-2.1-or-later
// A SPIDAR-G for MockBus: the emulator's model of a controller, moved by the question and not by
// the clock, with a hand that a test moves. Any thread.
#pragma once

#include "unit.hpp"

#include <memory>
#include <mutex>

namespace test {

using emulator::Bytes;
using emulator::Faults;
using emulator::Model;

class MockUnit {
public:
  /// Switched on, its hand in the centre.
  MockUnit(Model model, int rotary_switch);

  Model model() const noexcept { return model_; }

  /// Calls `use` with the emulator::Unit, between two transfers.
  template <class Use>
  auto use(Use use) {
    const std::lock_guard lock(mutex_);
    return use(unit_);
  }
  /// Calls `change` with the firmware's Faults, between two packets.
  template <class Change>
  void faults(Change change) {
    const std::lock_guard lock(mutex_);
    change(unit_.firmware().faults());
  }

  void move_hand(const spidar::Vector3 &target); ///< -1..1 of the half workspace
  spidar::DacWords words() const;                ///< at the motors
  spidar::Pose pose() const;                     ///< true pose of the grip
  void leave_reply(Bytes bytes);                 ///< as a program before would have left it unread

private:
  class Hand;

  const Model model_;
  mutable std::mutex mutex_;
  Hand *hand_; ///< belongs to the simulator in unit_
  emulator::Unit unit_;
};

} // namespace test
