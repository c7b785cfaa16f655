// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-codec.hpp"

#include "range-coder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace haptic {
namespace {

constexpr std::uint64_t kMicrosecond = 1000;       // ns
constexpr std::uint64_t kKeyEvery = 1'000'000'000; // ns
// A sequence number must not come round between them.
constexpr unsigned kMostBetweenKeys = 128;
constexpr std::uint64_t kLongestInterval = std::uint64_t{1} << 53; // us

// Bits of the first byte. The upper four are the flags of the field.
constexpr std::uint8_t kKey = 1 << 0;
constexpr std::uint8_t kRested = 1 << 1;   // fields were left out before this one: the frame rested
constexpr std::uint8_t kInterval = 1 << 2; // the interval follows; otherwise it has not changed
constexpr unsigned kFlagShift = 4;
constexpr std::uint16_t kFlags =
    kMotionStill | kMotionDuplicate | kMotionCut | kMotionDiscontinuity;

constexpr std::size_t kCheckSize = 2; // bytes

// ---- scale --------------------------------------------------------------------------------------

// Speed in px per frame of the number n on the scale:
//   n kStep                                          for n <= kEvenSteps,
//   kEven exp((n - kEvenSteps) / kEvenSteps)         beyond.
// Above kEven the step is 6 % of the speed. A hand feels differences of a force from 7 % on.
constexpr float kStep = 1.F / 4;
constexpr float kEven = 4;
constexpr int kEvenSteps = 16;
constexpr int kLargestNumber = 127; // 4100 px per frame
constexpr float kFastest = 4000;
// Tolerance of a velocity before it is coded anew. 0.2 px per frame are 3 % of the full force at 30
// frames a second. Forces that differ by less than 7 % feel the same.
constexpr float kTolerance = 0.2F;
constexpr float kRelativeTolerance = 0.07F;
constexpr float kFieldInterval = 1.F / 30; // s, of a field that names none

std::int16_t number_of(float speed) {
  const float size = std::abs(speed);
  const float number =
      size <= kEven ? size / kStep : kEvenSteps + kEvenSteps * std::log(size / kEven);
  const auto rounded = std::min(static_cast<int>(std::lround(number)), kLargestNumber);
  return static_cast<std::int16_t>(speed < 0 ? -rounded : rounded);
}

const std::array<float, kLargestNumber + 1> &speeds() {
  static const auto table = [] {
    std::array<float, kLargestNumber + 1> speeds{};
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      const auto number = static_cast<float>(i);
      speeds[i] =
          i <= kEvenSteps ? number * kStep : kEven * std::exp((number - kEvenSteps) / kEvenSteps);
    }
    return speeds;
  }();
  return table;
}

float speed_of(int number) {
  const float speed = speeds()[static_cast<std::size_t>(std::abs(number))];
  return number < 0 ? -speed : speed;
}

constexpr int kLargestConfidence = 4;
// A level stays until the next one is nearly reached, so that it does not flicker.
constexpr float kConfidenceTolerance = 0.9F / kLargestConfidence;
// The same for a cell at rest, which makes no force whatever its confidence is.
constexpr float kRestingConfidenceTolerance = 0.25F;

int confidence_number(float confidence) {
  return confidence > 0
             ? std::max(1, static_cast<int>(std::lround(confidence * kLargestConfidence)))
             : 0;
}

float confidence_of(int number) {
  return static_cast<float>(number) / kLargestConfidence;
}

float unit_of(const MotionField &field) {
  return 1 / (field.interval > 0 ? static_cast<float>(field.interval) * 1e-9F : kFieldInterval);
}

FieldCell decoded(const CodedCell &cell, float unit) {
  return {speed_of(cell.x) * unit, speed_of(cell.y) * unit, confidence_of(cell.confidence)};
}

bool is_near(float confidence, int number, float tolerance) {
  return number > 0 && std::abs(confidence - confidence_of(number)) <= tolerance;
}

bool is_at_rest(const CodedCell &cell) {
  return cell.x == 0 && cell.y == 0;
}

struct Steps {
  int x = 0;
  int y = 0;
};

// Returns the mean of the neighbours that are coded before the cell and have a confidence.
Steps expected(const std::vector<CodedCell> &cells, std::size_t i, std::size_t columns) {
  int count = 0;
  Steps sum;
  const auto add = [&](bool exists, std::size_t neighbour) {
    if (!exists || cells[neighbour].confidence == 0)
      return;
    ++count;
    sum.x += cells[neighbour].x;
    sum.y += cells[neighbour].y;
  };
  const std::size_t column = i % columns;
  add(column > 0, i - 1);
  add(i >= columns, i - columns);
  add(i >= columns && column + 1 < columns, i + 1 - columns);
  const auto mean = [&](int total) { // rounded, half away from zero
    return (2 * total + (total < 0 ? -count : count)) / (2 * count);
  };
  return count > 0 ? Steps{mean(sum.x), mean(sum.y)} : Steps{};
}

// Returns the numbers of a velocity in px per frame: the expected ones, which cost least, if they
// are within the tolerance, or else the nearest ones.
Steps steps_of(float x, float y, float tolerance, Steps expected) {
  const Steps nearest{number_of(x), number_of(y)};
  for (const Steps &cheap : {expected, Steps{expected.x, nearest.y}, Steps{nearest.x, expected.y}})
    if (std::hypot(x - speed_of(cheap.x), y - speed_of(cheap.y)) <= tolerance)
      return cheap;
  return nearest;
}

// Returns the numbers to be held: new ones where a cell has left its tolerance, else the old ones.
// The confidence of a cell at rest changes with key fields only, since such a cell makes no force.
std::vector<CodedCell> updated(const CodedState &held, const MotionField &field, bool key) {
  std::vector<CodedCell> next(held.cells.size());
  for (std::size_t i = 0; i < next.size(); ++i) {
    const FieldCell &cell = field.cells[i];
    next[i] = held.cells[i];
    const bool rested = is_at_rest(next[i]);
    if (!(cell.confidence > 0)) {
      if (key || !rested)
        next[i] = {};
      continue;
    }
    const float x = std::clamp(cell.velocity_x / held.unit, -kFastest, kFastest);
    const float y = std::clamp(cell.velocity_y / held.unit, -kFastest, kFastest);
    const float tolerance = std::max(kTolerance, kRelativeTolerance * std::hypot(x, y));
    if (std::hypot(x - speed_of(next[i].x), y - speed_of(next[i].y)) > tolerance) {
      const Steps steps = steps_of(x, y, tolerance, expected(next, i, field.columns));
      next[i].x = static_cast<std::int16_t>(steps.x);
      next[i].y = static_cast<std::int16_t>(steps.y);
    }
    const bool rests = is_at_rest(next[i]);
    if (!key && rested && rests)
      continue;
    const float margin = rests ? kRestingConfidenceTolerance : kConfidenceTolerance;
    if (is_near(cell.confidence, next[i].confidence, margin))
      continue;
    // The level of a neighbour costs nothing where it is near enough.
    const int left = i % field.columns > 0 ? next[i - 1].confidence : 0;
    const int up = i >= field.columns ? next[i - field.columns].confidence : 0;
    next[i].confidence = static_cast<std::uint8_t>(is_near(cell.confidence, left, margin) ? left
                                                   : is_near(cell.confidence, up, margin)
                                                       ? up
                                                       : confidence_number(cell.confidence));
  }
  return next;
}

// ---- what is likely -----------------------------------------------------------------------------

// The bits of one kind of number: whether it is 0, its sign, then its size as Exp-Golomb code.
struct NumberModel {
  static constexpr std::size_t kLengths = 10; // of numbers up to 1023
  BitModel zero{2048};
  BitModel sign;
  std::array<BitModel, kLengths> longer;
  std::array<BitModel, 2> first_bit;
};

constexpr std::size_t kSizes = 4;

// A field starts with fresh models, so that it can be decoded without the one before.
struct Models {
  // By how many neighbours moved, whether the cell did with the field before, and whether it
  // moves at all.
  std::array<BitModel, 16> moved = make_moved();
  std::array<BitModel, 4> turned = {BitModel(4050), BitModel(3000), BitModel(2000), BitModel(1000)};
  std::array<NumberModel, kSizes> x; // by what the neighbours were off
  std::array<NumberModel, kSizes> y;
  std::array<NumberModel, 2> confidence;

private:
  static std::array<BitModel, 16> make_moved() {
    std::array<BitModel, 16> models;
    constexpr std::array<std::uint16_t, 16> kStill = {4070, 3600, 3300, 2600, 3900, 3000,
                                                      2400, 1400, 3800, 3000, 2600, 1600,
                                                      3000, 2000, 1400, 500};
    for (std::size_t i = 0; i < models.size(); ++i)
      models[i] = BitModel(kStill[i]);
    return models;
  }
};

// An Encoder or a Decoder is the `code` of the functions below, so that both directions share them:
// a call gets the bit to be written and returns the bit that was written or read.
class Encoder {
public:
  bool bit(BitModel &model, bool bit) { return out_.bit(model, bit), bit; }
  bool even_bit(bool bit) { return out_.even_bit(bit), bit; }
  void finish(std::vector<std::uint8_t> &bytes) { out_.finish(bytes); }

private:
  RangeEncoder out_;
};

class Decoder {
public:
  explicit Decoder(std::span<const std::uint8_t> bytes) : in_(bytes) {}
  bool bit(BitModel &model, bool) { return in_.bit(model); }
  bool even_bit(bool) { return in_.even_bit(); }

private:
  RangeDecoder in_;
};

template <typename Code>
int code_number(Code &code, NumberModel &model, int number) {
  if (code.bit(model.zero, number == 0))
    return 0;
  const bool negative = code.bit(model.sign, number < 0);
  const auto size = static_cast<unsigned>(std::abs(number)); // from 1
  unsigned length = 0;
  while (length + 1 < NumberModel::kLengths &&
         code.bit(model.longer[length], static_cast<unsigned>(std::bit_width(size)) > length + 1))
    ++length;
  unsigned read = 1;
  for (unsigned i = length; i-- > 0;) {
    const bool wanted = size >> i & 1;
    const bool bit =
        i + 1 == length ? code.bit(model.first_bit[length > 1], wanted) : code.even_bit(wanted);
    read = read << 1 | unsigned{bit};
  }
  return negative ? -static_cast<int>(read) : static_cast<int>(read);
}

// Codes the change of every cell from `held` to `next`, row by row, and makes `held` the same as
// `next`. A decoder has no `next`: it reads the changes.
template <typename Code>
class CellCoder {
public:
  CellCoder(Code &code, std::vector<CodedCell> &held, std::size_t columns,
            const std::vector<CodedCell> *next)
      : code_(code), held_(held), next_(next), columns_(columns), above_(columns + 2),
        row_(columns + 2) {}

  void run() {
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (i % columns_ == 0 && i > 0) {
        std::swap(above_, row_);
        std::ranges::fill(row_, Change{});
      }
      code_cell(i);
    }
  }

private:
  struct Change {
    bool moved = false;  // the velocity changed
    bool turned = false; // the confidence changed
    int off_x = 0;       // velocity minus what was expected
    int off_y = 0;
    int confidence = 0; // difference from the confidence held
  };

  struct Neighbours {
    const Change &left;
    const Change &up;
    const Change &up_left;
    const Change &up_right;
  };

  void code_cell(std::size_t i) {
    const std::size_t column = i % columns_;
    const Neighbours near = {row_[column], above_[column + 1], above_[column], above_[column + 2]};
    CodedCell &cell = held_[i];
    const CodedCell wanted = next_ ? (*next_)[i] : CodedCell{};
    Change &here = row_[column + 1];
    here.moved = code_.bit(models_.moved[move_context(near, cell)],
                           wanted.x != cell.x || wanted.y != cell.y);
    const std::size_t turns = static_cast<std::size_t>(near.left.turned) + near.up.turned +
                              (here.moved && cell.confidence == 0);
    here.turned = code_.bit(models_.turned[turns], wanted.confidence != cell.confidence);
    if (here.moved)
      code_velocity(i, wanted, near, here);
    if (here.turned)
      code_confidence(cell, wanted, near, here);
    cell.changed = here.moved;
  }

  static std::size_t move_context(const Neighbours &near, const CodedCell &cell) {
    return static_cast<std::size_t>(near.left.moved) + near.up.moved +
           (near.up_left.moved || near.up_right.moved) + (cell.changed ? 4U : 0U) +
           (is_at_rest(cell) ? 0U : 8U);
  }

  void code_velocity(std::size_t i, const CodedCell &wanted, const Neighbours &near, Change &here) {
    CodedCell &cell = held_[i];
    const Steps guess = expected(held_, i, columns_);
    here.off_x = code_number(code_, models_.x[size_class(near.left.off_x, near.up.off_x)],
                             wanted.x - guess.x);
    here.off_y =
        code_number(code_, models_.y[size_class(near.left.off_y + here.off_x, near.up.off_y)],
                    wanted.y - guess.y);
    cell.x = limited(guess.x + here.off_x);
    cell.y = limited(guess.y + here.off_y);
  }

  void code_confidence(CodedCell &cell, const CodedCell &wanted, const Neighbours &near,
                       Change &here) {
    const int left = near.left.confidence;
    const int up = near.up.confidence;
    const int guess = !near.up.turned     ? left
                      : !near.left.turned ? up
                                          : std::clamp(left + up - near.up_left.confidence,
                                                       std::min(left, up), std::max(left, up));
    here.confidence = guess + code_number(code_, models_.confidence[left == up],
                                          wanted.confidence - cell.confidence - guess);
    cell.confidence = static_cast<std::uint8_t>(
        std::clamp(cell.confidence + here.confidence, 0, kLargestConfidence));
  }

  static std::size_t size_class(int a, int b) {
    const int sum = std::abs(a) + std::abs(b);
    return static_cast<std::size_t>(sum == 0 ? 0 : sum <= 1 ? 1 : sum <= 4 ? 2 : 3);
  }

  static std::int16_t limited(int number) {
    return static_cast<std::int16_t>(std::clamp(number, -kLargestNumber, kLargestNumber));
  }

  Code &code_;
  std::vector<CodedCell> &held_;
  const std::vector<CodedCell> *next_; // may be none
  std::size_t columns_;
  Models models_;
  std::vector<Change> above_; // of the row above, with one more cell at each end
  std::vector<Change> row_;   // of this row, the same
};

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

// Returns FNV-1a of the first byte and of what both sides hold now, folded to 16 bits.
std::uint16_t check_of(std::uint8_t head, const CodedState &state) {
  std::uint32_t hash = 2166136261U;
  const auto add = [&](std::uint32_t value) { hash = (hash ^ value) * 16777619U; };
  add(head);
  add(state.sequence);
  add(static_cast<std::uint32_t>(state.field.interval / kMicrosecond));
  for (const CodedCell &cell : state.cells) {
    add(static_cast<std::uint16_t>(cell.x));
    add(static_cast<std::uint16_t>(cell.y));
    add(cell.confidence);
  }
  return static_cast<std::uint16_t>(hash ^ hash >> 16);
}

bool same_grid(const MotionField &a, const MotionField &b) {
  return a.columns == b.columns && a.rows == b.rows && a.frame_width == b.frame_width &&
         a.frame_height == b.frame_height && a.pixel_aspect_n == b.pixel_aspect_n &&
         a.pixel_aspect_d == b.pixel_aspect_d;
}

std::uint64_t rounded_interval(std::uint64_t interval) {
  return std::min((interval + kMicrosecond / 2) / kMicrosecond, kLongestInterval) * kMicrosecond;
}

bool is_rest(const std::vector<CodedCell> &cells) {
  return std::ranges::all_of(cells, is_at_rest);
}

} // namespace

bool is_key_field(std::span<const std::uint8_t> bytes) noexcept {
  return !bytes.empty() && (bytes[0] & kKey) != 0;
}

// ---- encoder ------------------------------------------------------------------------------------

bool FieldEncoder::needs_key(const MotionField &field) const noexcept {
  if (!begun_ || !same_grid(field, state_.field) ||
      (field.flags & (kMotionCut | kMotionDiscontinuity)) != 0)
    return true;
  if (since_key_ + field.interval / 2 >= kKeyEvery || sent_ >= kMostBetweenKeys)
    return true;
  // The steps are meant at the interval of the key field.
  const float unit = unit_of(field);
  return unit > 1.5F * state_.unit || state_.unit > 1.5F * unit;
}

bool FieldEncoder::rests_on(const MotionField &field) const noexcept {
  return is_rest(state_.cells) && std::ranges::all_of(field.cells, [&](const FieldCell &cell) {
           return std::hypot(cell.velocity_x, cell.velocity_y) <= kTolerance * state_.unit;
         });
}

std::optional<std::vector<std::uint8_t>> FieldEncoder::push(const MotionField &field) {
  since_key_ += std::min(field.interval, kKeyEvery);
  const bool key = needs_key(field);
  if (!key && rests_on(field)) {
    rested_ = true;
    return std::nullopt;
  }
  const std::uint64_t interval = rounded_interval(field.interval);
  const bool has_interval = key || interval != state_.field.interval;
  if (key) {
    state_.field = field;
    state_.unit = unit_of(field);
    state_.cells.assign(field.cells.size(), {});
    since_key_ = 0;
    sent_ = 0;
  }
  ++state_.sequence;
  ++sent_;
  state_.field.interval = interval;
  const std::vector<CodedCell> next = updated(state_, field, key);

  const bool ends_rest = rested_ && !is_rest(next);
  std::vector<std::uint8_t> bytes;
  bytes.push_back(static_cast<std::uint8_t>((key ? kKey : 0) | (ends_rest ? kRested : 0) |
                                            (has_interval ? kInterval : 0) |
                                            (field.flags & kFlags) << kFlagShift));
  bytes.push_back(state_.sequence);
  if (has_interval)
    put_number(bytes, interval / kMicrosecond);
  if (key)
    for (std::uint32_t number :
         {std::uint32_t{field.columns}, std::uint32_t{field.rows}, field.frame_width,
          field.frame_height, field.pixel_aspect_n, field.pixel_aspect_d})
      put_number(bytes, number);
  const std::size_t check_at = bytes.size();
  bytes.resize(check_at + kCheckSize);
  Encoder code;
  CellCoder(code, state_.cells, field.columns, &next).run();
  code.finish(bytes);
  const std::uint16_t check = check_of(bytes[0], state_);
  bytes[check_at] = static_cast<std::uint8_t>(check);
  bytes[check_at + 1] = static_cast<std::uint8_t>(check >> 8);
  begun_ = true;
  rested_ = false;
  return bytes;
}

// ---- decoder ------------------------------------------------------------------------------------

FieldDecoder::Result FieldDecoder::break_off(Result result) {
  broken_ = true;
  if (state_.cells.empty())
    return result == Result::missing ? Result::waiting : result;
  std::ranges::fill(state_.field.cells, FieldCell{});
  return result;
}

FieldDecoder::Result FieldDecoder::push(std::span<const std::uint8_t> bytes) {
  ByteReader in(bytes);
  const std::uint8_t head = in.byte();
  const std::uint8_t sequence = in.byte();
  const bool key = (head & kKey) != 0;
  rested_ = false;
  if (in.failed())
    return break_off(Result::damaged);
  const bool follows = !broken_ && sequence == static_cast<std::uint8_t>(state_.sequence + 1);
  if (!key && !follows)
    return break_off(Result::missing);
  if ((head & kRested) != 0 && follows) {
    rested_ = true;
    rest_ = state_.field;
    rest_.flags = kMotionStill;
  }
  constexpr std::uint64_t kMost32 = std::numeric_limits<std::uint32_t>::max();
  if ((head & kInterval) != 0)
    state_.field.interval = in.number(kLongestInterval) * kMicrosecond;
  else if (key)
    return break_off(Result::damaged);
  if (key) {
    MotionField grid;
    grid.columns = static_cast<std::uint16_t>(in.number(kMostFieldCells));
    grid.rows = static_cast<std::uint16_t>(in.number(kMostFieldCells));
    for (auto *number :
         {&grid.frame_width, &grid.frame_height, &grid.pixel_aspect_n, &grid.pixel_aspect_d})
      *number = static_cast<std::uint32_t>(in.number(kMost32));
    const std::size_t cells = std::size_t{grid.columns} * grid.rows;
    if (in.failed() || cells == 0 || cells > kMostFieldCells || grid.frame_width == 0 ||
        grid.frame_height == 0 || grid.pixel_aspect_n == 0 || grid.pixel_aspect_d == 0)
      return break_off(Result::damaged);
    grid.interval = state_.field.interval;
    grid.cells.resize(cells);
    state_.field = std::move(grid);
    state_.unit = unit_of(state_.field);
    state_.cells.assign(cells, {});
  }
  state_.sequence = sequence;
  state_.field.flags = head >> kFlagShift;
  const auto check = static_cast<std::uint16_t>(in.byte() | in.byte() << 8);
  if (in.failed())
    return break_off(Result::damaged);
  Decoder code(in.rest());
  CellCoder(code, state_.cells, state_.field.columns, nullptr).run();
  if (check != check_of(head, state_)) {
    rested_ = false;
    return break_off(Result::damaged);
  }
  std::ranges::transform(state_.cells, state_.field.cells.begin(),
                         [&](const CodedCell &cell) { return decoded(cell, state_.unit); });
  broken_ = false;
  return Result::field;
}

} // namespace haptic
