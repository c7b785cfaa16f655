// SPDX-License-Identifier: LGPL-2.1-or-later
// Authors videos: one process for each, or the steps that an engine for batches runs: a plan, its
// chunks in any order, and their merge.
#pragma once

#include "author/author-plan.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

struct AuthoredFilm {
  std::string copy;
  std::uint64_t frames = 0; ///< that were measured; 0: the copy was there
};

/// Makes the copy of one video, unless it is there. Throws TrackFileError.
AuthoredFilm author_film(const std::string &video, const AuthorOptions &options);

// These return the exit status: 0 if everything is done. Errors of a video are printed, and the
// other videos go on.

/// Makes the copies, `jobs` at a time. Forks, so GStreamer must not have been initialized.
int author(std::vector<std::string> files, const AuthorOptions &options, unsigned jobs);

/// Prints a plan of about `chunks` chunks; 0: one for each minute, not more than kMostChunks.
/// Videos that cannot be authored are not in it.
int plan_authoring(std::vector<std::string> files, const AuthorOptions &options, unsigned chunks);

/// Slurm's usual limit of an array of jobs (MaxArraySize).
inline constexpr unsigned kMostChunks = 1000;

/// Measures a chunk of the plan, counted from 0. Throws TrackFileError.
int author_chunk(const std::string &plan, unsigned chunk);

/// Makes the copies of a plan from its chunks and a manifest, and removes the chunks.
int merge_chunks(const std::string &plan);

} // namespace haptic
