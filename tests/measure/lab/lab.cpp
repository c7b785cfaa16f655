// SPDX-License-Identifier: LGPL-2.1-or-later
// Speed against accuracy of the project's trackers and their peers. run.sh builds, runs and draws.
#include "methods/ablation.hpp"
#include "methods/confidence.hpp"
#include "methods/fields.hpp"
#include "methods/measure.hpp"
#include "methods/motion-vectors.hpp"
#include "processor.hpp"
#include "results/report.hpp"
#include "scenes/h264.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <string_view>
#include <thread>
#include <unistd.h>

namespace {

using namespace lab;
namespace fs = std::filesystem;

struct Options {
  bool quick = false;
  bool only_ablation = false;
  std::optional<fs::path> pairs;
  std::optional<fs::path> clips;
  fs::path output;
  std::string commit = "unknown";
};

Options parse(int argc, char **argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    if (name == "--quick") {
      options.quick = true;
      continue;
    }
    if (name == "--ablation") {
      options.only_ablation = true;
      continue;
    }
    if (i + 1 == argc)
      throw std::runtime_error("option '" + std::string(name) + "' is unknown or lacks its value");
    const char *value = argv[++i];
    if (name == "--pairs")
      options.pairs = value;
    else if (name == "--clips")
      options.clips = value;
    else if (name == "--output")
      options.output = value;
    else if (name == "--commit")
      options.commit = value;
    else
      throw std::runtime_error("unknown option '" + std::string(name) + "'");
  }
  if (options.output.empty())
    throw std::runtime_error("where shall the results go? --output FOLDER");
  return options;
}

// Progress: the step, its share done and the time left, on one line of a terminal.
class Progress {
public:
  Progress(std::string what, std::size_t total) : what_(std::move(what)), total_(total) {}
  ~Progress() {
    if (on_terminal_)
      std::cerr << "\r\33[K";
    std::cerr << what_ << ": done in " << static_cast<int>(elapsed()) << " s\n";
  }
  Progress(const Progress &) = delete;
  Progress &operator=(const Progress &) = delete;

  void step(const std::string &name) {
    // Not in a log file.
    if (on_terminal_ || done_ % (total_ / 10 + 1) == 0) {
      std::cerr << (on_terminal_ ? "\r\33[K" : "") << what_ << ": " << done_ << '/' << total_;
      if (done_ > 0)
        std::cerr << ", "
                  << static_cast<int>(elapsed() / static_cast<double>(done_) *
                                      static_cast<double>(total_ - done_))
                  << " s left";
      std::cerr << ", " << name << (on_terminal_ ? "" : "\n") << std::flush;
    }
    ++done_;
  }

private:
  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

  std::string what_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool on_terminal_ = isatty(STDERR_FILENO) != 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

std::string today() {
  const std::time_t now = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d", std::gmtime(&now));
  return text;
}

// Methods on whole frames are slow: only every fourth case.
std::size_t stride_of(const Configuration &configuration) {
  return configuration.method.starts_with("PyrLK frame") ? 4 : 1;
}

std::vector<double> errors_of(const std::vector<Answer> &answers) {
  std::vector<double> errors;
  for (const Answer &answer : answers)
    errors.push_back(answer.error);
  return errors;
}

std::vector<double> times_of(const std::vector<Answer> &answers) {
  std::vector<double> times;
  for (const Answer &answer : answers)
    times.push_back(answer.time);
  return times;
}

double share_above(const std::vector<double> &values, double limit) {
  return static_cast<double>(
             std::ranges::count_if(values, [&](double value) { return value > limit; })) /
         static_cast<double>(values.size());
}

SweepRow sweep_row(const Configuration &c, const CaseSet &set, const std::vector<Answer> &answers,
                   int threads) {
  const std::vector<double> errors = errors_of(answers);
  std::vector<int> blocks;
  for (std::size_t i = 0; i < set.cases.size(); i += stride_of(c))
    blocks.push_back(set.cases[i].block);
  return {.stratum = set.name,
          .method = c.method,
          .parameters = c.parameters,
          .is_peer = c.is_peer,
          .is_default = c.is_default,
          .threads = threads,
          .cases = answers.size(),
          .error = mean(errors),
          .error_95 = bootstrap(errors, blocks, seed_of("bootstrap")),
          .median = percentile(errors, 0.5),
          .p95 = percentile(errors, 0.95),
          .gross = share_above(errors, 0.5),
          .time = percentile(times_of(answers), 0.5),
          .time_99 = percentile(times_of(answers), 0.99)};
}

std::vector<Configuration> defaults_of(const std::vector<Configuration> &all) {
  std::vector<Configuration> defaults;
  std::ranges::copy_if(all, std::back_inserter(defaults), &Configuration::is_default);
  return defaults;
}

void run_sweep(const std::vector<Configuration> &all, const std::vector<CaseSet> &sets,
               Report &report) {
  Progress progress("sweep", all.size());
  for (const Configuration &c : all) {
    progress.step(c.method + " " + c.parameters);
    for (const CaseSet &set : sets)
      report.sweep.push_back(sweep_row(c, set, measure(c, set, stride_of(c)), 1));
  }
}

void run_threads(const std::vector<Configuration> &defaults, const CaseSet &set, Report &report) {
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  if (threads < 2)
    return;
  cv::setNumThreads(threads);
  Progress progress("all threads", defaults.size());
  for (const Configuration &c : defaults) {
    progress.step(c.method);
    report.sweep.push_back(sweep_row(c, set, measure(c, set, stride_of(c)), threads));
  }
  cv::setNumThreads(1);
}

SeriesRow series_row(const std::string &series, double x, const Configuration &c,
                     const CaseSet &set) {
  const std::vector<Answer> answers = measure(c, set);
  const std::vector<double> errors = errors_of(answers);
  Vector bias;
  for (const Answer &answer : answers)
    bias += answer.difference / static_cast<double>(answers.size());
  return {.series = series,
          .method = c.method,
          .x = x,
          .error = mean(errors),
          .bias = cv::norm(bias),
          .gross = share_above(errors, 0.5),
          .time = percentile(times_of(answers), 0.5)};
}

void run_series(const std::vector<Configuration> &defaults, bool quick, Report &report) {
  const std::vector<Series> all = all_series(quick);
  Progress progress("series", all.size() + 1);
  for (const Series &series : all) {
    progress.step(series.name);
    for (const CaseSet &set : series.sets) {
      double bound = 0;
      for (const Case &one : set.cases)
        bound += one.bound / static_cast<double>(set.cases.size());
      report.series.push_back(
          {.series = series.name, .method = "bound", .x = set.x, .error = bound});
      for (const Configuration &c : defaults)
        report.series.push_back(series_row(series.name, set.x, c, set));
    }
  }
  progress.step("points");
  const CaseSet set = points_set(quick);
  for (const int points : quick ? std::vector{4, 64} : std::vector{4, 8, 16, 20, 32, 48, 64})
    for (const Configuration &c : configurations_of(points))
      report.series.push_back(series_row("points", points, c, set));
}

void run_streams(bool quick, Report &report) {
  const auto method = make_fast();
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> times;
  for (const Stream &stream : streams(quick)) {
    if (!times.contains(stream.name))
      order.push_back(stream.name);
    measure(*method, stream); // warms up
    auto &list = times[stream.name];
    const std::vector<double> some = measure(*method, stream);
    list.insert(list.end(), some.begin(), some.end());
  }
  for (const std::string &name : order)
    report.streams.push_back({name, percentile(times[name], 0.5), percentile(times[name], 0.99)});
}

void run_confidence(const std::vector<Configuration> &defaults, bool quick, Report &report) {
  const Progress progress("confidence", 1);
  measure_confidence(defaults, quick, report);
}

void run_scenes(const std::vector<Configuration> &defaults, const CaseSet &hard, Report &report) {
  std::map<std::string, std::vector<Answer>> answers;
  for (const Configuration &c : defaults)
    answers[c.method] = measure(c, hard);
  for (std::size_t first = 0; first < hard.cases.size();) {
    std::size_t end = first;
    double bound = 0;
    while (end < hard.cases.size() && hard.cases[end].scene == hard.cases[first].scene)
      bound += hard.cases[end++].bound;
    const auto count = static_cast<double>(end - first);
    for (const Configuration &c : defaults) {
      double sum = 0;
      for (std::size_t i = first; i < end; ++i)
        sum += answers[c.method][i].error;
      report.scenes.push_back({hard.cases[first].scene, c.method, sum / count, bound / count});
    }
    first = end;
  }
}

void run_clips(const std::vector<Configuration> &defaults, const std::vector<Clip> &clips,
               Report &report) {
  const std::vector<ClipCase> cases = clip_cases(clips);
  Progress progress("clips", defaults.size());
  for (const Configuration &c : defaults) {
    progress.step(c.method);
    if (c.method.starts_with("PyrLK frame") || c.method == "always zero")
      continue;
    const auto method = c.make();
    std::map<std::string, std::vector<Equivariance>> by_clip;
    for (const ClipCase &one : cases)
      by_clip[one.clip].push_back(measure(*method, one));
    for (const auto &[clip, all] : by_clip) {
      std::vector<double> shift;
      std::vector<double> reversal;
      for (const Equivariance &e : all)
        if (e.is_answered) {
          shift.push_back(e.shift_error);
          reversal.push_back(e.reversal_error);
        }
      report.clips.push_back({clip, c.method, all.size(),
                              static_cast<double>(shift.size()) / static_cast<double>(all.size()),
                              percentile(shift, 0.5), percentile(shift, 0.95),
                              percentile(reversal, 0.5)});
    }
  }
}

std::vector<AblationRow> run_ablation(bool quick, const std::vector<TruePair> &pairs) {
  const Progress progress("parts", 1);
  return measure_ablation(quick, pairs);
}

int run(const Options &options) {
  cv::setNumThreads(1);
  Report report;
  const std::string why = why_no_motion_vectors();
  report.circumstances = {
      {"processor", test::processor()},
      {"threads of the machine", std::to_string(std::thread::hardware_concurrency())},
      {"compiler", "GCC " __VERSION__},
      {"compiler options", LAB_COMPILER_OPTIONS},
      {"OpenCV", cv::getVersionString()},
      {"commit", options.commit},
      {"date", today()},
      {"seeds", "FNV-1a of each set's name"},
      {"extent", options.quick ? "quick" : "full"},
      {"scenes of H.264", has_h264() ? "yes" : "left out, x264enc or avdec_h264 is not installed"},
      {"motion vectors of H.264", why.empty() ? "yes" : "left out, " + why}};
  const std::vector<TruePair> pairs =
      options.pairs ? read_pairs(*options.pairs) : std::vector<TruePair>();
  if (options.only_ablation) {
    write_ablation(run_ablation(options.quick, pairs), options.output);
    return EXIT_SUCCESS;
  }
  std::vector<CaseSet> sets;
  {
    const Progress progress("rendering", 1);
    sets = strata(options.quick, pairs);
  }
  const std::vector<Configuration> all = configurations(options.quick);
  const std::vector<Configuration> defaults = defaults_of(all);
  run_sweep(all, sets, report);
  run_threads(defaults, sets.front(), report);
  run_series(defaults, options.quick, report);
  run_streams(options.quick, report);
  run_confidence(defaults, options.quick, report);
  run_scenes(defaults, sets.back(), report);
  report.fields = measure_fields(pairs);
  {
    const Progress progress("motion vectors", 1);
    report.vectors = measure_vectors(options.quick, options.clips);
  }
  report.ablation = run_ablation(options.quick, pairs);
  if (options.clips)
    run_clips(defaults, read_clips(*options.clips, options.quick ? 1 : 6, options.quick ? 2 : 5),
              report);
  mark_fronts(report.sweep);
  write(report, options.output);

  const std::vector<SweepRow> ahead = dominating_peers(report.sweep);
  for (const SweepRow &row : ahead)
    std::cout << "dominates the default on " << row.stratum << ": " << row.method << ' '
              << row.parameters << ", " << row.time << " µs, " << row.error << " px\n";
  if (!ahead.empty())
    return EXIT_FAILURE;
  std::cout << "No configuration of a peer dominates the default.\n";
  return EXIT_SUCCESS;
}

} // namespace

int main(int argc, char **argv) {
  try {
    return run(parse(argc, argv));
  } catch (const std::exception &error) {
    std::cerr << "lab: " << error.what() << '\n';
    return 2;
  }
}
