// SPDX-License-Identifier: LGPL-2.1-or-later
#include "board.hpp"

#include "usb-protocol.hpp"

#include <algorithm>

namespace emulator {

using spidar::kStrings;

namespace {

constexpr std::uint8_t kSetWords = 0x52;
constexpr std::uint8_t kLatch = 0x51;
constexpr std::uint8_t kControl = 0xa2;
constexpr std::uint8_t kDirection = 0x1a;
constexpr std::uint8_t kClear = 0x19;
constexpr std::uint8_t kUpdate = 0x01;
constexpr std::uint8_t kBaseAnalyzer = 0x0e;

constexpr std::size_t kMostReplies = 64; // what a host asks for beyond that gets no answer
constexpr std::size_t kShortReply = 7;   // too short for any counter to be whole and right
constexpr int kStaleReplies = 3;

void put(std::vector<std::uint8_t> &packet, std::size_t offset, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i)
    packet[offset + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value >> 8 * i & 0xff);
}

} // namespace

Board::Board(Model model, int rotary_switch, Plant plant, int unit, WordLog *log)
    : model_(model), rotary_switch_(rotary_switch), plant_(std::move(plant)), unit_(unit),
      log_(log), random_(static_cast<std::mt19937::result_type>(unit)) {
  std::generate(noise_.begin(), noise_.end(),
                [this] { return static_cast<std::uint8_t>(random_() & 0xff); });
}

void Board::power_on(Time now) {
  words_ = {};
  plant_.set(words_, now);
  before_ = plant_.counts(now);
  directions_ = 0;
  for (std::uint32_t &counter : counters_)
    counter = static_cast<std::uint32_t>(random_() % range());
  frozen_ = {};
  replies_.clear();
  short_replies_ = 0;
  delay_ = {};
}

std::uint32_t Board::range() const noexcept {
  return 1U << (model_ == Model::simple ? spidar::simple::kCounterBits : spidar::sh4::kCounterBits);
}

void Board::note(const std::string &event, Time now) {
  if (log_)
    log_->add(now, unit_, event, words_);
}

void Board::take(std::span<const std::uint8_t> packet, Time now) {
  if (model_ == Model::sh4) {
    if (packet.size() == spidar::sh4::kPacket && packet[0] == kUpdate &&
        packet[1] == kBaseAnalyzer) {
      set_words(packet.subspan(2), now);
      queue_reply(now);
    }
    return;
  }
  if (packet.size() != spidar::simple::kPacket)
    return;
  if (packet[0] == kSetWords) {
    set_words(packet.subspan(1), now);
  } else if (packet[0] == kLatch) {
    queue_reply(now);
  } else if (packet[0] == kControl && packet[1] == kDirection) {
    count(now);
    directions_ = packet[2];
  } else if (packet[0] == kControl && packet[1] == kClear) {
    count(now);
    for (std::size_t i = 0; i < kStrings; ++i)
      if ((packet[2] >> i & 1) != 0)
        counters_[i] = 0;
  }
}

void Board::set_words(std::span<const std::uint8_t> bytes, Time now) {
  for (std::size_t i = 0; i < kStrings; ++i)
    words_[i] = static_cast<std::int16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
  plant_.set(words_, now);
  note("words", now);
}

/// The counters as they are now.
void Board::count(Time now) {
  const spidar::Counts &counts = plant_.counts(now);
  for (std::size_t i = 0; i < kStrings; ++i) {
    const auto change =
        static_cast<std::uint32_t>(counts[i]) - static_cast<std::uint32_t>(before_[i]);
    const bool forward = model_ == Model::simple && (directions_ >> i & 1) != 0;
    counters_[i] = (forward ? counters_[i] + change : counters_[i] - change) % range();
  }
  before_ = counts;
}

std::uint32_t Board::counter(std::size_t string) const {
  return frozen_[string].value_or(counters_[string]);
}

std::vector<std::uint8_t> Board::random_packet() {
  // From anywhere in the noise: drawing each byte anew would take longer than all the rest.
  const std::size_t size = model_ == Model::simple ? spidar::simple::kPacket : spidar::sh4::kPacket;
  const auto begin =
      noise_.begin() + static_cast<std::ptrdiff_t>(random_() % (noise_.size() - size));
  return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

void Board::queue_reply(Time now) {
  if (replies_.size() >= kMostReplies)
    return;
  count(now);
  std::vector<std::uint8_t> packet = random_packet();
  const auto switches = static_cast<std::uint8_t>(rotary_switch_ << 4);
  for (std::size_t i = 0; i < kStrings; ++i) {
    if (model_ == Model::simple) {
      put(packet, 3 * i, counter(i), 3);
    } else {
      put(packet, 2 * i, static_cast<std::uint16_t>(words_[i]), 2);
      put(packet, 16 + 2 * i, counter(i), 2);
    }
  }
  // The switch is in the upper half of the byte; the lower half is for buttons.
  std::uint8_t &byte = packet[model_ == Model::simple ? 24 : 48];
  byte = static_cast<std::uint8_t>(switches | (byte & 0x0f));
  if (short_replies_ > 0) {
    --short_replies_;
    packet.resize(kShortReply);
  }
  replies_.push_back({std::move(packet), now + delay_});
}

std::optional<Time> Board::next_reply() const {
  if (replies_.empty())
    return std::nullopt;
  return replies_.front().due;
}

void Board::freeze(std::size_t string, Time now) {
  count(now);
  frozen_[string] = counters_[string];
}

void Board::jump(std::size_t string, std::int32_t counts) {
  counters_[string] = (counters_[string] + static_cast<std::uint32_t>(counts)) % range();
}

void Board::near_wrap(Time now) {
  count(now);
  // A signed counter ends in the middle of the range, an unsigned one at its top.
  for (std::size_t i = 0; i < kStrings; ++i)
    counters_[i] = i % 2 == 0 ? range() / 2 - 1 : range() - 1;
}

void Board::garbage(Time now) {
  count(now);
  for (std::uint32_t &counter : counters_)
    counter = static_cast<std::uint32_t>(random_() % range());
  for (int i = 0; i < kStaleReplies; ++i)
    replies_.push_back({random_packet(), now});
}

} // namespace emulator
