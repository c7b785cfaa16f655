// SPDX-License-Identifier: LGPL-2.1-or-later
#include "plot/compare-plot.hpp"

#include "plot/gnuplot.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace haptic {
namespace {

constexpr std::int64_t kMostPoints = 2400; // of a curve, two for each pixel

// Parts of the time that was compared.
class Bins {
public:
  explicit Bins(const Comparison &result)
      : first_(result.first), end_(result.end),
        width_(std::max<std::int64_t>((end_ - first_ + kMostPoints - 1) / kMostPoints, 1)) {}

  std::size_t count() const {
    return static_cast<std::size_t>((end_ - first_ + width_ - 1) / width_);
  }
  std::int64_t first_step(std::size_t bin) const {
    return first_ + static_cast<std::int64_t>(bin) * width_;
  }
  std::int64_t end_step(std::size_t bin) const { return std::min(first_step(bin) + width_, end_); }
  double middle(std::size_t bin) const { // s
    return static_cast<double>(first_step(bin) + end_step(bin) - 1) / 2 * kForceStep;
  }

private:
  std::int64_t first_, end_, width_; // steps
};

// Returns for each bin the share of places and time at which the forces can be told apart.
std::vector<double> shares_over_time(const Comparison &result, const SignalsAt &signals_at,
                                     const Bins &bins) {
  std::vector<double> shares(bins.count());
  for (std::size_t place = 0; place < result.places.size(); ++place) {
    const SignalPair pair = signals_at(place);
    for (std::size_t bin = 0; bin < shares.size(); ++bin) {
      const auto length = static_cast<double>(bins.end_step(bin) - bins.first_step(bin));
      for (std::int64_t step = bins.first_step(bin); step < bins.end_step(bin); ++step)
        shares[bin] += result.is_distinguishable(pair, step) /
                       (length * static_cast<double>(result.places.size()));
    }
  }
  return shares;
}

// Draws one axis of both forces. Of many forces in a pixel their mean is drawn.
void draw_axis(Gnuplot &out, const char *name, const Comparison &result, const SignalPair &pair,
               const Bins &bins, float Force::*axis) {
  out.line("set ylabel '%s (N)' offset 1", name);
  out.line("plot '-' using 1:2 with lines linetype 2 linewidth 2.5 title 'B', "
           "'-' using 1:2 with lines linetype 13 linewidth 1.5 title 'A'");
  const auto send = [&](const ForceSignal &signal, std::int64_t shift) {
    for (std::size_t bin = 0; bin < bins.count(); ++bin) {
      double sum = 0;
      for (std::int64_t step = bins.first_step(bin); step < bins.end_step(bin); ++step)
        sum += signal.at(step + shift).*axis;
      out.line("%.6f %.6g", bins.middle(bin),
               sum / static_cast<double>(bins.end_step(bin) - bins.first_step(bin)));
    }
    out.line("e");
  };
  send(pair.second, std::llround(result.shift / kForceStep));
  send(pair.first, 0);
  out.line("unset key; unset label"); // stand above the first axis
}

} // namespace

void plot_comparison(const Comparison &result, const SignalsAt &signals_at, std::size_t place,
                     const std::string &caption, bool is_touch, const std::string &output) {
  if (std::filesystem::path(output).extension() != ".png")
    throw_error(messages::kPictureIsUnknown, output.c_str());
  const Bins bins(result);
  const SignalPair pair = signals_at(place);
  const bool places = result.places.size() > 1;
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
    draw_axis(out, "outwards", result, pair, bins, &Force::z);
  draw_axis(out, "to the right", result, pair, bins, &Force::x);
  draw_axis(out, "upwards", result, pair, bins, &Force::y);
  out.line("set xlabel 'time (s)' offset 0,0.5; set yrange [0:100]");
  out.line("set ylabel '%s' offset 1",
           places ? "told apart (% of places)" : "told apart (% of time)");
  out.line("plot '-' using 1:2 with filledcurves x1 linetype 3");
  const auto shares = shares_over_time(result, signals_at, bins);
  for (std::size_t bin = 0; bin < shares.size(); ++bin)
    out.line("%.6f %.6g", bins.middle(bin), 100 * shares[bin]);
  out.line("e");
  out.finish();
}

} // namespace haptic
