// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mock-unit.hpp"

namespace test {

namespace {

constexpr std::uint32_t kPowerOnCount = 0xfff0; // near the wrap of 16 bits

std::int16_t word_at(const Bytes &packet, std::size_t offset) {
  return static_cast<std::int16_t>(packet[offset] | packet[offset + 1] << 8);
}

} // namespace

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
    : model_(model), switch_(rotary_switch), hand_(new Hand),
      plant_(spidar::load_geometry(spidar::kDefaultGeometry),
             std::unique_ptr<spidar::HandScript>(hand_)) {}

MockUnit::~MockUnit() = default;

void MockUnit::move_hand(const spidar::Vector3 &target) {
  const std::lock_guard lock(mutex_);
  hand_->place = target;
}

spidar::DacWords MockUnit::words() const {
  const std::lock_guard lock(mutex_);
  return words_;
}

spidar::Pose MockUnit::pose() const {
  const std::lock_guard lock(mutex_);
  return plant_.pose();
}

std::uint64_t MockUnit::exchanges() const {
  const std::lock_guard lock(mutex_);
  return exchanges_;
}

void MockUnit::leave_reply(Bytes bytes) {
  const std::lock_guard lock(mutex_);
  replies_.push_back(std::move(bytes));
}

bool MockUnit::blocked() const {
  const std::lock_guard lock(mutex_);
  return faults_.blocked;
}

void MockUnit::take(const Bytes &packet) {
  const std::lock_guard lock(mutex_);
  if (faults_.watch)
    faults_.watch(packet);
  const auto set_words = [&](std::size_t offset) {
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      words_[i] = word_at(packet, offset + 2 * i);
  };
  if (model_ == Model::sh4) {
    if (packet.size() != 512 || packet[0] != 0x01 || packet[1] != 0x0e)
      return;
    set_words(2);
    latch();
    return;
  }
  if (packet.size() != 32)
    return;
  if (packet[0] == 0x52)
    set_words(1);
  else if (packet[0] == 0x51)
    latch();
  else if (packet[0] == 0xa2 && packet[1] == 0x19)
    origin_ = counts_;
}

void MockUnit::latch() {
  ++exchanges_;
  spidar::Counts counts{};
  plant_.exchange(words_, counts);
  if (!faults_.frozen)
    counts_ = counts;
  if (faults_.silent)
    return;
  Bytes reply = reply_of(counts_);
  if (faults_.mangle)
    faults_.mangle(reply);
  if (faults_.stalls > 0) {
    --faults_.stalls;
    stalled_ = true;
  } else if (faults_.late_replies > 0) {
    --faults_.late_replies;
    held_back_.push_back(std::move(reply));
  } else {
    for (Bytes &late : held_back_)
      replies_.push_back(std::move(late));
    held_back_.clear();
    replies_.push_back(std::move(reply));
  }
}

Bytes MockUnit::reply_of(const spidar::Counts &counts) {
  const std::size_t size = model_ == Model::sh4 ? 512 : 32;
  Bytes reply(size);
  for (std::uint8_t &byte : reply) // nobody knows what is in the bytes that nobody explains
    byte = static_cast<std::uint8_t>((noise_ = noise_ * 1664525 + 1013904223) >> 24);
  for (std::size_t i = 0; i < spidar::kStrings; ++i) {
    const auto count = static_cast<std::uint32_t>(counts[i] - origin_[i] + faults_.disturbance[i]);
    if (model_ == Model::sh4) {
      const std::uint32_t raw = kPowerOnCount - count;
      reply[16 + 2 * i] = static_cast<std::uint8_t>(raw);
      reply[17 + 2 * i] = static_cast<std::uint8_t>(raw >> 8);
    } else {
      for (std::size_t k = 0; k < 3; ++k)
        reply[3 * i + k] = static_cast<std::uint8_t>(count >> (8 * k));
    }
  }
  std::uint8_t &pio = reply[model_ == Model::sh4 ? 48 : 24];
  pio = static_cast<std::uint8_t>((pio & 0x0f) | switch_ << 4);
  return reply;
}

bool MockUnit::has_answer() const {
  const std::lock_guard lock(mutex_);
  return stalled_ || !replies_.empty();
}

MockUnit::Answer MockUnit::answer() {
  const std::lock_guard lock(mutex_);
  if (stalled_)
    return {true, {}};
  Answer answer{false, std::move(replies_.front())};
  replies_.pop_front();
  return answer;
}

void MockUnit::clear_halt() {
  const std::lock_guard lock(mutex_);
  stalled_ = false;
}

} // namespace test
