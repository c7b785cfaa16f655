// SPDX-License-Identifier: LGPL-2.1-or-later
#include "plot/track-plot.hpp"

#include "felt/touch-signal.hpp"
#include "film/frame-reader.hpp"
#include "plot/gnuplot.hpp"
#include "samples/motion-force.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

namespace haptic {
namespace {

constexpr int kStillWidth = 480;   // px
constexpr int kPreviewWidth = 320; // px
constexpr int kStripHeight = 120;  // px
constexpr std::size_t kStills = 6;
constexpr std::size_t kStillsInARow = 3;
constexpr std::uint64_t kPreview = 4'000'000'000;   // ns
constexpr std::uint64_t kPreviewStep = 100'000'000; // ns
constexpr double kLongestArrow = 1.4;               // cells, at the speed of nearly all cells
constexpr double kNearlyAll = 0.98;
constexpr float kLeastConfidence = 0.25F; // of an arrow
constexpr double kLeastLength = 0.2;      // cells

// ---- points -------------------------------------------------------------------------------------

// Draws two panels, each of a label, a range of y, and curves.
void plot_panels(Gnuplot &out, const std::array<const char *, 3> &upper,
                 const std::array<const char *, 3> &lower) {
  out.set_terminal("pngcairo font 'DejaVu Sans,15'", 1200, 800);
  out.line("set multiplot layout 2,1 margins 0.1, 0.98, 0.11, 0.93 spacing 0, 0.13");
  double key = 0.98; // share of the height
  for (const auto &[label, range, curves] : {upper, lower}) {
    out.line("set key at screen 0.98, %.3f", std::exchange(key, 0.505));
    out.line("set ylabel '%s'; set yrange [%s]", label, range);
    out.line("plot %s", curves);
    out.line("set xlabel 'time (s)'");
  }
}

void plot_points(const TrackFile &track, Gnuplot &out) {
  out.line("set xzeroaxis linetype -1 linecolor rgb '#444444'");
  out.line("set xrange [*:*] noextend");
  out.line("$track << end");
  for (const auto &[motion, time, duration] : track.samples) {
    const auto force = force_of_motion(motion);
    if (motion.confidence > 0)
      out.line("%.6f %.6g %.6g %.6g %.6g", seconds(time), motion.velocity_x, -motion.velocity_y,
               motion.confidence, std::hypot(force.x, force.y));
    else
      out.line(""); // a hole in the line
  }
  out.line("end");
  plot_panels(out,
              {"velocity (px/s)", "*:*",
               "$track using 1:2 with lines linetype 11 title 'to the right', "
               "$track using 1:3 with lines linetype 12 title 'upwards'"},
              {"share of the full force", "0:1.05",
               "$track using 1:4 with lines linetype 3 title 'confidence', "
               "$track using 1:5 with lines linetype 13 title 'force'"});
}

// ---- reliefs ------------------------------------------------------------------------------------

void plot_reliefs(const std::string &path, const TrackFile &track, const PlotOptions &options,
                  Gnuplot &out) {
  std::vector<double> times; // s
  bool exists = false;
  out.line("$track << end");
  for_each_relief(track.reliefs, [&](const ReliefField &relief, std::uint64_t time) {
    const PointerPosition place = options.hand.empty()
                                      ? PointerPosition{.x = options.x, .y = options.y}
                                      : place_at(options.hand, seconds(time));
    const FeltSurface surface = felt_surface(relief, place.x, place.y, time);
    const double hole = surface.exists ? 0 : std::numeric_limits<double>::quiet_NaN();
    out.line("%.6f %.6g %.6g %.6g", surface.time, 1000 * surface.height + hole,
             surface.stiffness + hole, 1000 * kWorkspaceHalf * place.z);
    times.push_back(surface.time);
    exists = exists || surface.exists;
  });
  out.line("end");
  if (times.empty())
    throw_error(messages::kNoFieldIsDecoded);
  if (!exists)
    throw_error(messages::kNoSurfaceHere, path.c_str());
  out.line("set xrange [%.6f:%.6f] noextend", times.front(),
           std::max(times.back(), times.front() + 0.1));
  const std::string curves =
      options.hand.empty()
          ? format_text("$track using 1:2 with lines linetype 2 title 'surface at (%.2f, %.2f)'",
                        options.x, options.y)
          : "$track using 1:2 with lines linetype 2 title 'surface under the hand', "
            "$track using 1:4 with lines linetype 16 title 'hand'";
  plot_panels(
      out, {"height (mm)", "*:*", curves.c_str()},
      {"stiffness (N/m)", "0:*", "$track using 1:3 with lines linetype 3 title 'stiffness'"});
}

// ---- fields -------------------------------------------------------------------------------------

struct Overview {
  std::vector<std::uint64_t> times;
  std::vector<double> energies;
  double usual_speed = 0; ///< px/s, which nearly no cell exceeds
  int width = 0;          ///< px, of a frame as it is drawn
  int height = 0;
};

Overview overview_of(const TrackFile &track, int width) {
  Overview all{.width = width};
  std::vector<float> speeds;
  for_each_field(track.fields, [&](const MotionField &field, std::uint64_t time) {
    if (all.times.empty())
      all.height =
          std::clamp(static_cast<int>(std::lround(
                         static_cast<double>(width) * field.frame_height * field.pixel_aspect_d /
                         (static_cast<double>(field.frame_width) * field.pixel_aspect_n))),
                     16, 4 * width);
    all.times.push_back(time);
    all.energies.push_back(field_energy(field));
    // The fastest cell of each frame, so that a few fast leaves count among cells at rest.
    float fastest = 0;
    for (const FieldCell &cell : field.cells)
      if (cell.confidence >= kLeastConfidence)
        fastest = std::max(fastest, std::hypot(cell.velocity_x, cell.velocity_y));
    speeds.push_back(fastest);
  });
  if (all.times.empty())
    throw_error(messages::kNoFieldIsDecoded);
  const auto nearly_last =
      speeds.begin() +
      static_cast<std::ptrdiff_t>(kNearlyAll * static_cast<double>(speeds.size() - 1));
  std::nth_element(speeds.begin(), nearly_last, speeds.end());
  all.usual_speed = std::max(1.0, static_cast<double>(*nearly_last));
  return all;
}

// Returns for each of these times the last field before it.
std::vector<MotionField> fields_at(const TrackFile &track,
                                   const std::vector<std::uint64_t> &times) {
  std::vector<MotionField> shown(times.size());
  std::size_t next = 0;
  MotionField last;
  for_each_field(track.fields, [&](const MotionField &field, std::uint64_t time) {
    while (next < times.size() && times[next] < time)
      shown[next++] = last;
    last = field;
  });
  while (next < times.size())
    shown[next++] = last;
  return shown;
}

void draw_field(Gnuplot &out, const Frame &frame, const MotionField &field, const Overview &all) {
  out.line("unset xtics; unset ytics; unset xlabel; unset ylabel; unset key; unset arrow");
  out.line("set border; set xrange [0:%d]; set yrange [0:%d]", all.width, all.height);
  const char *arrows = "'-' using 1:2:3:4 with vectors head filled lw 1.5 lc rgb '#E69F00'";
  if (frame.empty()) {
    out.line("set object 1 rectangle from graph 0,0 to graph 1,1 fc rgb '#606060' behind");
    out.line("plot %s", arrows);
  } else {
    out.line("plot '-' binary array=(%d,%d) flip=y format='%%uchar' using 1:2:3 with rgbimage, %s",
             all.width, all.height, arrows);
    out.bytes(frame);
  }
  const double cell_width = static_cast<double>(all.width) / std::max<int>(field.columns, 1);
  const double cell_height = static_cast<double>(all.height) / std::max<int>(field.rows, 1);
  const double scale = kLongestArrow * cell_width / all.usual_speed;
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    const FieldCell &cell = field.cells[i];
    const double right = scale * cell.velocity_x;
    const double down = scale * cell.velocity_y;
    if (cell.confidence < kLeastConfidence || std::hypot(right, down) < kLeastLength * cell_width)
      continue;
    const std::size_t row = i / field.columns;
    const std::size_t column = i % field.columns;
    out.line("%.1f %.1f %.2f %.2f", (static_cast<double>(column) + 0.5) * cell_width,
             all.height - (static_cast<double>(row) + 0.5) * cell_height, right, -down);
  }
  out.line("1e9 1e9 0 0"); // outside: gnuplot wants one
  out.line("e");
}

void draw_energy(Gnuplot &out, const Overview &all, const std::vector<std::uint64_t> &marks) {
  out.line("unset object; unset key; unset arrow");
  out.line("set xtics; unset ytics; set xlabel 'time (s)' offset 0,0.7");
  out.line("set autoscale; set xrange [%.3f:%.3f]; set yrange [0:*]", seconds(all.times.front()),
           std::max(seconds(all.times.back()), seconds(all.times.front()) + 0.1));
  for (const auto mark : marks)
    out.line("set arrow from %.3f, graph 0 to %.3f, graph 1 nohead linetype 2", seconds(mark),
             seconds(mark));
  out.line("plot '-' using 1:2 with filledcurves x1 linetype 11");
  for (std::size_t i = 0; i < all.times.size(); ++i)
    out.line("%.3f %.6g", seconds(all.times[i]), std::sqrt(all.energies[i]));
  out.line("e");
}

// Sets the place of a panel, in shares of the picture from its lower left corner.
void place(Gnuplot &out, double left, double bottom, double width, double height) {
  out.line("set lmargin at screen %.4f; set rmargin at screen %.4f; "
           "set bmargin at screen %.4f; set tmargin at screen %.4f",
           left, left + width, bottom, bottom + height);
}

// Returns the time with the most motion in each part of the track.
std::vector<std::uint64_t> liveliest_times(const Overview &all) {
  std::vector<std::uint64_t> moments;
  const std::size_t count = std::min(kStills, all.times.size());
  for (std::size_t part = 0; part < count; ++part) {
    const auto begin = static_cast<std::ptrdiff_t>(part * all.times.size() / count);
    const auto end = static_cast<std::ptrdiff_t>((part + 1) * all.times.size() / count);
    const auto most = std::max_element(all.energies.begin() + begin, all.energies.begin() + end);
    moments.push_back(all.times[static_cast<std::size_t>(most - all.energies.begin())]);
  }
  return moments;
}

// Returns times around the one with the most motion, within the track.
std::vector<std::uint64_t> preview_times(const Overview &all) {
  const auto most = std::ranges::max_element(all.energies) - all.energies.begin();
  const std::uint64_t end = std::max(
      all.times.front() + kPreview,
      std::min(all.times[static_cast<std::size_t>(most)] + kPreview / 2, all.times.back()));
  std::vector<std::uint64_t> times;
  for (std::uint64_t time = end - kPreview; time < end && time <= all.times.back();
       time += kPreviewStep)
    times.push_back(time);
  return times;
}

// Draws some fields beside each other, or one after the other if it moves.
void plot_fields(const std::string &path, const TrackFile &track, bool moves, Gnuplot &out) {
  const Overview all = overview_of(track, moves ? kPreviewWidth : kStillWidth);
  const auto times = moves ? preview_times(all) : liveliest_times(all);
  const auto frames = read_frames(path, times, all.width, all.height);
  const auto fields = fields_at(track, times);
  const std::size_t panels = moves ? 1 : times.size(); // of a picture
  const std::size_t columns = std::min(kStillsInARow, panels);
  const std::size_t rows = (panels + columns - 1) / columns;
  const int height = all.height * static_cast<int>(rows) + kStripHeight;
  out.set_terminal(moves ? "gif animate delay 10 loop 0 optimize" : "pngcairo",
                   all.width * static_cast<int>(columns), height);
  const double wide = 1.0 / static_cast<double>(columns);
  const double high = static_cast<double>(all.height) / height;
  const double side = moves ? 0.03 : 0.02; // of the strip
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::size_t panel = i % panels;
    const std::size_t row = panel / columns;
    if (panel == 0)
      out.line("set multiplot");
    place(out, wide * static_cast<double>(panel % columns), 1 - high * static_cast<double>(row + 1),
          wide, high);
    draw_field(out, frames[i], fields[i], all);
    if (panel + 1 < panels)
      continue;
    place(out, side, 50.0 / height, 1 - 2 * side, (kStripHeight - 55.0) / height);
    draw_energy(out, all, moves ? std::vector{times[i]} : times);
    out.line("unset multiplot");
  }
}

} // namespace

void plot_track(const std::string &path, const TrackFile &track, const PlotOptions &options,
                const std::string &output) {
  const std::string ending = std::filesystem::path(output).extension().string();
  const bool moves = ending == ".gif";
  if (moves && track.fields.empty())
    throw_error(messages::kPointsDoNotMove, output.c_str());
  if (!moves && ending != ".png")
    throw_error(messages::kPictureIsUnknown, output.c_str());
  Gnuplot out(output);
  if (!track.reliefs.empty())
    plot_reliefs(path, track, options, out);
  else if (track.fields.empty())
    plot_points(track, out);
  else
    plot_fields(path, track, moves, out);
  out.finish();
}

} // namespace haptic
