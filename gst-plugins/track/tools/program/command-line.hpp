// SPDX-License-Identifier: LGPL-2.1-or-later
// The command line of haptic-track: a verb, its options and its files.
#pragma once

#include "author/author.hpp"
#include "package/package.hpp"
#include "plot/track-plot.hpp"
#include "program/compare.hpp"
#include "vibration/vibration-file.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace haptic {

struct Arguments {
  std::vector<std::string> files;
  bool overwrites = false;
  bool json = false;
  bool with_video = false;
  AuthorOptions author;
  CompareOptions compare; ///< with what other verbs take, too
  PlotOptions plot;
  VibrationOptions vibration;
  Carriage carriage = Carriage::fragments;
  unsigned chunk = 0;
  unsigned chunks = 0; ///< 0: not given
  unsigned jobs = std::max(1U, std::thread::hardware_concurrency());
};

struct Verb {
  const char *name;              ///< with a flag that makes it another one: "author --plan"
  int (*run)(const Arguments &); ///< returns the exit status
  std::size_t least;             ///< files
  std::size_t most;
  const char *needs;      ///< the files, for people to read
  const char *parameters; ///< what stands behind the options
  const char *options;    ///< between spaces
  const char *summary;    ///< the first line is of the list of verbs
  const char *example;
  bool forks = false; ///< GStreamer is not initialized before
};

/// Runs the verb that the command line names, or prints the help that it asks for. Returns the exit
/// status. Throws TrackFileError.
int run_verb(std::span<const Verb> verbs, int argc, char **argv);

} // namespace haptic
