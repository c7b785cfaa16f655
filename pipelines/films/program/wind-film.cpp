// SPDX-License-Identifier: LGPL-2.1-or-later
// Draws a film of a tree, a meadow and a flag in gusts, with its true motion as a track:
//
//   wind-film wind.ts
//
// Returns 0 when the file is complete, 1 after an error, which it prints with its cure.
#include "program/film-file.hpp"
#include "program/truth.hpp"
#include "scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

namespace {

using film::FilmError;

struct Options {
  int width = 960;
  int height = 540;
  int rate = 60; // Hz
  double duration = 20;
  double at = 4; // s, of a still
  gint64 seed = 1;
  int quality = film::kUsualQuality;
  std::string truth;  // folder
  std::string places; // of the truth
  film::TruthOf truth_of = film::TruthOf::square;
  std::string points; // file
  std::string output;
};

Options read_options(int argc, char **argv) {
  Options read;
  gchar **rest = nullptr;
  gchar *truth = nullptr;
  gchar *places = nullptr;
  gchar *truth_of = nullptr;
  gchar *points = nullptr;
  const GOptionEntry entries[] = {
      {"width", 0, 0, G_OPTION_ARG_INT, &read.width, "Width of the frames (default: 960)", "PX"},
      {"height", 0, 0, G_OPTION_ARG_INT, &read.height, "Height of the frames (default: 540)", "PX"},
      {"rate", 0, 0, G_OPTION_ARG_INT, &read.rate, "Frames a second (default: 60)", "HZ"},
      {"duration", 0, 0, G_OPTION_ARG_DOUBLE, &read.duration, "Length of the film (default: 20)",
       "S"},
      {"seed", 0, 0, G_OPTION_ARG_INT64, &read.seed,
       "Another number draws another tree and other gusts (default: 1)", "N"},
      {"quality", 0, 0, G_OPTION_ARG_INT, &read.quality,
       "Quantizer of the encoder, from 0 (without loss) to 51 (the coarsest) (default: 23)", "N"},
      {"truth", 0, 0, G_OPTION_ARG_FILENAME, &truth,
       "Also writes the exact motion at each place as a text track X-Y.txt into this folder",
       "FOLDER"},
      {"places", 0, 0, G_OPTION_ARG_STRING, &places,
       "The places of --truth, 0 to 1 from the top left", "X,Y X,Y …"},
      {"truth-of", 0, 0, G_OPTION_ARG_STRING, &truth_of,
       "What --truth averages: the usual region of roitracker, or only what moves there with the "
       "pixel at the place (default: square)",
       "square|pointed"},
      {"points", 0, 0, G_OPTION_ARG_FILENAME, &points,
       "Also writes a table (CSV) of where points of leaves, branches, grass and flag are in each "
       "frame",
       "FILE"},
      {"at", 0, 0, G_OPTION_ARG_DOUBLE, &read.at, "Time of a still (default: 4)", "S"},
      {G_OPTION_REMAINING, 0, 0, G_OPTION_ARG_FILENAME_ARRAY, &rest, nullptr, "OUTPUT"},
      {}};
  GOptionContext *context = g_option_context_new(nullptr);
  g_option_context_set_summary(
      context,
      "Draws a film of a tree, a meadow and a flag in gusts.\n\n"
      "OUTPUT ends in .ts (MPEG-TS) or .mkv (Matroska) for a film with a haptic track of its true "
      "motion, or in .png for a still.\n\nExample: wind-film --duration 5 wind.ts");
  g_option_context_add_main_entries(context, entries, nullptr);
  GError *error = nullptr;
  g_option_context_parse(context, &argc, &argv, &error);
  g_option_context_free(context);
  const haptic::ErrorPtr owned(error);
  const int count = rest ? static_cast<int>(g_strv_length(rest)) : 0;
  if (count == 1)
    read.output = rest[0];
  g_strfreev(rest);
  const auto take = [](gchar *text) {
    const haptic::GCharPtr taken(text);
    return std::string(text ? text : "");
  };
  read.truth = take(truth);
  read.places = take(places);
  read.points = take(points);
  const std::string of = take(truth_of);
  if (of == "pointed")
    read.truth_of = film::TruthOf::pointed;
  if (error)
    throw FilmError(std::string(error->message) + "; see --help");
  if (count != 1)
    throw FilmError("give one output file; see --help");
  if (!of.empty() && of != "square" && of != "pointed")
    throw FilmError("--truth-of is square or pointed");
  return read;
}

void check(const Options &options) {
  const auto ends = [&](const char *ending) { return options.output.ends_with(ending); };
  if (!ends(".ts") && !ends(".mkv") && !ends(".png"))
    throw FilmError("the name of the output must end in .ts, .mkv or .png, not '" + options.output +
                    "'");
  const auto is_size = [](int px) { return px >= 64 && px <= 4096 && px % 2 == 0; };
  if (!is_size(options.width) || !is_size(options.height))
    throw FilmError("width and height are even numbers from 64 to 4096");
  if (options.rate < 1 || options.rate > 240)
    throw FilmError("the rate is 1 to 240 frames a second");
  if (options.quality < 0 || options.quality > 51)
    throw FilmError("the quality is 0 (without loss) to 51 (the coarsest)");
  if (!(options.duration > 0 && options.duration <= 3600) ||
      !(options.at >= 0 && options.at <= 3600))
    throw FilmError("times are in s, up to 3600");
}

void draw_still(const Options &options) {
  const film::Scene scene(options.width, options.height, static_cast<std::uint64_t>(options.seed));
  film::Canvas canvas(options.width, options.height);
  scene.draw(canvas, options.at, 1.0 / options.rate);
  if (!canvas.write_png(options.output))
    throw FilmError("'" + options.output + "' cannot be written; give another name");
}

// Threads draw frames at the same time and write them one after the other.
class Studio {
public:
  explicit Studio(const Options &options)
      : options_(options), frames_(std::max(1L, std::lround(options.duration * options.rate))),
        scene_(options.width, options.height, static_cast<std::uint64_t>(options.seed)),
        file_(options.output, options.width, options.height, options.rate, options.quality) {
    if (!options.truth.empty())
      truth_.emplace(options.places, options.truth_of, options.width, options.height, options.rate);
    if (!options.points.empty())
      points_.emplace(scene_, options.width, options.height,
                      static_cast<std::uint64_t>(options.seed));
  }

  void run() {
    // One more than processors: one waits for its turn.
    const long count =
        std::clamp(static_cast<long>(std::thread::hardware_concurrency()), 1L, 15L) + 1;
    {
      std::vector<std::jthread> threads;
      threads.reserve(static_cast<std::size_t>(count));
      for (long i = 0; i < count; ++i)
        threads.emplace_back([this, i, count] { draw_some(i, count); });
    }
    if (error_)
      std::rethrow_exception(error_);
    if (truth_)
      truth_->write(options_.truth);
    if (points_)
      points_->write(options_.points);
    file_.finish();
  }

private:
  void draw_some(long first, long step) noexcept {
    try {
      film::Canvas canvas(options_.width, options_.height);
      if (points_)
        canvas.follow(points_->points());
      std::vector<std::uint8_t> frame(static_cast<std::size_t>(options_.width) * options_.height *
                                      3 / 2);
      haptic::MotionField field;
      const haptic::FieldShape shape =
          haptic::field_shape(options_.width, options_.height, 1, haptic::kFieldColumns);
      field.columns = static_cast<std::uint16_t>(shape.columns);
      field.rows = static_cast<std::uint16_t>(shape.rows);
      for (long i = first; i < frames_; i += step) {
        const double interval = 1.0 / options_.rate;
        scene_.draw(canvas, static_cast<double>(i) * interval, interval);
        canvas.write_i420(frame);
        canvas.field_of(static_cast<std::uint64_t>(std::llround(1e9 * interval)), field);
        field.flags = 0;
        const std::vector<film::Point> motions =
            truth_ ? truth_->measure(canvas) : std::vector<film::Point>();
        const std::vector<film::MaterialPoints::Seen> seen =
            points_ ? points_->measure(canvas) : std::vector<film::MaterialPoints::Seen>();
        std::unique_lock lock(mutex_);
        turn_.wait(lock, [&] { return next_ == i || error_; });
        if (error_)
          return;
        file_.write(frame, field);
        if (truth_)
          truth_->add(motions);
        if (points_)
          points_->add(seen);
        ++next_;
        turn_.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
      turn_.notify_all();
    }
  }

  const Options options_;
  const long frames_;
  const film::Scene scene_;
  std::mutex mutex_;
  std::condition_variable turn_;
  film::FilmFile file_;                        // mutex_
  std::optional<film::Truth> truth_;           // add(): mutex_
  std::optional<film::MaterialPoints> points_; // add(): mutex_
  long next_ = 0;                              // mutex_
  std::exception_ptr error_;                   // mutex_
};

} // namespace

int main(int argc, char **argv) {
  try {
    gst_init(nullptr, nullptr);
    const Options options = read_options(argc, argv);
    check(options);
    if (options.output.ends_with(".png"))
      draw_still(options);
    else
      Studio(options).run();
    return EXIT_SUCCESS;
  } catch (const std::exception &wrong) {
    std::fprintf(stderr, "wind-film: %s\n", wrong.what());
    return EXIT_FAILURE;
  }
}
