// SPDX-License-Identifier: LGPL-2.1-or-later
// Cuts a film at IDR frames into segments of some seconds, each with its part of the field track.
#pragma once

#include "core/track-sample.hpp"
#include "film/film-reader.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace haptic {

/// ns, by which two copies of one film differ: transport streams and Matroska round times.
constexpr std::int64_t kSameTime = 1'000'000;

/// Returns ns as ticks of 90 kHz, the clock of transport streams, rounded.
constexpr std::int64_t ticks_of(std::int64_t ns) {
  return (ns * 9 + (ns < 0 ? -50'000 : 50'000)) / 100'000;
}

/// What is known of a film before it is cut. Times are ns from its first frame on.
struct FilmPlan {
  FilmFormat format;
  std::int64_t origin = 0;          ///< of the first frame in its file, ns
  std::size_t skipped = 0;          ///< frames before the first IDR frame
  std::vector<std::int64_t> times;  ///< of presentation, in order
  std::int64_t end = 0;             ///< of the last frame
  std::int64_t last_sound = -1;     ///< -1: none
  std::int64_t reordering = 0;      ///< the most by which a frame is presented before its turn
  std::vector<std::int64_t> starts; ///< of the segments
  std::int64_t longest = 0;         ///< segment

  std::int64_t start_of(std::size_t segment) const {
    return segment < starts.size() ? starts[segment] : end;
  }
};

/// A frame, in ticks of 90 kHz from the first frame of the film on.
struct SegmentFrame {
  std::int64_t presentation = 0;
  std::int64_t turn = 0; ///< the presentation of the frame that has this place in the order
  std::int64_t duration = 0;
  bool is_idr = false;
  std::vector<std::uint8_t> bytes; ///< as those of FilmFrame
};

struct SegmentSound {
  std::int64_t time = 0; ///< ns
  std::vector<std::uint8_t> bytes;
};

struct SegmentField {
  std::int64_t presentation = 0; ///< ticks
  FieldKind kind = FieldKind::motion;
  std::vector<std::uint8_t> set; ///< KLV
};

struct FilmSegment {
  std::size_t number = 0; ///< from 0
  std::int64_t start = 0; ///< ns
  std::int64_t end = 0;
  std::vector<SegmentFrame> frames;
  std::vector<SegmentSound> sounds;
  std::vector<SegmentField> fields; ///< the first one of each kind is a key field
};

/// Reads the whole film once. Throws TrackFileError if it cannot be cut, or not be played by a
/// browser.
FilmPlan plan_film(const std::string &path);

/// Reads the film again and calls `call` for each of its segments. The times of `track` are ns from
/// the first frame of the film on; it holds fields, reliefs or both.
void for_each_segment(const std::string &path, const FilmPlan &plan,
                      std::span<const CodedField> track,
                      const std::function<void(const FilmSegment &)> &call);

} // namespace haptic
