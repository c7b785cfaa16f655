// SPDX-License-Identifier: LGPL-2.1-or-later
// The cells of reliefs in the code of fields (docs/formats/field-code.md).
#include "field-code/field-codec.hpp"
#include "field-code/number-code.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace haptic {
namespace {

// ---- scales -------------------------------------------------------------------------------------

constexpr float kMicrometre = 1e-6F; // m
// The best step is this part of the range of the heights. It may be 1.5 times that, or a third,
// before it changes. Times the steps that a height may be off before it is coded anew, that gives
// the 2 % that are asked for.
constexpr float kReliefStep = 1.F / 100;
constexpr float kReliefTolerance = 1.3F; // steps
constexpr std::uint32_t kLeastStep = 50; // um
constexpr int kLargestHeight = 20'000;   // steps: 1 m of the least one

// The number of a stiffness k: 0, or 1 + 8 log2(k / (1 N/m)). A step is 9 %; a hand feels
// differences of a stiffness from 15 % on.
constexpr float kPerOctave = 8;
constexpr int kLargestStiffness = 134;
constexpr float kFrictionStep = 0.05F;
constexpr int kLargestFriction = 200;
constexpr int kLargestValidity = 4;
// A level stays until the next one is nearly reached, so that it does not flicker.
constexpr float kLevelTolerance = 0.9F;

float stiffness_position(float stiffness) {
  return stiffness >= 1 ? 1 + kPerOctave * std::log2(stiffness) : 0;
}

float stiffness_of(int number) {
  return number > 0 ? std::min(std::exp2(static_cast<float>(number - 1) / kPerOctave),
                               kMostReliefStiffness)
                    : 0;
}

// The number nearest to a position, or the one of before if that is near enough.
std::uint8_t level(float position, int before, int largest) {
  if (std::abs(position - static_cast<float>(before)) <= kLevelTolerance)
    return static_cast<std::uint8_t>(before);
  return static_cast<std::uint8_t>(std::clamp(static_cast<int>(std::lround(position)), 0, largest));
}

// Returns the height that is expected of a cell: the median of left, above and the plane through
// left, above and above left (M. Weinberger and others, "LOCO-I", 1996). Cells without a surface
// count, too: they continue those around them.
int expected(const std::vector<CodedReliefCell> &cells, std::size_t i, std::size_t columns) {
  const bool has_left = i % columns > 0;
  const bool has_up = i >= columns;
  if (!has_left || !has_up)
    return has_left ? cells[i - 1].height : has_up ? cells[i - columns].height : 0;
  const int left = cells[i - 1].height;
  const int up = cells[i - columns].height;
  const int plane = left + up - cells[i - columns - 1].height;
  return std::clamp(plane, std::min(left, up), std::max(left, up));
}

// The neighbour whose material is expected of a cell.
const CodedReliefCell &like(const std::vector<CodedReliefCell> &cells, std::size_t i,
                            std::size_t columns) {
  static constexpr CodedReliefCell kNone;
  return i % columns > 0 ? cells[i - 1] : i > 0 ? cells[i - columns] : kNone;
}

bool same_material(const CodedReliefCell &a, const CodedReliefCell &b) {
  return a.stiffness == b.stiffness && a.friction == b.friction && a.validity == b.validity;
}

void set_material(const ReliefCell &cell, CodedReliefCell &next) {
  if (!(cell.validity > 0)) {
    next.stiffness = next.friction = next.validity = 0;
    return;
  }
  next.stiffness = level(stiffness_position(cell.stiffness), next.stiffness, kLargestStiffness);
  next.friction = level(cell.friction / kFrictionStep, next.friction, kLargestFriction);
  next.validity = std::max<std::uint8_t>(
      level(cell.validity * kLargestValidity, next.validity, kLargestValidity), 1);
}

// ---- what is likely -----------------------------------------------------------------------------

// A relief starts with fresh models, so that it can be decoded without the one before.
struct ReliefModels {
  std::array<BitModel, 8> moved;         // by how many neighbours did, and by the field before
  std::array<BitModel, 4> turned;        // the material; by how many neighbours' did
  std::array<NumberModel<16>, 4> height; // by what the neighbours were off
  NumberModel<8> stiffness;
  NumberModel<8> friction;
  NumberModel<8> validity;
};

// As the coder of motion fields: codes the change of every cell, or reads it without `next`.
template <typename Code>
class ReliefCoder {
public:
  ReliefCoder(Code &code, std::vector<CodedReliefCell> &held, std::size_t columns,
              const std::vector<CodedReliefCell> *next)
      : code_(code), held_(held), next_(next), columns_(columns), changes_(held.size()) {}

  void run() {
    for (std::size_t i = 0; i < held_.size(); ++i)
      code_cell(i);
  }

private:
  struct Change {
    bool moved = false;  // the height changed
    bool turned = false; // the material changed
    int off = 0;         // height minus what was expected
  };

  Change change(bool exists, std::size_t i) const { return exists ? changes_[i] : Change{}; }

  void code_cell(std::size_t i) {
    CodedReliefCell &cell = held_[i];
    const CodedReliefCell wanted = next_ ? (*next_)[i] : CodedReliefCell{};
    const Change left = change(i % columns_ > 0, i - 1);
    const Change up = change(i >= columns_, i - columns_);
    const Change up_right = change(i >= columns_ && (i + 1) % columns_ > 0, i + 1 - columns_);
    Change &here = changes_[i];
    here.moved = code_.bit(models_.moved[static_cast<std::size_t>(left.moved) + up.moved +
                                         up_right.moved + (cell.changed ? 4U : 0U)],
                           wanted.height != cell.height);
    here.turned = code_.bit(models_.turned[static_cast<std::size_t>(left.turned) + up.turned],
                            !same_material(wanted, cell));
    if (here.moved) {
      const int guess = expected(held_, i, columns_);
      const int around = std::abs(left.off) + std::abs(up.off);
      const std::size_t size = around == 0 ? 0 : around <= 1 ? 1 : around <= 4 ? 2 : 3;
      here.off = code_number(code_, models_.height[size], wanted.height - guess);
      cell.height =
          static_cast<std::int16_t>(std::clamp(guess + here.off, -kLargestHeight, kLargestHeight));
    }
    if (here.turned)
      code_material(i, wanted);
    cell.changed = here.moved;
  }

  void code_material(std::size_t i, const CodedReliefCell &wanted) {
    CodedReliefCell &cell = held_[i];
    const CodedReliefCell &guess = like(held_, i, columns_);
    const auto code = [&](auto &model, int expected, int number, int largest) {
      return static_cast<std::uint8_t>(
          std::clamp(expected + code_number(code_, model, number - expected), 0, largest));
    };
    cell.validity = code(models_.validity, guess.validity, wanted.validity, kLargestValidity);
    cell.stiffness = code(models_.stiffness, guess.stiffness, wanted.stiffness, kLargestStiffness);
    cell.friction = code(models_.friction, guess.friction, wanted.friction, kLargestFriction);
  }

  Code &code_;
  std::vector<CodedReliefCell> &held_;
  const std::vector<CodedReliefCell> *next_; // may be none
  std::size_t columns_;
  ReliefModels models_;
  std::vector<Change> changes_;
};

} // namespace

std::uint32_t ReliefCells::step_for(const ReliefField &field, std::uint32_t before) {
  float lowest = std::numeric_limits<float>::infinity();
  float highest = -lowest;
  for (const ReliefCell &cell : field.cells)
    if (cell.validity > 0) {
      lowest = std::min(lowest, cell.height);
      highest = std::max(highest, cell.height);
    }
  if (lowest > highest)
    return std::max(before, kLeastStep);
  const auto best = std::max(kLeastStep, static_cast<std::uint32_t>(std::lround(
                                             (highest - lowest) * kReliefStep / kMicrometre)));
  return 2 * before > 3 * best || best > 3 * before ? best : before;
}

std::vector<CodedReliefCell> ReliefCells::updated(const CodedRelief &held, const ReliefField &field,
                                                  bool) {
  std::vector<CodedReliefCell> next(held.cells.size());
  const float step = static_cast<float>(held.step) * kMicrometre;
  for (std::size_t i = 0; i < next.size(); ++i) {
    next[i] = held.cells[i];
    set_material(field.cells[i], next[i]);
    const int guess = expected(next, i, field.columns);
    if (!(field.cells[i].validity > 0)) {
      // Any height will do. A cell that has had none continues those around it.
      if (held.cells[i].validity == 0)
        next[i].height = static_cast<std::int16_t>(guess);
      continue;
    }
    const float position = field.cells[i].height / step;
    const auto is_near = [&](int number) {
      return std::abs(position - static_cast<float>(number)) <= kReliefTolerance;
    };
    if (held.cells[i].validity > 0 && is_near(next[i].height))
      continue;
    const int number = is_near(guess) ? guess : static_cast<int>(std::lround(position));
    next[i].height = static_cast<std::int16_t>(std::clamp(number, -kLargestHeight, kLargestHeight));
  }
  return next;
}

void ReliefCells::write(Encoder &out, std::vector<CodedReliefCell> &held, std::size_t columns,
                        const std::vector<CodedReliefCell> &next) {
  ReliefCoder(out, held, columns, &next).run();
}

void ReliefCells::read(Decoder &in, std::vector<CodedReliefCell> &held, std::size_t columns) {
  ReliefCoder(in, held, columns, nullptr).run();
}

ReliefCell ReliefCells::decoded(const CodedReliefCell &cell, const CodedRelief &state) {
  if (cell.validity == 0)
    return {};
  const float height =
      static_cast<float>(cell.height) * (static_cast<float>(state.step) * kMicrometre);
  return {std::clamp(height, -kMostReliefHeight, kMostReliefHeight), stiffness_of(cell.stiffness),
          static_cast<float>(cell.friction) * kFrictionStep,
          static_cast<float>(cell.validity) / kLargestValidity};
}

} // namespace haptic
