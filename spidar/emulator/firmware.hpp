// SPDX-License-Identifier: LGPL-2.1-or-later
// A model of the controllers' firmware: packets of the host in, replies out, with faults on demand.
// The emulator and the tests of the USB driver use the same model.
//
// It is written from the published description of the protocol and cannot include the library's
// usb-protocol.hpp: a mistake in one of them shows against the other. Marks such as [1.B] name the
// section of that description. All numbers on the wire are little-endian.
//
// USB2.0 Simple, 0cec:0203 [1.B], 32 bytes each way:
//   OUT 52 d0L d0H .. d7L d7H      sets all D/A words, 16 bit signed
//   OUT 51                         latches the counters: one reply
//   OUT A2 1A mm                   bit i of mm: counter i counts as the geometry does
//   OUT A2 19 mm                   bit i of mm: clears counter i
//   IN  bytes 3i..3i+2             counter i, 24 bit; byte 24: bits 7..4 rotary switch,
//                                  bits 3..0 input pins
//
// USB2.0 SH4, 0cec:0205 [1.C], 512 bytes each way:
//   OUT 01 0E d0L d0H .. d7L d7H   sets all D/A words, and latches the counters: one reply
//   IN  bytes 0..15                the D/A words; bytes 16+2i, 17+2i: counter i, 16 bit, counts
//                                  against the geometry; byte 48 as byte 24 above
//
// Where the real firmware is not known [9], the model behaves so that a host cannot rely on it:
// bytes without a known meaning are random; counters start at random values; a USB2.0 Simple counts
// against the geometry until the host sets the direction; unknown packets are ignored; unread
// replies stay queued [8]; D/A words stay until the next ones or the loss of power.
//
// Times are of any monotonic clock, as long as it is always the same. One thread.
#pragma once

#include "plant.hpp"

#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace emulator {

using Bytes = std::vector<std::uint8_t>;

enum class Model { simple, sh4 };

inline constexpr std::uint16_t kVendorId = 0x0cec;     // [1]
inline constexpr std::uint8_t kBulkOut = 0x02;         // [1.B], [1.C]
inline constexpr std::uint8_t kBulkIn = 0x86;          // [1.B], [1.C]
inline constexpr std::size_t kLargestBulkPacket = 512; // [1.B]: high speed

constexpr std::uint16_t product_id(Model model) noexcept {
  return model == Model::simple ? 0x0203 : 0x0205; // [1]
}

/// Faults. A number counts down to 0; the others stay until they are changed.
struct Faults {
  bool refuse_out = false;               ///< the OUT endpoint answers NAK: transfers wait
  std::size_t most_unread = 0;           ///< takes no packet while so many replies wait; 0: any
  bool silent = false;                   ///< takes packets, never replies
  int stalled_replies = 0;               ///< this many replies halt the IN endpoint instead
  int short_replies = 0;                 ///< this many replies are cut to 7 bytes
  int held_replies = 0;                  ///< this many replies come together with the next one
  std::chrono::microseconds late_by{0};  ///< replies come this much later
  spidar::Counts offset{};               ///< added to the counts, in the geometry's direction
  std::function<void(Bytes &)> mangle{}; ///< changes every reply
  std::function<void(std::span<const std::uint8_t>)> watch{}; ///< sees every packet of the host
};

class Firmware {
public:
  /// Hears of every change of the D/A words ("words") and of every reported event.
  using Listener = std::function<void(Time, const std::string &, const spidar::DacWords &)>;

  /// `rotary_switch` 0..15 [1.B]. `seed` of all that is random.
  Firmware(Model model, int rotary_switch, Plant plant, unsigned seed, Listener listener = {});

  Model model() const noexcept { return model_; }
  int rotary_switch() const noexcept { return rotary_switch_; }
  void set_rotary_switch(int number) noexcept { rotary_switch_ = number; }

  /// No tension, random counters, no replies, no faults.
  void power_on(Time now);

  /// Whether it takes a packet now.
  bool takes_packets() const noexcept;

  /// Handles one packet of the host.
  void receive(std::span<const std::uint8_t> packet, Time now);

  struct Reply {
    Bytes bytes;
    Time due;
    bool stall = false; ///< halts the IN endpoint instead of being sent
  };
  /// Due time of the oldest reply, or nothing if there is none.
  std::optional<Time> next_reply() const;
  /// Removes and returns the oldest reply. There must be one.
  Reply fetch_reply();
  /// Queues a reply that nobody asked for.
  void queue_stale_reply(Bytes bytes, Time now);

  const spidar::DacWords &words() const noexcept { return words_; } ///< at the motors
  const Plant &plant() const noexcept { return plant_; }
  void report(const std::string &event, Time now) const;

  Faults &faults() noexcept { return faults_; }
  const Faults &faults() const noexcept { return faults_; }
  void freeze(std::size_t string, Time now); ///< its counter stands still
  void thaw() { frozen_ = {}; }              ///< all counters continue with their true values
  void jump(std::size_t string, std::int32_t counts);
  /// Input pin 0..3 reads `level` from now on, whatever the hand does.
  void set_input(int pin, bool level) noexcept;
  void near_wrap(Time now); ///< every counter one step below an end of its range
  void garbage(Time now);   ///< random counters, and three random replies

private:
  std::size_t packet_size() const noexcept;
  std::uint32_t counter_range() const noexcept;
  void receive_simple(std::span<const std::uint8_t> packet, Time now);
  void set_words(std::span<const std::uint8_t> bytes, Time now);
  void queue_reply(Time now);
  Bytes make_reply();
  unsigned inputs(unsigned unknown) const noexcept;
  Bytes random_packet();
  void randomise_counters();
  void update_counters(Time now);

  Model model_;
  int rotary_switch_;
  Plant plant_;
  Listener listener_;
  std::mt19937 random_;
  std::array<std::uint8_t, 1024> noise_{};
  spidar::DacWords words_{};
  spidar::Counts followed_{}; ///< counts of the plant that the counters have followed
  std::array<std::uint32_t, spidar::kStrings> counters_{};
  std::array<std::optional<std::uint32_t>, spidar::kStrings> frozen_;
  std::uint8_t directions_ = 0; ///< bit i: counter i counts as the geometry does
  unsigned set_inputs_ = 0;     ///< the pins of set_input(),
  unsigned levels_ = 0;         ///< and their levels
  std::deque<Reply> replies_;
  Faults faults_;
};

} // namespace emulator
