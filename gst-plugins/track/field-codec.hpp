// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion fields in few bytes: velocities in steps as fine as a hand can feel, and only the cells
// that changed (docs/formats/field-code.md).
#pragma once

#include "motion-field.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// The most bytes of one coded field.
inline constexpr std::size_t kLargestCodedField = 60'000;

/// Returns whether a coded field can be decoded without those before it.
bool is_key_field(std::span<const std::uint8_t> bytes) noexcept;

/// The numbers of one cell that encoder and decoder both hold.
struct CodedCell {
  std::int16_t x = 0; ///< velocity as its number on the scale of the code
  std::int16_t y = 0;
  std::uint8_t confidence = 0; ///< 0..4
  bool changed = false;        ///< with the last field

  bool operator==(const CodedCell &) const = default;
};

/// What encoder and decoder both hold. A field is coded as the difference from it.
struct CodedState {
  MotionField field; ///< all but its cells as of the last field; its cells as they are decoded
  std::vector<CodedCell> cells;
  float unit = 0; ///< px/s that are one px per frame, since the last key field
  std::uint8_t sequence = 0;
};

class FieldEncoder {
public:
  /// Returns the code of a field, or nothing if the whole frame rests as before: such a field need
  /// not be sent. A key field comes first, after each second, after a cut, and when the frame or
  /// its grid changes. The field must be valid (is_valid()).
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
    field,   ///< field() is the new one
    missing, ///< one before it was lost: field() is silent until the next key field
    waiting, ///< there was no key field yet
    damaged  ///< it contradicts itself: field() is silent until the next key field
  };

  Result push(std::span<const std::uint8_t> bytes);

  /// Returns whether there was a key field, so that field() has cells.
  bool has_field() const noexcept { return !state_.cells.empty(); }
  /// The result of the last push().
  const MotionField &field() const noexcept { return state_.field; }
  /// Returns whether fields were left out before this one because the frame rested. rest() is such
  /// a field.
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
