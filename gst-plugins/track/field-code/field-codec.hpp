// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion fields and reliefs in few bytes: numbers in steps as fine as a hand can feel, and only the
// cells that changed (docs/formats/field-code.md).
#pragma once

#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// The most bytes of one coded field.
inline constexpr std::size_t kLargestCodedField = 60'000;

/// The least time from one pair of key fields to the next, ns (docs/formats/field-code.md says
/// why).
inline constexpr std::uint64_t kKeyInterval = 1'000'000'000;

/// The number of a sender's first field. After 255 comes 0.
inline constexpr std::uint8_t kFirstSequence = 1;

/// Returns whether a coded field can be decoded without those before it.
bool is_key_field(std::span<const std::uint8_t> bytes) noexcept;

/// Returns whether it and all fields after it can be decoded without those before it: whether it is
/// the first of a pair of key fields.
bool begins_pair(std::span<const std::uint8_t> bytes) noexcept;

/// The numbers of one cell that encoder and decoder both hold.
struct CodedCell {
  std::int16_t x = 0; ///< velocity as its number on the scale of the code
  std::int16_t y = 0;
  std::uint8_t confidence = 0; ///< 0..4
  bool changed = false;        ///< with the field that was decoded last to this state

  bool operator==(const CodedCell &) const = default;
};

/// The same of a relief.
struct CodedReliefCell {
  std::int16_t height = 0;    ///< in steps
  std::uint8_t stiffness = 0; ///< number on the scale of the code
  std::uint8_t friction = 0;  ///< in steps
  std::uint8_t validity = 0;  ///< 0..4
  bool changed = false;       ///< with the field that was decoded last to this state

  bool operator==(const CodedReliefCell &) const = default;
};

/// A field as encoder and decoder both hold it.
template <typename Field, typename Cell>
struct CodedGrid {
  Field field; ///< of the encoder: all but its cells
  std::vector<Cell> cells;
  std::uint64_t scale = 0; ///< ns that are a frame on the scale of the code
  float unit = 0;          ///< px/s that are one px per frame
  std::uint32_t step = 0;  ///< of a relief: um that are a step of the height
  std::uint8_t sequence = 0;
};
using CodedState = CodedGrid<MotionField, CodedCell>;
using CodedRelief = CodedGrid<ReliefField, CodedReliefCell>;

class Encoder; // number-code.hpp
class Decoder;

/// What the code does with the cells of motion fields.
struct MotionCells {
  using Field = MotionField;
  using Cell = CodedCell;
  static constexpr std::uint32_t kLargestStep = 0; ///< there are no steps of a height

  /// Returns the numbers to be held: new ones where a cell has left its tolerance, else those of
  /// before.
  static std::vector<Cell> updated(const CodedState &held, const Field &field, bool key);
  /// Codes the differences from `held` to `next`, and makes `held` the same.
  static void write(Encoder &out, std::vector<Cell> &held, std::size_t columns,
                    const std::vector<Cell> &next);
  static void read(Decoder &in, std::vector<Cell> &held, std::size_t columns);
  static FieldCell decoded(const Cell &cell, const CodedState &state);

  /// Returns the time that is a frame on the scale, ns. It depends on the width of the field's
  /// frame and not on its interval: a hand feels widths per second.
  static std::uint64_t scale_for(const Field &field);
  /// Returns the step of before if it still fits, or another one.
  static std::uint32_t step_for(const Field &, std::uint32_t before) { return before; }
  /// A field at rest, that rests as the one before did, is not sent.
  static bool is_rest(const std::vector<Cell> &cells);
  static bool rests_on(const CodedState &held, const Field &field);
  static void rest(Field &field);

  /// Calls `add` with all that the checksum holds of a cell.
  template <typename Add>
  static void hash(const Cell &cell, Add &&add) {
    add(static_cast<std::uint16_t>(cell.x));
    add(static_cast<std::uint16_t>(cell.y));
    add(cell.confidence);
  }
};

/// What it does with those of reliefs, which never rest: each is sent.
struct ReliefCells {
  using Field = ReliefField;
  using Cell = CodedReliefCell;
  static constexpr std::uint32_t kLargestStep = 100'000; ///< um

  static std::vector<Cell> updated(const CodedRelief &held, const Field &field, bool key);
  static void write(Encoder &out, std::vector<Cell> &held, std::size_t columns,
                    const std::vector<Cell> &next);
  static void read(Decoder &in, std::vector<Cell> &held, std::size_t columns);
  static ReliefCell decoded(const Cell &cell, const CodedRelief &state);

  static std::uint64_t scale_for(const Field &field) { return field.interval; }
  static std::uint32_t step_for(const Field &field, std::uint32_t before);
  static bool is_rest(const std::vector<Cell> &) { return false; }
  static bool rests_on(const CodedRelief &, const Field &) { return false; }
  static void rest(Field &) {}

  template <typename Add>
  static void hash(const Cell &cell, Add &&add) {
    add(static_cast<std::uint16_t>(cell.height));
    for (auto number : {cell.stiffness, cell.friction, cell.validity})
      add(number);
  }
};

/// `Cells` is MotionCells or ReliefCells.
template <typename Cells>
class GridEncoder {
public:
  using Field = typename Cells::Field;
  using State = CodedGrid<Field, typename Cells::Cell>;

  /// `key_interval` in ns.
  explicit GridEncoder(std::uint64_t key_interval = kKeyInterval,
                       std::uint8_t first_sequence = kFirstSequence)
      : key_interval_(key_interval) {
    state_.sequence = static_cast<std::uint8_t>(first_sequence - 1);
  }
  std::uint64_t key_interval() const noexcept { return key_interval_; }

  /// Returns the code of a field, or nothing if the whole frame rests as before: such a field need
  /// not be sent. A pair of key fields comes first, after each key interval, after a cut, and when
  /// the frame or its grid changes. The others are the differences from the first and the second of
  /// the pair in turn, so that a lost one costs every second field. The field must be valid
  /// (is_valid()). `even_at_rest`: it is sent for what it has beside its cells.
  std::optional<std::vector<std::uint8_t>> push(const Field &field, bool even_at_rest = false);

  /// Returns the code of what a decoder holds (GridDecoder::state()), cell for cell the same, so
  /// that the places of the key fields can change and no value does. `ends_rest`: fields at rest
  /// were left out before it. Not to be mixed with push().
  std::vector<std::uint8_t> push_held(const State &held, bool ends_rest);

  /// The next field is a key field.
  void restart() noexcept { begun_ = false; }

private:
  bool needs_pair(const Field &field) const noexcept;
  void begin_pair(const Field &field, std::uint64_t interval, std::uint32_t step);
  std::vector<std::uint8_t> code(const Field &field, const std::vector<typename Cells::Cell> &next,
                                 bool ends_rest);

  std::uint64_t key_interval_;  // ns
  State state_;                 // the last field that was sent
  std::array<State, 2> keys_;   // the older one first; without cells: none
  std::uint64_t since_key_ = 0; // ns
  unsigned sent_ = 0;           // fields since the first key field of the pair, with it
  bool begun_ = false;
  bool rested_ = false; // a field was left out since the last one
};

template <typename Cells>
class GridDecoder {
public:
  using Field = typename Cells::Field;
  using State = CodedGrid<Field, typename Cells::Cell>;

  enum class Result {
    field,   ///< field() is the new one
    missing, ///< the field that it depends on was lost
    waiting, ///< there was no key field yet
    damaged  ///< it contradicts itself
  };

  /// field() changes only if the result is Result::field.
  Result push(std::span<const std::uint8_t> bytes);

  /// The last field that was decoded.
  const Field &field() const noexcept { return state_.field; }
  /// The same as its numbers.
  const State &state() const noexcept { return state_; }
  /// Returns whether fields between the last two of push() were lost. A sender that begins anew has
  /// lost none.
  bool lost() const noexcept { return lost_; }
  /// Returns whether fields were left out before this one because the frame rested. rest() is such
  /// a field.
  bool rested() const noexcept { return rested_; }
  const Field &rest() const noexcept { return rest_; }

  /// The next field has to be a key field.
  void forget() noexcept { *this = {}; }

private:
  const State *reference_of(std::uint8_t head, std::uint8_t sequence,
                            std::uint8_t distance) const noexcept;
  void set_rest();

  State state_;
  std::array<State, 2> keys_; // the older one first; without cells: none
  Field rest_;
  std::optional<std::uint8_t> sequence_; // of the last push() since a key field
  bool lost_ = false;
  bool rested_ = false;
};

using FieldEncoder = GridEncoder<MotionCells>;
using FieldDecoder = GridDecoder<MotionCells>;
using ReliefEncoder = GridEncoder<ReliefCells>;
using ReliefDecoder = GridDecoder<ReliefCells>;

extern template class GridEncoder<MotionCells>;
extern template class GridDecoder<MotionCells>;
extern template class GridEncoder<ReliefCells>;
extern template class GridDecoder<ReliefCells>;

} // namespace haptic
