// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-code/field-codec.hpp"

#include "field-code/number-code.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr std::uint64_t kMicrosecond = 1000; // ns
// A sequence number must not come round between them.
constexpr unsigned kMostBetweenKeys = 128;
constexpr std::uint64_t kLongestInterval = std::uint64_t{1} << 53; // us

// Bits of the first byte. The upper four are the flags of the field.
constexpr std::uint8_t kKey = 1 << 0;
constexpr std::uint8_t kRested = 1 << 1; // fields were left out before this one: the frame rested
// The interval follows; else it is the reference's. In a key field the interval always follows:
// there it says that this is the interval of the scale, else that follows too.
constexpr std::uint8_t kInterval = 1 << 2;
// Of a key field: it is the second of its pair, and the interval of the scale follows. (Version 0.2
// sets it in the first one, too, if its own interval is another.) Of another field: the number of
// fields since its key field follows. Tracks of version 0.1 do not have it there: the reference is
// the field before.
constexpr std::uint8_t kOfPair = 1 << 3;
constexpr unsigned kFlagShift = 4;
constexpr std::uint16_t kFlags =
    kMotionStill | kMotionDuplicate | kMotionCut | kMotionDiscontinuity;

constexpr std::size_t kCheckSize = 2; // bytes

// ---- the bytes around them ----------------------------------------------------------------------

void put_number(std::vector<std::uint8_t> &bytes, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7)
    bytes.push_back(static_cast<std::uint8_t>(value | 0x80));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

// Reads from the front of the bytes. Fails behind their end, and where a number is too large.
class ByteReader {
public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  std::uint64_t number(std::uint64_t largest) {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 63; shift += 7) {
      const std::uint8_t next = byte();
      value |= std::uint64_t{next & 0x7FU} << shift;
      if (next < 0x80) {
        failed_ = failed_ || value > largest;
        return failed_ ? 0 : value;
      }
    }
    failed_ = true;
    return 0;
  }
  std::uint8_t byte() {
    if (rest_.empty()) {
      failed_ = true;
      return 0;
    }
    const std::uint8_t front = rest_.front();
    rest_ = rest_.subspan(1);
    return front;
  }
  bool failed() const { return failed_; }
  std::span<const std::uint8_t> rest() const { return rest_; }

private:
  std::span<const std::uint8_t> rest_;
  bool failed_ = false;
};

bool has_scale(std::uint8_t head) {
  return (head & kKey) != 0 && ((head & kOfPair) != 0 || (head & kInterval) == 0);
}

// The numbers of a key field that describe its grid.
template <typename Cells, typename State>
auto grid_of(const State &state) {
  const auto &field = state.field;
  constexpr std::size_t kNumbers = Cells::kLargestStep > 0 ? 7 : 6;
  std::array<std::uint32_t, kNumbers> numbers = {field.columns,        field.rows,
                                                 field.frame_width,    field.frame_height,
                                                 field.pixel_aspect_n, field.pixel_aspect_d};
  if (kNumbers == 7)
    numbers.back() = state.step;
  return numbers;
}

// Returns FNV-1a of the first byte and of what both sides hold now, folded to 16 bits.
template <typename Cells, typename State>
std::uint16_t check_of(std::uint8_t head, const State &state) {
  std::uint32_t hash = 2166136261U;
  const auto add = [&](std::uint32_t value) { hash = (hash ^ value) * 16777619U; };
  add(head);
  add(state.sequence);
  add(static_cast<std::uint32_t>(state.field.interval / kMicrosecond));
  if (has_scale(head))
    add(static_cast<std::uint32_t>(state.scale / kMicrosecond));
  if (Cells::kLargestStep > 0)
    for (const std::uint32_t number : grid_of<Cells>(state))
      add(number);
  for (const auto &cell : state.cells)
    Cells::hash(cell, add);
  return static_cast<std::uint16_t>(hash ^ hash >> 16);
}

template <typename Field>
bool same_grid(const Field &a, const Field &b) {
  return a.columns == b.columns && a.rows == b.rows && a.frame_width == b.frame_width &&
         a.frame_height == b.frame_height && a.pixel_aspect_n == b.pixel_aspect_n &&
         a.pixel_aspect_d == b.pixel_aspect_d;
}

std::uint64_t rounded_interval(std::uint64_t interval) {
  return std::min((interval + kMicrosecond / 2) / kMicrosecond, kLongestInterval) * kMicrosecond;
}

// Returns what stands before the checksum.
template <typename Cells, typename State>
std::vector<std::uint8_t> head_of(std::uint8_t head, const State &state, const State &reference) {
  std::vector<std::uint8_t> bytes = {head, state.sequence};
  const bool key = (head & kKey) != 0;
  const auto &field = state.field;
  if (!key)
    bytes.push_back(static_cast<std::uint8_t>(state.sequence - reference.sequence));
  if (key || (head & kInterval) != 0)
    put_number(bytes, field.interval / kMicrosecond);
  if (has_scale(head))
    put_number(bytes, state.scale / kMicrosecond);
  if (key)
    for (const std::uint32_t number : grid_of<Cells>(state))
      put_number(bytes, number);
  return bytes;
}

constexpr float kFieldInterval = 1.F / 30; // s, of a field that names none

float unit_of(std::uint64_t interval) {
  return 1 / (interval > 0 ? static_cast<float>(interval) * 1e-9F : kFieldInterval);
}

} // namespace

bool is_key_field(std::span<const std::uint8_t> bytes) noexcept {
  return !bytes.empty() && (bytes[0] & kKey) != 0;
}

bool begins_pair(std::span<const std::uint8_t> bytes) noexcept {
  return is_key_field(bytes) && (bytes[0] & kOfPair) == 0;
}

// ---- encoder ------------------------------------------------------------------------------------

template <typename Cells>
bool GridEncoder<Cells>::needs_pair(const Field &field) const noexcept {
  if (!begun_ || !same_grid(field, state_.field) ||
      (field.flags & (kMotionCut | kMotionDiscontinuity)) != 0)
    return true;
  if (since_key_ + field.interval / 2 >= key_interval_ || sent_ >= kMostBetweenKeys)
    return true;
  // The scale is meant for the interval of the key field.
  const float rate = unit_of(field.interval);
  const float of_pair = unit_of(keys_[0].field.interval);
  return rate > 1.5F * of_pair || of_pair > 1.5F * rate;
}

template <typename Cells>
std::optional<std::vector<std::uint8_t>> GridEncoder<Cells>::push(const Field &field,
                                                                  bool even_at_rest) {
  since_key_ += std::min(field.interval, key_interval_);
  const bool first = needs_pair(field) || Cells::step_for(field, state_.step) != state_.step;
  if (!first && !even_at_rest && Cells::rests_on(state_, field)) {
    rested_ = true;
    return std::nullopt;
  }
  if (first)
    begin_pair(field, Cells::scale_for(field), Cells::step_for(field, state_.step));
  const bool key = sent_ < keys_.size();
  const auto next = Cells::updated(state_, field, key);
  return code(field, next, rested_ && !Cells::is_rest(next));
}

template <typename Cells>
std::vector<std::uint8_t> GridEncoder<Cells>::push_held(const State &held, bool ends_rest) {
  since_key_ += std::min(held.field.interval, key_interval_);
  if (needs_pair(held.field) || held.scale != state_.scale || held.step != state_.step)
    begin_pair(held.field, held.scale, held.step);
  return code(held.field, held.cells, ends_rest);
}

template <typename Cells>
void GridEncoder<Cells>::begin_pair(const Field &field, std::uint64_t interval,
                                    std::uint32_t step) {
  state_.field = field;
  state_.unit = unit_of(interval);
  state_.scale = rounded_interval(interval);
  // The numbers of a relief stay where they may: a step at each pair of key fields would be felt.
  if (step == 0 || step != state_.step || state_.cells.size() != field.cells.size())
    state_.cells.assign(field.cells.size(), {});
  state_.step = step;
  since_key_ = 0;
  sent_ = 0;
}

template <typename Cells>
std::vector<std::uint8_t> GridEncoder<Cells>::code(const Field &field,
                                                   const std::vector<typename Cells::Cell> &next,
                                                   bool ends_rest) {
  const bool key = sent_ < keys_.size();
  ++state_.sequence;
  state_.field.interval = rounded_interval(field.interval);
  const State &reference = keys_[sent_ % keys_.size()];
  const bool is_first = sent_ == 0;
  const bool has_interval = is_first ? state_.field.interval == state_.scale
                                     : key || state_.field.interval != reference.field.interval;
  std::vector<std::uint8_t> bytes = head_of<Cells>(
      static_cast<std::uint8_t>((key ? kKey : 0) | (ends_rest ? kRested : 0) |
                                (has_interval ? kInterval : 0) | (is_first ? 0 : kOfPair) |
                                (field.flags & kFlags) << kFlagShift),
      state_, reference);
  const std::size_t check_at = bytes.size();
  bytes.resize(check_at + kCheckSize);
  if (key)
    state_.cells.assign(field.cells.size(), {});
  else
    state_.cells = reference.cells;
  Encoder out;
  Cells::write(out, state_.cells, field.columns, next);
  out.finish(bytes);
  const std::uint16_t check = check_of<Cells>(bytes[0], state_);
  bytes[check_at] = static_cast<std::uint8_t>(check);
  bytes[check_at + 1] = static_cast<std::uint8_t>(check >> 8);
  if (key)
    keys_[sent_] = state_;
  ++sent_;
  begun_ = true;
  rested_ = false;
  return bytes;
}

// ---- decoder ------------------------------------------------------------------------------------

// Returns what a field that is no key field is the difference from, or nothing if that was lost.
template <typename Cells>
auto GridDecoder<Cells>::reference_of(std::uint8_t head, std::uint8_t sequence,
                                      std::uint8_t distance) const noexcept -> const State * {
  const auto is = [](const State &state, std::uint8_t number) {
    return !state.cells.empty() && state.sequence == number;
  };
  if ((head & kOfPair) == 0)
    return is(state_, static_cast<std::uint8_t>(sequence - 1)) ? &state_ : nullptr;
  for (std::size_t i = keys_.size(); i-- > 0;)
    if (is(keys_[i], static_cast<std::uint8_t>(sequence - distance)))
      return &keys_[i];
  return nullptr;
}

namespace {

// Reads the rest of the head of a key field. Returns false if it is damaged.
template <typename Cells, typename State>
bool read_grid(ByteReader &in, std::uint8_t head, State &state) {
  constexpr std::uint64_t kMost32 = std::numeric_limits<std::uint32_t>::max();
  state.scale = has_scale(head) ? in.number(kLongestInterval) * kMicrosecond : state.field.interval;
  auto &grid = state.field;
  grid.columns = static_cast<std::uint16_t>(in.number(kMostFieldCells));
  grid.rows = static_cast<std::uint16_t>(in.number(kMostFieldCells));
  for (auto *number :
       {&grid.frame_width, &grid.frame_height, &grid.pixel_aspect_n, &grid.pixel_aspect_d})
    *number = static_cast<std::uint32_t>(in.number(kMost32));
  if (Cells::kLargestStep > 0)
    state.step = static_cast<std::uint32_t>(in.number(Cells::kLargestStep));
  const bool has_step = Cells::kLargestStep == 0 || state.step > 0;
  const std::size_t cells = std::size_t{grid.columns} * grid.rows;
  if (in.failed() || !has_step || cells == 0 || cells > kMostFieldCells || grid.frame_width == 0 ||
      grid.frame_height == 0 || grid.pixel_aspect_n == 0 || grid.pixel_aspect_d == 0)
    return false;
  grid.cells.resize(cells);
  state.unit = unit_of(state.scale);
  state.cells.assign(cells, {});
  return true;
}

} // namespace

template <typename Cells>
auto GridDecoder<Cells>::push(std::span<const std::uint8_t> bytes) -> Result {
  ByteReader in(bytes);
  const std::uint8_t head = in.byte();
  const std::uint8_t sequence = in.byte();
  const bool key = (head & kKey) != 0;
  rested_ = lost_ = false;
  if (in.failed())
    return Result::damaged;
  const bool begins =
      begins_pair(bytes) && sequence == kFirstSequence; // a sender that was restarted
  if (sequence_ && !begins)
    lost_ = sequence != *sequence_ && sequence != static_cast<std::uint8_t>(*sequence_ + 1);
  if (sequence_ || key)
    sequence_ = sequence;
  State next;
  if (!key) {
    const std::uint8_t distance = (head & kOfPair) != 0 ? in.byte() : 0;
    const State *reference = reference_of(head, sequence, distance);
    if (!reference)
      return state_.cells.empty() ? Result::waiting : Result::missing;
    next = *reference;
  }
  next.sequence = sequence;
  next.field.flags = head >> kFlagShift;
  if (key || (head & kInterval) != 0)
    next.field.interval = in.number(kLongestInterval) * kMicrosecond;
  if (key && !read_grid<Cells>(in, head, next))
    return Result::damaged;
  const auto check = static_cast<std::uint16_t>(in.byte() | in.byte() << 8);
  if (in.failed())
    return Result::damaged;
  Decoder code(in.rest());
  Cells::read(code, next.cells, next.field.columns);
  if (check != check_of<Cells>(head, next))
    return Result::damaged;
  std::ranges::transform(next.cells, next.field.cells.begin(),
                         [&](const auto &cell) { return Cells::decoded(cell, next); });
  if ((head & kRested) != 0 && !state_.cells.empty())
    set_rest();
  state_ = std::move(next);
  if (key) {
    keys_[0] = std::move(keys_[1]);
    keys_[1] = state_;
  }
  return Result::field;
}

// The last field before the rest may have been lost: only that it rested is certain.
template <typename Cells>
void GridDecoder<Cells>::set_rest() {
  rested_ = true;
  rest_ = state_.field;
  rest_.flags = kMotionStill;
  Cells::rest(rest_);
}

template class GridEncoder<MotionCells>;
template class GridDecoder<MotionCells>;
template class GridEncoder<ReliefCells>;
template class GridDecoder<ReliefCells>;

} // namespace haptic
