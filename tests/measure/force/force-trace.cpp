// SPDX-License-Identifier: LGPL-2.1-or-later
// The force over time that hapticsink makes of a clip, beside the one of a sink that holds each
// velocity until the next: reads the messages `haptic-motion` of velocityavg (gst-launch-1.0 -m)
// from the standard input, writes CSV to the standard output and how much each of them buzzes to
// the standard error. Not in real time: the clock of the loop is driven by hand.
#include "leaf-motion.hpp"
#include "spectrum.hpp"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

namespace {

constexpr double kLookAhead = 1.5; // intervals, as hapticsink asks for

struct Seen {
  double pts = 0; // s
  double vx = 0;  // px/s
};

std::optional<double> field(const std::string &message, const std::string &name) {
  const auto at = message.find(", " + name + "=(");
  const auto value = message.find(')', at);
  if (at == std::string::npos || value == std::string::npos)
    return std::nullopt;
  return std::strtod(message.c_str() + value + 1, nullptr);
}

double equation5(double vx) {
  const haptic::LawSettings settings;
  return haptic::arctan_gain(vx, settings.alpha, settings.max_force) * vx;
}

void report(const char *name, std::span<const double> forces) {
  double step = 0;
  for (std::size_t i = 1; i < forces.size(); ++i)
    step = std::max(step, std::abs(forces[i] - forces[i - 1]));
  std::fprintf(stderr, "%-9s energy above 20 Hz %6.1f dB, largest step in 1 ms %.3f N\n", name,
               test::energy_above_db(forces, 1000, 20), step);
}

} // namespace

int main() {
  std::vector<test::Shown> frames;
  std::vector<Seen> seen;
  for (std::string line; std::getline(std::cin, line);) {
    if (line.find("haptic-motion") == std::string::npos)
      continue;
    const auto pts = line.find("pts=(guint64)");
    const auto interval = field(line, "interval");
    const auto vx = field(line, "vx");
    const auto confidence = field(line, "confidence");
    if (pts == std::string::npos || !interval || !vx || !confidence || *confidence <= 0)
      continue;
    const double due = 1e-9 * std::strtod(line.c_str() + pts + 13, nullptr);
    seen.push_back({due, *vx});
    const auto ns = [](double s) { return std::llround(s * 1e9); };
    frames.push_back({test::seen(*vx, 1e-9 * *interval), ns(due - kLookAhead * 1e-9 * *interval),
                      ns(due - 0.5e-9 * *interval)});
  }
  if (seen.size() < 2) {
    std::fputs("force-trace: there is no motion on the standard input; pipe the output of "
               "gst-launch-1.0 -m ... ! velocityavg post-messages=true ! fakesink into it\n",
               stderr);
    return EXIT_FAILURE;
  }
  const double end = seen.back().pts;
  const auto linear = test::feel(frames, end);
  const auto smoothed = test::feel(frames, end, {.smooth_hz = 12});
  std::vector<double> hold;
  for (std::size_t i = 0, next = 0; i < linear.size(); ++i) {
    while (next + 1 < seen.size() && seen[next + 1].pts <= static_cast<double>(i) * 1e-3)
      ++next;
    hold.push_back(equation5(seen[next].vx));
  }
  std::puts("time,hold,linear,smoothed");
  for (std::size_t i = 0; i < linear.size(); ++i)
    std::printf("%.3f,%.5f,%.5f,%.5f\n", static_cast<double>(i) * 1e-3, hold[i], linear[i],
                smoothed[i]);
  const auto begun = std::min<std::size_t>(500, linear.size() / 2); // ms; the fade-in is over
  report("hold", std::span(hold).subspan(begun));
  report("linear", std::span(linear).subspan(begun));
  report("smoothed", std::span(smoothed).subspan(begun));
}
