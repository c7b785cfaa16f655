// SPDX-License-Identifier: LGPL-2.1-or-later
#include "plot/compare-plot.hpp"

#include "plot/gnuplot.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace haptic {
namespace {

constexpr std::int64_t kMostPoints = 2400; // of a curve, two for each pixel

// Sends a curve of `value(step)` over the time that was compared. Of many values in a pixel it has
// the mean.
template <typename Value>
void send(Gnuplot &out, const Comparison &result, const Value &value) {
  const std::int64_t width =
      std::max<std::int64_t>((result.end - result.first + kMostPoints - 1) / kMostPoints, 1);
  for (std::int64_t begin = result.first; begin < result.end; begin += width) {
    const std::int64_t end = std::min(begin + width, result.end);
    double sum = 0;
    for (std::int64_t step = begin; step < end; ++step)
      sum += value(step);
    out.line("%.6f %.6g", static_cast<double>(begin + end - 1) / 2 * kForceStep,
             sum / static_cast<double>(end - begin));
  }
  out.line("e");
}

// Draws one axis of both forces.
void draw_axis(Gnuplot &out, const char *name, const Comparison &result, const SignalPair &pair,
               float Force::*axis) {
  const std::int64_t shift = std::llround(result.shift / kForceStep);
  out.line("set ylabel '%s (N)' offset 1", name);
  out.line("plot '-' using 1:2 with lines linetype 2 linewidth 2.5 title 'B', "
           "'-' using 1:2 with lines linetype 13 linewidth 1.5 title 'A'");
  send(out, result, [&](std::int64_t step) { return pair.second.at(step + shift).*axis; });
  send(out, result, [&](std::int64_t step) { return pair.first.at(step).*axis; });
  out.line("unset key; unset label"); // stand above the first axis
}

} // namespace

void plot_comparison(const Comparison &result, const SignalsAt &signals_at, std::size_t place,
                     const std::string &caption, bool is_touch, const std::string &output) {
  if (std::filesystem::path(output).extension() != ".png")
    throw_error(messages::kPictureIsUnknown, output.c_str());
  const SignalPair pair = signals_at(place);
  Gnuplot out(output);
  out.set_terminal("pngcairo font 'DejaVu Sans,15'", 1200, is_touch ? 1180 : 900);
  out.line("set multiplot layout %d,1 margins 0.1, 0.98, 0.08, 0.94 spacing 0, 0.07",
           is_touch ? 4 : 3);
  out.line("set xzeroaxis linetype -1 linecolor rgb '#444444'");
  out.line("set xrange [%.3f:%.3f] noextend", static_cast<double>(result.first) * kForceStep,
           static_cast<double>(result.end) * kForceStep);
  out.line("set label 1 '%s' at screen 0.1, 0.97", caption.c_str());
  out.line("set key at screen 0.98, 0.985");
  if (is_touch)
    draw_axis(out, "outwards", result, pair, &Force::z);
  draw_axis(out, "to the right", result, pair, &Force::x);
  draw_axis(out, "upwards", result, pair, &Force::y);
  out.line("set xlabel 'time (s)' offset 0,0.5; set yrange [0:100]");
  out.line("set ylabel '%s' offset 1",
           result.places.size() > 1 ? "told apart (% of places)" : "told apart (% of time)");
  out.line("plot '-' using 1:2 with filledcurves x1 linetype 3");
  std::vector<std::uint16_t> told(static_cast<std::size_t>(result.end - result.first)); // places
  for (std::size_t i = 0; i < result.places.size(); ++i) {
    const SignalPair at_place = signals_at(i);
    for (std::int64_t step = result.first; step < result.end; ++step)
      told[static_cast<std::size_t>(step - result.first)] +=
          result.is_distinguishable(at_place, step);
  }
  send(out, result, [&](std::int64_t step) {
    return 100.0 * told[static_cast<std::size_t>(step - result.first)] /
           static_cast<double>(result.places.size());
  });
  out.finish();
}

} // namespace haptic
