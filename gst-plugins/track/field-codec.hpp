// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion fields in few bytes: a step between what can be felt apart, and only the cells that
// changed (docs/formats/field-code.md).
#pragma once

#include "motion-field.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// The most bytes that FieldEncoder makes of one field, however wild.
inline constexpr std::size_t kLargestCodedField = 60'000;

/// Whether a coded field stands for itself; the others need those before it.
bool is_key_field(std::span<const std::uint8_t> bytes) noexcept;

/// What both sides hold of one cell.
struct CodedCell {
  std::int16_t x = 0; ///< velocity as its number on the scale of the code
  std::int16_t y = 0;
  std::uint8_t confidence = 0; ///< 0..4
  bool changed = false;        ///< with the last field

  bool operator==(const CodedCell &) const = default;
};

/// What both sides hold: with it a field is coded as its difference.
struct CodedState {
  MotionField field; ///< all but its cells as of the last field; its cells as they are decoded
  std::vector<CodedCell> cells;
  float unit = 0; ///< px/s that are one px per frame, since the last key field
  std::uint8_t sequence = 0;
};

class FieldEncoder {
public:
  /// Nothing, if the whole frame rests as it did before: this need not be sent. A key field comes
  /// first, after a second, after a cut, and when the frame or its grid changes. The field must
  /// be one that unpack_motion_field() would take.
  std::optional<std::vector<std::uint8_t>> push(const MotionField &field);

  /// The next field is a key field.
  void restart() noexcept { begun_ = false; }

private:
  bool needs_key(const MotionField &field) const noexcept;
  bool rests_on(const MotionField &field) const noexcept;

  CodedState state_;
  std::uint64_t since_key_ = 0; // ns
  unsigned sent_ = 0;           // fields since the key field, with it
  bool begun_ = false;
  bool rested_ = false; // a field was left out since the last one
};

class FieldDecoder {
public:
  enum class Result {
    field,   ///< see field()
    missing, ///< one before it was lost: field() is silent until the next key field
    waiting, ///< there was no key field yet: nothing is known
    damaged  ///< it contradicts itself: as if it, too, were lost
  };

  Result push(std::span<const std::uint8_t> bytes);

  /// Whether field() is of any use: there was a key field.
  bool has_field() const noexcept { return !state_.cells.empty(); }
  /// What the last push() gave.
  const MotionField &field() const noexcept { return state_.field; }
  /// Whether fields were left out before this one because the frame rested: rest() is what they
  /// said.
  bool rested() const noexcept { return rested_; }
  const MotionField &rest() const noexcept { return rest_; }

  /// The next field has to be a key field.
  void forget() noexcept { state_.cells.clear(), broken_ = true; }

private:
  Result break_off(Result result);

  CodedState state_;
  MotionField rest_;
  bool broken_ = true;
  bool rested_ = false;
};

} // namespace haptic
