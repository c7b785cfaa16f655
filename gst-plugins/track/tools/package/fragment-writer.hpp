// SPDX-License-Identifier: LGPL-2.1-or-later
// Segments of a film as fragments of MP4 (ISO/IEC 14496-12) with the fields as events beside them
// (ISO/IEC 23009-1, 5.10.3.3; MISB ST 1910).
#pragma once

#include "package/film-segments.hpp"

namespace haptic {

class FragmentWriter {
public:
  explicit FragmentWriter(const FilmFormat &format) : format_(format) {}

  /// Returns the head that all segments share.
  std::vector<std::uint8_t> head() const;

  /// Segments must come in their order: sound is counted on where it has no gap.
  std::vector<std::uint8_t> write(const FilmSegment &segment);

  /// Returns the bytes of the track so far, with all around it.
  std::size_t track_bytes() const noexcept { return track_bytes_; }

private:
  const FilmFormat &format_;
  std::int64_t sounded_ = -1; // end of the sound so far, in samples; -1: none
  std::size_t track_bytes_ = 0;
  std::uint32_t events_ = 0;
};

} // namespace haptic
