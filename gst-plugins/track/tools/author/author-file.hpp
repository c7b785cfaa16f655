// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes the copy of one film with the motion of its whole frame beside it.
#pragma once

#include "author/author-plan.hpp"
#include "author/chunk-file.hpp"

#include <string>
#include <vector>

namespace haptic {

/// Returns the copy of this film with these settings, or nothing if it is not there. Throws
/// TrackFileError where the copy would replace what is not its own. Only a film with an index knows
/// which file that is; without one, a file that author did not make is passed over.
std::string find_copy(const PlannedFilm &film, const AuthorOptions &options);

/// Writes NAME.haptic.ts, or NAME.haptic.mkv where MPEG-TS has no place for the film, and returns
/// its path. The copy appears under its name only when it is whole and on the disk. The fields come
/// from the chunks in their order. What it throws leaves nothing behind. Seeds GLib's random
/// numbers.
std::string write_copy(const PlannedFilm &film, const AuthorOptions &options,
                       const std::vector<ChunkReader> &chunks);

} // namespace haptic
