// SPDX-License-Identifier: LGPL-2.1-or-later
// Compares what two files let a hand feel: see docs/comparing.md.
#pragma once

#include "felt/felt-file.hpp"

#include <optional>
#include <string>

namespace haptic {

struct CompareOptions {
  ForceLaw law;
  unsigned columns = 0; ///< of the grid of places; 0: not given
  unsigned rows = 0;
  std::string hand;              ///< a log whose hand feels the fields or reliefs
  std::string stream;            ///< of both files; empty: the first haptic one
  std::string plot;              ///< a .png to draw
  double offset = 0;             ///< s, added to the times of the second file
  std::optional<double> shift;   ///< s, by which the second file is late; none: what fits best
  std::optional<double> at_most; ///< percent of the time
  TimeRange range;               ///< of the first file
};

/// Prints how much of the time a hand could tell the files apart, as JSON or for people. Returns
/// the exit status: 1 if that is more than `at_most`. Throws TrackFileError.
int compare(const std::string &a, const std::string &b, const CompareOptions &options, bool json);

} // namespace haptic
