// SPDX-License-Identifier: LGPL-2.1-or-later
// The table of the closed loop: what the force may do at most, whatever the hand does. Each row is
// a grid of points; a point is one run of the loop with a hand on its strings, in virtual time.
#pragma once

#include "loop-in-hand.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace test {

/// Places on the way of a hand: 0 above the surface, 1 half way in, 2 at the bottom, 3 half way
/// out, 4 out.
struct Stages {
  int from = 0;
  int to = 0;
};

/// What a run is made of. A row sets what its axes name; the rest stays as it is here. SI units.
struct LoopPoint {
  std::string geometry = spidar::kDefaultGeometry;
  Hand hand;
  Pace pace;

  // Properties of hapticsink.
  std::string law = "arctan";
  haptic::TouchMode touch = haptic::TouchMode::off;
  haptic::HoldLaw hold_law = haptic::HoldLaw::motion; ///< of a thing that is held
  double alpha = haptic::kDefaultAlpha;               ///< s/px
  double max_force = 1;                               ///< N
  double slew_rate = 20;                              ///< N/s
  double damping = 1;                                 ///< N·s/m

  double tap = 0;      ///< N·s
  double load = 0;     ///< share of max_force with which the hand lies on the surface
  double friction = 0; ///< of the surface
  double depth = 0;    ///< m
  double in = 0.1;     ///< m/s, of the hand on its way in
  double out = 0.1;    ///< m/s
  /// m/s², with which a hand gets that fast
  double acceleration = std::numeric_limits<double>::infinity();
  double sideways = 0;      ///< m, that the hand goes at the bottom
  double late_at = 0;       ///< share of the way out after which the late tick comes
  double pause = 0;         ///< s, at each stage of the way
  Stages stages;            ///< of the way, at which the event begins and ends
  double height = 0;        ///< m, of the place above the centre
  double speed = 0.1;       ///< m/s, with which the hand is led round
  double sway = 1;          ///< Hz, of the held thing
  double swing = 0;         ///< m, to each side
  bool film_leads = true;   ///< it always pushes the hand on; else always in one direction
  std::string event = "no"; ///< what happens to the loop
};

struct Outcome {
  double figure = 0;
  double most = 0;  ///< wanted
  std::string idle; ///< why the figure proves nothing; empty if it does
  /// Of a way: what the force may do on a hand that jumps to its speed, until the loop knows of it
  double of_jump = 0;

  bool kept() const { return idle.empty() && figure <= most; }
  bool lost_to_jump() const { return idle.empty() && figure > most && figure <= of_jump; }
};

/// The values that one member of the point takes.
struct Axis {
  std::vector<std::string> names; ///< "alpha=0.04"
  std::function<void(LoopPoint &, std::size_t)> set;
};

class LoopRow {
public:
  std::string name;
  std::string figure; ///< what is measured, with its unit
  std::vector<Axis> axes;
  Outcome (*run)(const LoopPoint &) = nullptr;

  /// The number of points.
  std::size_t size() const;
  LoopPoint at(std::size_t index) const;
  /// One word for each axis. Selects this point, as `only` of select().
  std::string words(std::size_t index) const;
  /// The points that have each of the words of `only`; of these `count` by chance, the same for the
  /// same seed. 0: all.
  std::vector<std::size_t> select(const std::string &only, std::size_t count = 0,
                                  unsigned seed = 1) const;
  /// Few points in which any values of three axes occur together.
  std::vector<std::size_t> threes() const;
};

/// The same rows on each device: on the strings of the built-in geometries, and on the arm.
enum class Bench { strings, arm };
std::span<const LoopRow> closed_loop_table(Bench bench = Bench::strings);
const LoopRow &closed_loop_row(std::string_view name, Bench bench = Bench::strings);

} // namespace test
