// SPDX-License-Identifier: LGPL-2.1-or-later
// The controller as its firmware behaves: packets in, packets out, with faults on command.
//
// What is not known of the real ones is assumed here so that a host cannot rely on it: bytes
// without a known meaning are random; counters start anywhere; before the host says otherwise, the
// USB2.0 Simple counts the other way round; packets that mean nothing are ignored; replies that
// nobody fetched stay; D/A words stay until the next ones come, or power is lost.
#pragma once

#include "plant.hpp"

#include <deque>
#include <optional>
#include <random>
#include <span>
#include <vector>

namespace emulator {

enum class Model { simple, sh4 };

class Board {
public:
  /// `log` may be null and outlives the board; `unit` is its number there.
  Board(Model model, int rotary_switch, Plant plant, int unit, WordLog *log);

  Model model() const noexcept { return model_; }
  int rotary_switch() const noexcept { return rotary_switch_; }

  /// No tension, counters anywhere, nothing to say.
  void power_on(Time now);

  /// A packet of the host, at most 512 bytes.
  void take(std::span<const std::uint8_t> packet, Time now);

  /// When the next reply is ready, if there is one; the reply; done with it.
  std::optional<Time> next_reply() const;
  const std::vector<std::uint8_t> &reply() const { return replies_.front().bytes; }
  void drop_reply() { replies_.pop_front(); }

  void note(const std::string &event, Time now);

  // Faults. Strings count from 0.
  void shorten(int replies) { short_replies_ = replies; }
  void delay(std::chrono::milliseconds time) { delay_ = time; }
  void freeze(std::size_t string, Time now);
  void thaw() { frozen_ = {}; }
  void jump(std::size_t string, std::int32_t counts);
  void set_rotary_switch(int number) { rotary_switch_ = number; }
  void near_wrap(Time now); ///< every counter one step below an end of its range
  void garbage(Time now);   ///< counters anywhere, and replies nobody asked for

private:
  struct Reply {
    std::vector<std::uint8_t> bytes;
    Time due;
  };

  void set_words(std::span<const std::uint8_t> bytes, Time now);
  void queue_reply(Time now);
  void count(Time now);
  std::uint32_t counter(std::size_t string) const;
  std::uint32_t range() const noexcept;
  std::vector<std::uint8_t> random_packet();

  Model model_;
  int rotary_switch_;
  Plant plant_;
  int unit_;
  WordLog *log_;
  std::mt19937 random_;
  std::array<std::uint8_t, 1024> noise_{};
  spidar::DacWords words_{};
  spidar::Counts before_{}; ///< the plant's counts that the counters have followed
  std::array<std::uint32_t, spidar::kStrings> counters_{};
  std::array<std::optional<std::uint32_t>, spidar::kStrings> frozen_;
  std::uint8_t directions_ = 0; ///< bit i: counter i counts as the geometry does
  std::deque<Reply> replies_;
  int short_replies_ = 0;
  std::chrono::milliseconds delay_{0};
};

} // namespace emulator
