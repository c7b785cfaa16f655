// SPDX-License-Identifier: LGPL-2.1-or-later
// Measures the motion of some spans of a film.
#pragma once

#include "author/chunk-file.hpp"
#include "author/film-index.hpp"
#include "hold-point.hpp"

#include <span>
#include <string>
#include <vector>

namespace haptic {

/// At the begin of a span the tracker forgets what it learned: the noise, the motion before,
/// the layers, whether frames repeat. It is given this many frames before the span, so that it
/// knows them again: the layers count in full after 6 frames at 30 a second. The encoder of the
/// fields forgets everything and begins with a pair of key fields.
inline constexpr std::size_t kFramesBefore = 6;

/// Things of a film that are followed, so that whoever feels its track can hold them.
struct HoldOptions {
  bool chooses = false; ///< motionfield chooses kChosenThings of them
  std::vector<HoldPoint> points;
  bool operator==(const HoldOptions &) const = default;
};
inline constexpr unsigned kChosenThings = 16;

/// As read_hold_point() and the property `points` of motionfield read them, with spaces between
/// them, in the order given.
std::string write_hold_points(std::span<const HoldPoint> points);

struct SpanRange {
  std::size_t begin = 0; ///< index of a span
  std::size_t end = 0;   ///< behind the last one
};

/// Writes the fields of these spans, of the upright frame. They depend on the film, on `columns`
/// (0: as motionfield has it) and on `hold` alone, not on the range: things end with their span.
/// Prints every 10 s to stderr how much of the film has passed. Throws TrackFileError.
ChunkStats measure_spans(const std::string &path, unsigned columns, const HoldOptions &hold,
                         const FilmIndex &index, SpanRange range, ChunkWriter &out);

} // namespace haptic
