// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion sample, a motion field or a relief as one line of text (docs/formats/text-line.md).
#pragma once

#include "core/track-sample.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace haptic {

/// What the lines of every version begin with, those of this version, and its lines of each kind.
inline constexpr std::string_view kTextName = "hv";
inline constexpr std::string_view kTextMagic = "hv1";
inline constexpr std::string_view kTextFieldStart = "hv1 field ";
inline constexpr std::string_view kTextReliefStart = "hv1 relief ";
inline constexpr std::string_view kTextPointStart = "hv1 point ";
static_assert(kTextMagic.starts_with(kTextName) && kTextFieldStart.starts_with(kTextMagic));

/// Whether a line of some version begins here: its name, its number and a blank. A word of a
/// subtitle may begin with the name, too.
bool begins_text_line(std::span<const std::uint8_t> bytes) noexcept;

/// Returns a line without a newline and without characters that mark-up would escape. Reading its
/// numbers gives the same bits.
std::string write_text_line(const TrackSample &sample);
std::string write_text_line(const CodedField &field);

struct TextLine {
  std::optional<TrackSample> sample;
  std::optional<CodedField> field;
  std::string error; ///< what is wrong, if there is neither
};

/// Blanks, newlines and zeros around the line are ignored.
TextLine read_text_line(std::string_view line);

} // namespace haptic
