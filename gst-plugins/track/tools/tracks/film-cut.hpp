// SPDX-License-Identifier: LGPL-2.1-or-later
// Cuts a film together with its track.
#pragma once

#include "film/film-streams.hpp"
#include "tracks/track-file.hpp"

#include <cstdint>
#include <string>

namespace haptic {

/// Writes a part of the file `path`, whose track is `track`, as .ts or .mkv, nothing encoded anew.
/// It begins with the last key frame of the first video that is not behind `from` (ns), ends before
/// the first one that is not before `to`, and its times begin at 0, or later by as much as a key
/// frame is decoded before it is shown. Says on the standard error what is left out.
/// Throws TrackFileError, which leaves nothing behind.
void cut_film(const std::string &path, TrackFile track, std::uint64_t from, std::uint64_t to,
              const std::string &output);

} // namespace haptic
