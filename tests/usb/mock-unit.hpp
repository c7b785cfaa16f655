// SPDX-License-Identifier: LGPL-2.1-or-later
// A SPIDAR-G controller without the wires: takes OUT packets, queues IN packets. Behind it the
// simulator's plant, and whatever a test wants to go wrong.
//
// Written from the description of the protocol and not with the library's own parser, so that one
// mistake is not made twice.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <spidar/simulator.hpp>
#include <vector>

namespace test {

using Bytes = std::vector<std::uint8_t>;

enum class Model { simple, sh4 };

/// What may be wrong with a unit; a test changes it while the unit works.
struct Faults {
  bool silent = false;                        ///< takes packets, answers none
  bool blocked = false;                       ///< does not even take packets (NAK)
  int stalls = 0;                             ///< so many replies are a stall instead
  int late_replies = 0;                       ///< so many replies come with the next one
  bool frozen = false;                        ///< the counters stand still
  spidar::Counts disturbance{};               ///< added to the counters
  std::function<void(Bytes &)> mangle{};      ///< has its way with every reply
  std::function<void(const Bytes &)> watch{}; ///< sees every packet that goes out
};

class MockUnit {
public:
  /// Its hand begins in the centre.
  MockUnit(Model model, int rotary_switch);
  ~MockUnit();

  Model model() const noexcept { return model_; }
  /// Changes the faults, or looks at them, between two packets.
  template <class Change>
  void faults(Change change) {
    const std::lock_guard lock(mutex_);
    change(faults_);
  }
  /// In -1..1 of the half workspace.
  void move_hand(const spidar::Vector3 &target);
  spidar::DacWords words() const;  ///< at the motors now
  spidar::Pose pose() const;       ///< of the grip, truly
  std::uint64_t exchanges() const; ///< replies asked for
  void leave_reply(Bytes bytes);   ///< unread by a program before

  // The bus.

  bool blocked() const;
  void take(const Bytes &packet);
  struct Answer {
    bool stall = false;
    Bytes bytes;
  };
  bool has_answer() const;
  Answer answer();
  void clear_halt();

private:
  void latch();
  Bytes reply_of(const spidar::Counts &counts);

  const Model model_;
  const int switch_;
  mutable std::mutex mutex_;
  class Hand;
  Hand *hand_; ///< the plant owns it
  Faults faults_;
  spidar::Simulator plant_;
  spidar::Counts counts_{};
  spidar::Counts origin_{}; ///< what `clear` takes for zero
  spidar::DacWords words_{};
  std::deque<Bytes> replies_;
  std::deque<Bytes> held_back_;
  bool stalled_ = false;
  std::uint64_t exchanges_ = 0;
  std::uint32_t noise_ = 12345;
};

} // namespace test
