// SPDX-License-Identifier: LGPL-2.1-or-later
// The cells of motion fields in the code of fields (docs/formats/field-code.md).
#include "field-code/field-codec.hpp"
#include "field-code/number-code.hpp"
#include "samples/force-defaults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace haptic {
namespace {

// ---- scale --------------------------------------------------------------------------------------

// Speed in px per frame of the number n on the scale:
//   n kStep                                          for n <= kEvenSteps,
//   kEven exp((n - kEvenSteps) / kEvenSteps)         beyond.
// Above kEven the step is 6 % of the speed. A hand feels differences of a force from 7 % on.
constexpr float kStep = 1.F / 4;
constexpr float kEven = 4;
constexpr int kEvenSteps = 16;
constexpr int kLargestNumber = 160; // 32 000 px per frame
constexpr float kFastest = 32'000;
// Tolerance of a velocity before it is coded anew. Forces that differ by less than 30 mN or by less
// than 7 % feel the same (docs/comparing.md).
constexpr float kTolerance = 0.2F;
constexpr float kRelativeTolerance = 0.07F;
// One px per frame of the scale, in px/s of a frame of the reference width. The tolerance is then
// 1.1 px/s, or 28 mN of 1 N with alpha = 0.04 s/px, the steepest law of the scripts; in a frame
// 1920 px wide a frame is 1/30 s.
constexpr double kReferenceSpeed = 5.5;

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

} // namespace

std::uint64_t MotionCells::scale_for(const MotionField &field) {
  constexpr double kLeast = 1'000; // ns: a microsecond, as it is written
  return static_cast<std::uint64_t>(
      std::max(kLeast, 1e9 * kReferenceWidth / (kReferenceSpeed * field.frame_width)));
}

// Returns the numbers to be held: new ones where a cell has left its tolerance, else the old ones.
// The confidence of a cell at rest changes with key fields only, since such a cell makes no force.
std::vector<CodedCell> MotionCells::updated(const CodedState &held, const MotionField &field,
                                            bool key) {
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

namespace {

constexpr std::size_t kSizes = 4;

// A field starts with fresh models, so that it can be decoded without the one before.
struct Models {
  // By how many neighbours moved, whether the cell did with the field before, and whether it
  // moves at all.
  std::array<BitModel, 16> moved = make_moved();
  std::array<BitModel, 4> turned = {BitModel(4050), BitModel(3000), BitModel(2000), BitModel(1000)};
  std::array<NumberModel<10>, kSizes> x; // by what the neighbours were off
  std::array<NumberModel<10>, kSizes> y;
  std::array<NumberModel<10>, 2> confidence;

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

} // namespace

void MotionCells::write(Encoder &out, std::vector<CodedCell> &held, std::size_t columns,
                        const std::vector<CodedCell> &next) {
  CellCoder(out, held, columns, &next).run();
}

void MotionCells::read(Decoder &in, std::vector<CodedCell> &held, std::size_t columns) {
  CellCoder(in, held, columns, nullptr).run();
}

FieldCell MotionCells::decoded(const CodedCell &cell, const CodedState &state) {
  return {speed_of(cell.x) * state.unit, speed_of(cell.y) * state.unit,
          confidence_of(cell.confidence)};
}

bool MotionCells::is_rest(const std::vector<CodedCell> &cells) {
  return std::ranges::all_of(cells, is_at_rest);
}

bool MotionCells::rests_on(const CodedState &held, const MotionField &field) {
  return is_rest(held.cells) && std::ranges::all_of(field.cells, [&](const FieldCell &cell) {
           return std::hypot(cell.velocity_x, cell.velocity_y) <= kTolerance * held.unit;
         });
}

void MotionCells::rest(MotionField &field) {
  for (FieldCell &cell : field.cells)
    cell.velocity_x = cell.velocity_y = 0;
}

} // namespace haptic
