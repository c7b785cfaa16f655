// SPDX-License-Identifier: LGPL-2.1-or-later
// One frame of a film as JPEG.
#pragma once

#include "package/film-segments.hpp"

namespace haptic {

/// Returns an IDR frame with square pixels. Throws TrackFileError if it cannot be decoded.
std::vector<std::uint8_t> poster_of(const FilmFormat &format, const SegmentFrame &frame);

} // namespace haptic
