// SPDX-License-Identifier: LGPL-2.1-or-later
#include "firmware.hpp"

#include <algorithm>
#include <utility>

namespace emulator {

using spidar::kStrings;

namespace {

constexpr std::size_t kMostReplies = 64; // further requests get no reply
constexpr std::size_t kShortReply = 7;   // no counter of either model is complete in it
constexpr int kStaleReplies = 3;
constexpr Time kWithTheNextReply = Time::max();

void put(Bytes &packet, std::size_t offset, std::uint32_t value, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i)
    packet[offset + i] = static_cast<std::uint8_t>(value >> 8 * i & 0xff);
}

} // namespace

Firmware::Firmware(Model model, int rotary_switch, Plant plant, unsigned seed, Listener listener)
    : model_(model), rotary_switch_(rotary_switch), plant_(std::move(plant)),
      listener_(std::move(listener)), random_(seed) {
  std::generate(noise_.begin(), noise_.end(),
                [this] { return static_cast<std::uint8_t>(random_() & 0xff); });
}

std::size_t Firmware::packet_size() const noexcept {
  return model_ == Model::simple ? 32 : 512; // [1.B], [1.C]
}

std::uint32_t Firmware::counter_range() const noexcept {
  return model_ == Model::simple ? 1U << 24 : 1U << 16; // [1.B], [1.C]
}

void Firmware::power_on(Time now) {
  words_ = {};
  plant_.set(words_, now);
  faults_ = {};
  followed_ = plant_.counts(now);
  directions_ = 0;
  randomise_counters();
  frozen_ = {};
  replies_.clear();
}

void Firmware::report(const std::string &event, Time now) const {
  if (listener_)
    listener_(now, event, words_);
}

bool Firmware::takes_packets() const noexcept {
  return !faults_.refuse_out && (faults_.most_unread == 0 || replies_.size() < faults_.most_unread);
}

void Firmware::receive(std::span<const std::uint8_t> packet, Time now) {
  if (faults_.watch)
    faults_.watch(packet);
  if (packet.size() != packet_size())
    return;
  if (model_ == Model::simple) {
    receive_simple(packet, now);
  } else if (packet[0] == 0x01 && packet[1] == 0x0e) {
    set_words(packet.subspan(2), now);
    queue_reply(now);
  }
}

void Firmware::receive_simple(std::span<const std::uint8_t> packet, Time now) {
  if (packet[0] == 0x52) {
    set_words(packet.subspan(1), now);
  } else if (packet[0] == 0x51) {
    queue_reply(now);
  } else if (packet[0] == 0xa2 && packet[1] == 0x1a) {
    update_counters(now);
    directions_ = packet[2];
  } else if (packet[0] == 0xa2 && packet[1] == 0x19) {
    update_counters(now);
    for (std::size_t i = 0; i < kStrings; ++i)
      if ((packet[2] >> i & 1) != 0)
        counters_[i] = 0;
  }
}

void Firmware::set_words(std::span<const std::uint8_t> bytes, Time now) {
  for (std::size_t i = 0; i < kStrings; ++i)
    words_[i] = static_cast<std::int16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
  plant_.set(words_, now);
  report("words", now);
}

/// Lets the counters follow the plant up to now.
void Firmware::update_counters(Time now) {
  const spidar::Counts &counts = plant_.counts(now);
  for (std::size_t i = 0; i < kStrings; ++i) {
    const std::uint32_t count =
        static_cast<std::uint32_t>(counts[i]) + static_cast<std::uint32_t>(faults_.offset[i]);
    const std::uint32_t change = count - static_cast<std::uint32_t>(followed_[i]);
    const bool forward = model_ == Model::simple && (directions_ >> i & 1) != 0;
    counters_[i] = (forward ? counters_[i] + change : counters_[i] - change) % counter_range();
    followed_[i] = static_cast<std::int32_t>(count);
  }
}

void Firmware::randomise_counters() {
  for (std::uint32_t &counter : counters_)
    counter = static_cast<std::uint32_t>(random_() % counter_range());
}

/// From a random place in the noise: to draw each byte anew would take longer than all the rest.
Bytes Firmware::random_packet() {
  const auto begin =
      noise_.begin() + static_cast<std::ptrdiff_t>(random_() % (noise_.size() - packet_size()));
  return {begin, begin + static_cast<std::ptrdiff_t>(packet_size())};
}

Bytes Firmware::make_reply() {
  Bytes packet = random_packet();
  for (std::size_t i = 0; i < kStrings; ++i) {
    const std::uint32_t counter = frozen_[i].value_or(counters_[i]);
    if (model_ == Model::simple) {
      put(packet, 3 * i, counter, 3);
    } else {
      put(packet, 2 * i, static_cast<std::uint16_t>(words_[i]), 2);
      put(packet, 16 + 2 * i, counter, 2);
    }
  }
  std::uint8_t &byte = packet[model_ == Model::simple ? 24 : 48];
  byte =
      static_cast<std::uint8_t>(static_cast<unsigned>(rotary_switch_) << 4 | (inputs(byte) & 0x0f));
  return packet;
}

/// The lower half of the byte is for buttons [1.B]. A pin is `unknown` if nothing is wired to it.
unsigned Firmware::inputs(unsigned unknown) const noexcept {
  const unsigned wired = (unknown & ~unsigned{plant_.wired()}) | plant_.inputs();
  return (wired & ~set_inputs_) | levels_;
}

void Firmware::queue_reply(Time now) {
  update_counters(now);
  if (faults_.silent || replies_.size() >= kMostReplies)
    return;
  Reply reply{make_reply(), now + faults_.late_by};
  if (faults_.mangle)
    faults_.mangle(reply.bytes);
  if (faults_.short_replies > 0) {
    --faults_.short_replies;
    reply.bytes.resize(std::min(reply.bytes.size(), kShortReply));
  }
  if (faults_.stalled_replies > 0) {
    --faults_.stalled_replies;
    reply.stall = true;
  }
  if (faults_.held_replies > 0) {
    --faults_.held_replies;
    reply.due = kWithTheNextReply;
  } else {
    for (Reply &held : replies_)
      if (held.due == kWithTheNextReply)
        held.due = reply.due;
  }
  replies_.push_back(std::move(reply));
}

void Firmware::queue_stale_reply(Bytes bytes, Time now) {
  replies_.push_back({std::move(bytes), now});
}

std::optional<Time> Firmware::next_reply() const {
  if (replies_.empty() || replies_.front().due == kWithTheNextReply)
    return std::nullopt;
  return replies_.front().due;
}

Firmware::Reply Firmware::fetch_reply() {
  Reply reply = std::move(replies_.front());
  replies_.pop_front();
  return reply;
}

void Firmware::freeze(std::size_t string, Time now) {
  update_counters(now);
  frozen_[string] = counters_[string];
}

void Firmware::jump(std::size_t string, std::int32_t counts) {
  counters_[string] = (counters_[string] + static_cast<std::uint32_t>(counts)) % counter_range();
}

void Firmware::set_input(int pin, bool level) noexcept {
  const unsigned bit = 1U << pin;
  set_inputs_ |= bit;
  levels_ = level ? levels_ | bit : levels_ & ~bit;
}

void Firmware::near_wrap(Time now) {
  update_counters(now);
  // A signed counter ends in the middle of the range, an unsigned one at its top.
  for (std::size_t i = 0; i < kStrings; ++i)
    counters_[i] = i % 2 == 0 ? counter_range() / 2 - 1 : counter_range() - 1;
}

void Firmware::garbage(Time now) {
  update_counters(now);
  randomise_counters();
  for (int i = 0; i < kStaleReplies; ++i)
    queue_stale_reply(random_packet(), now);
}

} // namespace emulator
