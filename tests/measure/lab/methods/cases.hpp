// SPDX-License-Identifier: LGPL-2.1-or-later
// The test cases: two frames, a position, and the true velocity.
#pragma once

#include "methods/methods.hpp"
#include "scenes/pairs.hpp"
#include "scenes/scenes.hpp"

#include <string>
#include <vector>

namespace lab {

struct Case {
  Task task;
  Vector truth;           ///< px per frame, mean over the region
  double bound = 0;       ///< Cramer-Rao, px; 0: not known
  int block = 0;          ///< cases of one block are not independent
  bool is_unseen = false; ///< the frames do not show the motion: only silence is right
  std::string scene{};
};

struct CaseSet {
  std::string name;
  std::vector<Case> cases;
  double x = 0; ///< of a series: what is varied
};

/// A seed is a hash of the set's name, so that no set changes when another is added.
std::uint64_t seed_of(const std::string &name);

/// "translation", "wide", "hard", and "pairs" unless there are none.
std::vector<CaseSet> strata(bool quick, const std::vector<TruePair> &pairs);

/// "hard": every hard scene so many times. Another `number` is another seed.
CaseSet hard_set(int per_scene, int number = 0);

/// "pairs": regions on a raster (px) over pairs with true flow.
CaseSet pairs_set(const std::vector<TruePair> &pairs, int raster);

/// Sets that differ in one parameter.
struct Series {
  std::string name;
  std::vector<CaseSet> sets;
};

/// "displacement" (px), "phase" (px), "noise" (grey levels), "contrast", "frame" (megapixels),
/// "region" (px).
std::vector<Series> all_series(bool quick);

/// For the cost of points: a rotation, which one patch does not explain, in a region for 64
/// patches.
CaseSet points_set(bool quick);

/// Frames of a stream, for the cost in normal operation.
struct Stream {
  std::string name;
  std::vector<cv::Mat> frames;
};

std::vector<Stream> streams(bool quick);

/// Pairs whose second frame is moved by a known shift, and the same pairs reversed in time. The
/// expected change of the answer is known without the true motion.
struct ClipCase {
  std::string clip;
  Task plain;
  Task shifted;
  Task reversed;
  Vector shift; ///< px
  int block = 0;
};

std::vector<ClipCase> clip_cases(const std::vector<Clip> &clips);

} // namespace lab
