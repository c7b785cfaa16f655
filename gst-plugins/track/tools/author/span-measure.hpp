// SPDX-License-Identifier: LGPL-2.1-or-later
// Measures the motion of some spans of a film.
#pragma once

#include "author/chunk-file.hpp"
#include "author/film-index.hpp"

#include <functional>
#include <span>
#include <string>

namespace haptic {

/// At the begin of a span the tracker forgets what it learned: the noise, the motion before,
/// whether frames repeat. It is given this many frames before the span, so that it knows them
/// again. The encoder of the fields forgets everything and begins with a pair of key fields.
inline constexpr std::size_t kFramesBefore = 4;

struct SpanRange {
  std::size_t begin = 0; ///< index of a span
  std::size_t end = 0;   ///< behind the last one
};

/// Writes the fields of these spans, of the upright frame. They depend on the film and on `columns`
/// (0: as motionfield has it) alone, not on the range. `report` is called some times a second with
/// what was measured so far; what it throws ends the work. Throws TrackFileError.
ChunkStats
measure_spans(const std::string &path, unsigned columns, const FilmIndex &index, SpanRange range,
              ChunkWriter &out,
              const std::function<void(std::uint64_t frames, std::uint64_t position)> &report);

} // namespace haptic
