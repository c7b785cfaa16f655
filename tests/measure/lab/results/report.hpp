// SPDX-License-Identifier: LGPL-2.1-or-later
// The results: CSV for the charts, JSON for programs, tables for docs/lab-results.md.
#pragma once

#include "results/statistics.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace lab {

/// One configuration on one stratum.
struct SweepRow {
  std::string stratum;
  std::string method;
  std::string parameters;
  bool is_peer = false;
  bool is_default = false;
  int threads = 1;
  std::size_t cases = 0;
  double error = 0;    ///< px, mean
  Interval error_95{}; ///< of the mean
  double median = 0;   ///< px
  double p95 = 0;      ///< px
  double gross = 0;    ///< share of errors above half a pixel
  double time = 0;     ///< µs, median
  double time_99 = 0;  ///< µs
  bool on_front = false;
};

/// One method at one point of a series.
struct SeriesRow {
  std::string series;
  std::string method;
  double x = 0;
  double error = 0; ///< px, mean
  double bias = 0;  ///< px, length of the mean difference
  double gross = 0;
  double time = 0; ///< µs, median
};

struct StreamRow {
  std::string scene;
  double time = 0; ///< µs, median
  double time_99 = 0;
};

struct ReliabilityRow {
  std::string method;
  double confidence = 0; ///< middle of the bin
  std::size_t cases = 0;
  double good = 0; ///< share of errors of at most 0.3 px
  Interval good_95{};
};

struct RocRow {
  std::string method;
  RocPoint point;
};

struct SceneRow {
  std::string scene;
  std::string method;
  double error = 0; ///< px, mean
  double bound = 0; ///< px, Cramer-Rao
};

struct ClipRow {
  std::string clip;
  std::string method;
  std::size_t cases = 0;
  double answered = 0;    ///< share
  double shift_error = 0; ///< px, median
  double shift_95 = 0;
  double reversal_error = 0; ///< px, median
};

/// The motion of a whole frame on a grid, by one method.
struct FieldRow {
  std::string pair;
  std::string method;
  std::size_t cells = 0;     ///< cells with a known true motion
  double error = 0;          ///< px, mean over all cells; no answer counts as no motion
  double answered = 0;       ///< share of the cells with a confidence of 0.5 or more
  double error_answered = 0; ///< px, mean over these cells
  double p95_answered = 0;   ///< px
  double time = 0;           ///< ms, minimum of some passes
};

/// Motion vectors of H.264 and trackers on the same video.
struct VectorRow {
  std::string video;
  std::string method;
  std::size_t cases = 0;
  double answered = 0; ///< share
  double error = 0;    ///< px, mean; no answer counts as no motion
  double p95 = 0;      ///< px
  double decoding = 0; ///< µs of the decoder per frame, for vectors
  double time = 0;     ///< µs per region, median
};

/// What a part of the default is worth on one stratum.
struct AblationCell {
  std::string stratum;
  std::size_t frames = 0;
  double error = 0;      ///< px, mean with all parts
  double error_off = 0;  ///< px, mean without the part
  Interval difference{}; ///< px, 95 % interval of the mean of `error_off` - `error`
  double time = 0;       ///< µs, mean with all parts
  double time_off = 0;   ///< µs, in turns with it
};

struct AblationRow {
  std::string part;
  std::vector<AblationCell> cells;
  double area = 0;     ///< under the ROC curve, with all parts
  double area_off = 0; ///< without the part
  double step = 0;     ///< px, 99 % of the changes of an answer from frame to frame are smaller
  double step_off = 0;
};

struct Report {
  std::map<std::string, std::string> circumstances; ///< machine, compiler, commit, ...
  std::vector<SweepRow> sweep;
  std::vector<SeriesRow> series;
  std::vector<StreamRow> streams;
  std::vector<ReliabilityRow> reliability;
  std::vector<RocRow> roc;
  std::map<std::string, std::vector<double>> area; ///< under the ROC curve, by method, of each seed
  std::vector<SceneRow> scenes;
  std::vector<ClipRow> clips;
  std::vector<FieldRow> fields;
  std::vector<AblationRow> ablation;
  std::vector<VectorRow> vectors;
};

/// Marks the Pareto front of each stratum, from the rows with one thread.
void mark_fronts(std::vector<SweepRow> &sweep);

/// Peers that are at least as fast and at least as accurate as the default on some stratum.
std::vector<SweepRow> dominating_peers(const std::vector<SweepRow> &sweep);

/// ablation.csv and ablation.md. Throws std::runtime_error where a file cannot be written.
void write_ablation(const std::vector<AblationRow> &rows, const std::filesystem::path &folder);

/// sweep.csv, series.csv, streams.csv, reliability.csv, roc.csv, scenes.csv, clips.csv,
/// vectors.csv, fields.csv, lab.json, results.md and the files of write_ablation. Throws
/// std::runtime_error where a file cannot be written.
void write(Report report, const std::filesystem::path &folder);

} // namespace lab
