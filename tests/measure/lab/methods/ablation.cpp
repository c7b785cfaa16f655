// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/ablation.hpp"

#include "methods/cases.hpp"
#include "methods/measure.hpp"
#include "scenes/h264.hpp"

#include <algorithm>

namespace lab {
namespace {

constexpr int kSide = 30;
const cv::Size kFrame(352, 288);

// Frames that one tracker sees one after the other. There is one truth less than frames.
struct Sequence {
  std::vector<cv::Mat> frames;
  std::vector<Vector> truths; // px per frame
  Vector pointer{0.5, 0.5};
  bool is_unseen = false;
  int block = 0;
};

struct Stratum {
  std::string name;
  std::vector<Sequence> sequences;
};

// A scene and the times of its frames: no longer than its truth holds and its texture reaches.
struct Excerpt {
  const char *scene; // nullptr: translations within 3 px
  double first = 0;
  int frames = 6;
};

struct Group {
  const char *name;
  std::vector<Excerpt> excerpts;
};

const std::vector<Group> &groups() {
  static const std::vector<Group> all = {
      {"rest",
       {{"still noise 1.5"},
        {"still noise 5"},
        {"still noise 10"},
        {"textureless"},
        {"jpeg still"},
        {"h264 still"}}},
      {"translation",
       {{nullptr}, {"noise 10"}, {"low contrast"}, {"motion blur"}, {"jpeg moving"}}},
      {"wide", {{"displacement 8", 0, 5}, {"displacement 12", 0, 4}, {"displacement 16", 0, 3}}},
      {"light",
       {{"gain 0.7", 0, 2},
        {"gain 1.4", 0, 2},
        {"offset -40", 0, 2},
        {"offset +40", 0, 2},
        {"standing shadow"},
        {"moving shadow", 0, 4}}},
      {"bent",
       {{"rotation"}, {"zoom", 0, 4}, {"affine", 0, 2}, {"curl", 0, 4}, {"rolling shutter", 0, 4}}},
      {"mixed",
       {{"two motions"},
        {"mover", -1, 4},
        {"overlay"},
        {"saturated sky", 0, 4},
        {"camera shake", 0, 2},
        {"interlaced"}}},
      {"waves", {{"aperture"}}},
      {"unseen", {{"scene cut", 0, 2}, {"periodic", 0, 2}}},
  };
  return all;
}

Sequence sequence_of(const Movie &movie, const Excerpt &excerpt, Random &random) {
  // The key frame is so many frames before the first.
  const int before = movie.h264_crf > 0 ? 3 : 0;
  std::vector<cv::Mat> frames;
  for (int i = -before; i < excerpt.frames; ++i)
    frames.push_back(expose(movie, excerpt.first + i, random));
  if (movie.h264_crf > 0)
    frames = through_h264(frames, movie.h264_crf);
  Sequence sequence;
  for (auto frame = frames.begin() + before; frame != frames.end(); ++frame)
    sequence.frames.push_back(embed(*frame, kFrame));
  sequence.truths.assign(sequence.frames.size() - 1, movie.velocity);
  sequence.is_unseen = movie.is_unseen;
  return sequence;
}

// Waves that move by more than half their length at last, which only the frames before tell.
Sequence waves_that_speed_up(Random &random) {
  const Movie movie = scene_named(hard_scenes(kSide), "periodic").make(random);
  Sequence sequence;
  double place = 0;
  sequence.frames.push_back(embed(expose(movie, 0, random), kFrame));
  for (const double shift : {1.0, 2.0, 3.0, 4.0, 5.0, 5.0}) {
    place += shift / movie.velocity.x;
    sequence.frames.push_back(embed(expose(movie, place, random), kFrame));
    sequence.truths.emplace_back(shift, 0);
  }
  return sequence;
}

Stratum rendered(const Group &group, int count) {
  const std::vector<Scene> scenes = hard_scenes(kSide);
  Stratum stratum{group.name, {}};
  const auto add = [&](Sequence sequence) {
    sequence.block = static_cast<int>(stratum.sequences.size());
    stratum.sequences.push_back(std::move(sequence));
  };
  Random random(seed_of(std::string("ablation ") + group.name));
  for (const Excerpt &excerpt : group.excerpts) {
    const auto found = std::ranges::find_if(
        scenes, [&](const Scene &s) { return excerpt.scene && s.name == excerpt.scene; });
    if (excerpt.scene && found == scenes.end())
      continue; // H.264 is not installed
    for (int i = 0; i < count; ++i)
      add(sequence_of(excerpt.scene ? found->make(random) : uniform_translation(random, 3), excerpt,
                      random));
  }
  if (stratum.name == "waves")
    for (int i = 0; i < count; ++i)
      add(waves_that_speed_up(random));
  return stratum;
}

std::vector<Stratum> all_strata(bool quick, const std::vector<TruePair> &pairs) {
  std::vector<Stratum> strata;
  for (const Group &group : groups())
    strata.push_back(rendered(group, quick ? 1 : 12));
  if (pairs.empty())
    return strata;
  Stratum real{"pairs", {}};
  for (const Case &one : pairs_set(pairs, quick ? 45 : 15).cases)
    real.sequences.push_back(
        {{one.task.previous, one.task.current}, {one.truth}, one.task.pointer, false, one.block});
  strata.push_back(std::move(real));
  return strata;
}

// One entry a frame after the first, over all sequences.
struct Observations {
  std::vector<double> errors; // px
  std::vector<double> confidences;
  std::vector<double> times; // µs, the least of all passes
  std::vector<double> steps; // px, change of the difference from the truth since the frame before
};

void observe(Method &method, const Stratum &stratum, bool is_first, Observations &seen) {
  std::size_t at = 0;
  for (const Sequence &sequence : stratum.sequences) {
    method.forget();
    Vector before;
    for (std::size_t i = 1; i < sequence.frames.size(); ++i, ++at) {
      const Task task{sequence.frames[i - 1], sequence.frames[i], sequence.pointer, kSide, i > 1};
      const auto begin = Clock::now();
      const Reading reading = method.measure(task);
      const double time = microseconds_since(begin);
      if (!is_first) {
        seen.times[at] = std::min(seen.times[at], time);
        continue;
      }
      const Vector difference =
          (reading.confidence > 0 ? reading.velocity : Vector()) - sequence.truths[i - 1];
      seen.times.push_back(time);
      seen.confidences.push_back(reading.confidence);
      seen.errors.push_back(cv::norm(difference));
      if (i > 1)
        seen.steps.push_back(cv::norm(difference - before));
      before = difference;
    }
  }
}

// Answers and steps of all rendered strata.
struct Total {
  Judged judged;
  std::vector<double> steps;

  void add(const Stratum &stratum, const Observations &seen) {
    steps.insert(steps.end(), seen.steps.begin(), seen.steps.end());
    std::size_t at = 0;
    for (const Sequence &sequence : stratum.sequences)
      for (std::size_t i = 0; i < sequence.truths.size(); ++i, ++at)
        judged.add(seen.confidences[at], seen.errors[at], sequence.is_unseen);
  }
};

AblationCell compare(const Stratum &stratum, const Observations &with, const Observations &off) {
  std::vector<double> differences;
  std::vector<int> blocks;
  for (std::size_t i = 0; i < with.errors.size(); ++i)
    differences.push_back(off.errors[i] - with.errors[i]);
  for (const Sequence &sequence : stratum.sequences)
    blocks.insert(blocks.end(), sequence.truths.size(), sequence.block);
  return {.stratum = stratum.name,
          .frames = with.errors.size(),
          .error = mean(with.errors),
          .error_off = mean(off.errors),
          .difference = bootstrap(differences, blocks, seed_of("bootstrap")),
          .time = mean(with.times),
          .time_off = mean(off.times)};
}

} // namespace

std::vector<AblationRow> measure_ablation(bool quick, const std::vector<TruePair> &pairs) {
  const int passes = quick ? 2 : 9;
  const std::vector<Stratum> strata = all_strata(quick, pairs);
  std::vector<AblationRow> rows;
  for (const Configuration &configuration : configurations_without_parts()) {
    const auto whole = make_fast();
    const auto without = configuration.make();
    AblationRow row{.part = configuration.parameters};
    Total total;
    Total total_off;
    for (const Stratum &stratum : strata) {
      Observations with;
      Observations off;
      for (int pass = 0; pass < passes; ++pass) {
        // Each is second every other time, when the frames are in the cache.
        if (pass % 2 == 0)
          observe(*whole, stratum, pass == 0, with);
        observe(*without, stratum, pass == 0, off);
        if (pass % 2 != 0)
          observe(*whole, stratum, false, with);
      }
      row.cells.push_back(compare(stratum, with, off));
      if (stratum.name == "pairs")
        continue;
      total.add(stratum, with);
      total_off.add(stratum, off);
    }
    row.area = total.judged.area();
    row.area_off = total_off.judged.area();
    row.step = percentile(total.steps, 0.99);
    row.step_off = percentile(total_off.steps, 0.99);
    rows.push_back(std::move(row));
  }
  return rows;
}

} // namespace lab
