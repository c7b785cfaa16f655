// A motion sample as one line of text (docs/formats/text-line.md).
#pragma once

#include "track-sample.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace haptic {

/// Without a newline, and without characters that mark-up would escape. Numbers are written so that
/// reading them gives the same bits.
std::string write_text_line(const TrackSample &sample);

struct TextLine {
  std::optional<TrackSample> sample;
  std::string error; ///< what is wrong, if there is no sample
};

/// Blanks, newlines and zeros around the line are ignored.
TextLine read_text_line(std::string_view line);

} // namespace haptic
