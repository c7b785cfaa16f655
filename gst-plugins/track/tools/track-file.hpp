// SPDX-License-Identifier: LGPL-2.1-or-later
// Haptic tracks as files, in all forms there are.
#pragma once

#include "track-error.hpp"
#include "track-sample.hpp"

#include <string>
#include <vector>

namespace haptic {

struct TrackFile {
  std::string form;                 ///< for people to read
  std::vector<std::string> beside;  ///< caps of the other streams in the file
  std::vector<std::string> remarks; ///< what was left out or guessed, and why
  std::vector<TrackSample> samples; ///< with times; or else
  std::vector<CodedField> fields;   ///< with times

  bool empty() const noexcept { return samples.empty() && fields.empty(); }
};

/// By content, whatever the name. Throws TrackFileError.
TrackFile read_track_file(const std::string &path);

/// By the ending: .ts, .mkv, .klv, .txt, .hmpg, .hjif. Appears under its name only when it is
/// whole. Throws TrackFileError.
void write_track_file(const std::string &path, const TrackFile &track);

} // namespace haptic
