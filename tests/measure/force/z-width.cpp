// SPDX-License-Identifier: LGPL-2.1-or-later
// The Z-width of the device (Colgate and Brown 1994): how stiff a wall may be, for each damping of
// the wall, until a hand that lies on it no longer comes to rest. The wall is a spring and a damper
// on what the device measures, with nothing between; in virtual time.
#include "loop-in-hand.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using spidar::Vector3;
using test::Hand;
using test::Pace;

struct Wall {
  double stiffness = 0; // N/m
  double damping = 0;   // N·s/m
};

struct Held {
  std::string name;
  Hand hand{0.1, 0.5, 0}; // a grip that only its strings damp
  Pace pace;
  std::string geometry = spidar::kDefaultGeometry;
};

constexpr double kSoftest = 10;    // N/m; 0.3 N are 30 mm deep
constexpr double kStiffest = 20e3; // N/m

// Whether a hand that lies on the wall with 0.3 N comes to rest after a tap. The wall begins at
// `place` and pushes along `out`.
bool is_calm(const Held &held, const Wall &wall, const Vector3 &place, const Vector3 &out) {
  constexpr double kLoad = 0.3;    // N
  constexpr double kTap = 0.5;     // N, for 20 ms
  constexpr double kTapped = 1;    // s
  constexpr double kLooked = 3.5;  // s
  constexpr double kRun = 4.5;     // s
  constexpr double kUnrest = 0.05; // N peak to peak, as in the table of the closed loop
  const spidar::Geometry &geometry = test::builtin_geometry(held.geometry);
  auto on_strings = std::make_unique<test::HandOnStrings>(geometry, held.hand, place);
  test::HandOnStrings &hand = *on_strings;
  spidar::Device device(std::move(on_strings), geometry, 1 / held.pace.rate);
  test::Ticks ticks(held.pace);
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  while (ticks.time() < kRun) {
    ticks.next();
    const bool tapped = ticks.time() > kTapped && ticks.time() < kTapped + 0.02;
    hand.push = -(kLoad + (tapped ? kTap : 0)) * out;
    device.exchange(ticks.now());
    const double depth = (place - device.state().pose.position).dot(out);
    const double speed = device.state().velocity.dot(out);
    const double force =
        depth > 0 ? std::max(wall.stiffness * depth - wall.damping * speed, 0.0) : 0;
    device.command({.force = force * out});
    if (ticks.time() < kLooked)
      continue;
    least = std::min(least, force);
    most = std::max(most, force);
  }
  return most - least <= kUnrest;
}

// In each direction. Where the counts change decides near the border, so at two places.
bool is_calm(const Held &held, const Wall &wall) {
  for (const Vector3 &place : {Vector3(0, 0, 0), Vector3(0.0071, -0.0052, 0.0033)}) // m
    for (const Vector3 out : {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()})
      if (!is_calm(held, wall, place, out))
        return false;
  return true;
}

// The stiffest wall that is calm, as were the softer ones on the way to it, within 3 %. None: not
// even the softest.
std::optional<double> stiffest(const Held &held, double damping) {
  constexpr double kCoarse = 1.3;
  constexpr double kFine = 1.03;
  const auto calm = [&](double stiffness) { return is_calm(held, {stiffness, damping}); };
  double good = kSoftest;
  if (!calm(good))
    return std::nullopt;
  double bad = good * kCoarse;
  for (; bad < kStiffest && calm(bad); bad *= kCoarse)
    good = bad;
  while (bad / good > kFine) {
    const double middle = std::sqrt(good * bad);
    (calm(middle) ? good : bad) = middle;
  }
  return good;
}

// Passive with every hand whose grip has the damping b: b > K T / 2 + |B| (Colgate and Schenkel
// 1997), of a wall that acts without a delay.
void print_theory(const Held &held) {
  constexpr int kPoints = 50;
  const double period = std::max(1 / held.pace.rate, held.pace.every * 1e-3); // s
  std::printf("\n\n\"\"\n");
  for (int i = 0; i < kPoints; ++i) {
    const double damping = held.hand.damping * i / kPoints;
    std::printf("%.3f %.1f\n", damping, 2 * (held.hand.damping - damping) / period);
  }
}

const std::map<std::string, std::vector<Held>> kPanels = {
    {"geometry",
     {{.name = "spidar-g6x3r"},
      {.name = "spidar-g6x3l", .geometry = "spidar-g6x3l"},
      {.name = "spidar-g6x4", .geometry = "spidar-g6x4"},
      {.name = "spidar-g6x5r", .geometry = "spidar-g6x5r"}}},
    {"hand",
     {{.name = "0.1 kg, 0.5 N·s/m"},
      {.name = "0.1 kg, 3 N·s/m", .hand = {0.1, 3, 0}},
      {.name = "0.4 kg, 3 N·s/m", .hand = {0.4, 3, 0}},
      {.name = "1 kg, 8 N·s/m", .hand = {1, 8, 0}}}},
    {"rate",
     {{.name = "500 Hz", .pace = {.rate = 500}},
      {.name = "1000 Hz"},
      {.name = "2000 Hz", .pace = {.rate = 2000}},
      {.name = "4000 Hz", .pace = {.rate = 4000}}}},
    {"lateness",
     {{.name = "on time"},
      {.name = "1 in 10 up to 5 ms late", .pace = {.late = 5}},
      {.name = "1 in 10 up to 10 ms late", .pace = {.late = 10}},
      {.name = "every 8 ms", .pace = {.every = 8}}}},
};

} // namespace

// Blocks for gnuplot, of damping and stiffness: for each curve what was measured and the theory.
int main(int argc, char **argv) {
  const auto panel = kPanels.find(argc == 2 ? argv[1] : "");
  if (panel == kPanels.end()) {
    std::fputs("Usage: z-width geometry|hand|rate|lateness\n", stderr);
    return EXIT_FAILURE;
  }
  bool first = true;
  for (const Held &held : panel->second) {
    std::printf("%s\"%s\"\n", first ? "" : "\n\n", held.name.c_str());
    first = false;
    for (const double damping : {0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0})
      if (const auto stiffness = stiffest(held, damping))
        std::printf("%.3f %.1f\n", damping, *stiffness);
    print_theory(held);
    std::fflush(stdout);
  }
}
