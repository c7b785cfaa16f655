// SPDX-License-Identifier: LGPL-2.1-or-later
// What is remarkable in a file and ends nothing: all of it is said in one place.
#pragma once

#include "forms/track-form.hpp"

#include <string>
#include <variant>
#include <vector>

namespace haptic {

/// track-remark.cpp has the sentence of each.
enum class FileRemark {
  damaged_line,
  damaged_set,
  further_damage,
  other_sets,
  damaged_unit,
  cut_unit,
  no_unit,
  unsupported,
  ends_early,
  longer_than_film,
  other_frame,
  points_beside_fields,
  reliefs_beside_motion,
  further_tracks,
  stream_left_out,
  frames_before_idr,
  long_segments,
  rates_not_aligned
};

struct Remark {
  std::variant<FileRemark, TrackProblemKind> kind;
  std::string text;
};

/// `...`: the values of its sentence.
Remark remark(FileRemark kind, ...);

/// Print it on the standard error.
void print_remark(const std::string &path, const Remark &remark);
void print_remarks(const std::string &path, const std::vector<Remark> &remarks);

} // namespace haptic
