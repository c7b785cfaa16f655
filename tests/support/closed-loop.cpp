// SPDX-License-Identifier: LGPL-2.1-or-later
#include "closed-loop.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <deque>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace test {
namespace {

using haptic::HoldLaw;
using haptic::HoldState;
using haptic::TouchMode;
using spidar::Vector3;

// Of the simulator's grip and hand (spidar/src/model/simulator.cpp), which also turns.
const Hand kSimulated{0.4, 40, 1000};

// --- Points.

std::string text(double value) {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%g", value);
  return digits.data();
}
std::string text(const std::string &value) {
  return value;
}
std::string text(bool value) {
  return value ? "yes" : "no";
}
std::string text(TouchMode value) {
  constexpr std::array kNames = {"off", "surface", "surface+motion"};
  return kNames.at(static_cast<std::size_t>(value));
}
std::string text(HoldLaw value) {
  constexpr std::array kNames = {"motion", "carry", "both"};
  return kNames.at(static_cast<std::size_t>(value));
}
std::string text(const Hand &hand) {
  if (hand == kSimulated)
    return "simulator";
  return text(hand.mass) + "kg," + text(hand.damping) + "Ns/m," + text(hand.stiffness) + "N/m";
}
std::string text(const Pace &pace) {
  std::string words = text(pace.rate) + "Hz";
  if (pace.every > 0)
    words += ",every-" + text(pace.every) + "ms";
  if (pace.late > 0)
    words += ",late-" + text(pace.late) + "ms";
  if (pace.uneven)
    words += ",uneven";
  return words;
}

std::string text(Stages stages) {
  return std::to_string(stages.from) + "-" + std::to_string(stages.to);
}

template <typename T>
Axis axis(const std::string &name, T LoopPoint::*member, const std::vector<T> &values) {
  Axis made;
  for (const T &value : values)
    made.names.push_back(name + "=" + text(value));
  made.set = [member, values](LoopPoint &point, std::size_t i) { point.*member = values[i]; };
  return made;
}

Axis geometries() {
  return axis("geometry", &LoopPoint::geometry, spidar::builtin_geometries());
}
// At a slew rate that follows the stiffest spring.
Axis arm() {
  return {{std::string("geometry=") + kArmName}, [](LoopPoint &point, std::size_t) {
            point.geometry = kArmName;
            point.slew_rate = kArm.stiffness * haptic::ContactLaw::kFastestSurface;
          }};
}
Axis hold_laws() {
  return axis("hold-law", &LoopPoint::hold_law, std::vector{HoldLaw::carry, HoldLaw::both});
}
Axis max_forces(double strongest) {
  return axis("max-force", &LoopPoint::max_force, {1.0, strongest});
}
Axis alphas() {
  return axis("alpha", &LoopPoint::alpha, {0.01, 0.04});
}
Axis laws() {
  std::vector<std::string> names;
  for (const haptic::ForceLawInfo &law : haptic::force_laws())
    names.emplace_back(law.name);
  return axis("law", &LoopPoint::law, names);
}
Axis touches(const std::vector<TouchMode> &modes) {
  return axis("touch", &LoopPoint::touch, modes);
}
Axis hands() {
  std::vector<Hand> all{kSimulated};
  for (const double mass : {0.1, 0.4, 1.0})
    for (const double damping : {0.5, 3.0, 8.0})
      for (const double stiffness : {0.0, 20.0, 300.0})
        all.push_back({mass, damping, stiffness});
  return axis("hand", &LoopPoint::hand, all);
}
// A hand that holds itself back with 300 N/m cannot be carried.
std::vector<Hand> carried_hands() {
  std::vector<Hand> all;
  for (const double mass : {0.1, 0.4, 1.0})
    for (const double damping : {0.5, 3.0, 8.0})
      for (const double stiffness : {0.0, 20.0})
        all.push_back({mass, damping, stiffness});
  return all;
}
// Of 250 us to 8 ms, and late ones.
Axis any_paces() {
  return axis("pace", &LoopPoint::pace,
              std::vector<Pace>{{.rate = 500},
                                {.rate = 1000},
                                {.rate = 2000},
                                {.rate = 4000},
                                {.rate = 1000, .every = 2},
                                {.rate = 1000, .every = 8},
                                {.rate = 500, .late = 10},
                                {.rate = 1000, .late = 10},
                                {.rate = 4000, .late = 10}});
}
Axis few_paces() {
  return axis("pace", &LoopPoint::pace,
              std::vector<Pace>{{.rate = 500},
                                {.rate = 1000},
                                {.rate = 4000},
                                {.rate = 1000, .every = 8},
                                {.rate = 1000, .late = 10}});
}
// Of at most two periods.
Axis paces_on_time() {
  return axis("pace", &LoopPoint::pace,
              std::vector<Pace>{{.rate = 500},
                                {.rate = 1000},
                                {.rate = 2000},
                                {.rate = 4000},
                                {.rate = 500, .uneven = true},
                                {.rate = 1000, .uneven = true},
                                {.rate = 4000, .uneven = true}});
}
Axis steady_paces() {
  return axis("pace", &LoopPoint::pace,
              std::vector<Pace>{{.rate = 500}, {.rate = 1000}, {.rate = 2000}, {.rate = 4000}});
}

// --- Runs.

constexpr double kFadedIn = 0.3;  // s; the force begins within 50 ms, the slew rate adds 250 ms
constexpr double kAtWork = 0.005; // N, as commanded: a fast hand hardly presses a surface
constexpr double kLiesAt = 0.015; // m, of the surface that a hand lies on

LoopInHand::Setup setup_of(const LoopPoint &point, const Vector3 &start,
                           bool pulls_at_rest = true) {
  LoopInHand::Setup setup{.geometry = point.geometry,
                          .hand = point.hand,
                          .start = start,
                          .pace = point.pace,
                          .dead_man = point.event == "dead-man",
                          .pulls_at_rest = pulls_at_rest};
  haptic::LoopSettings &settings = setup.settings;
  while (haptic::force_laws()[settings.law].name != point.law)
    ++settings.law;
  settings.law_settings.alpha = point.alpha;
  settings.law_settings.max_force = point.max_force;
  settings.slew_rate = point.slew_rate;
  settings.damping = point.damping;
  settings.continuous_force = 0;
  settings.touch = point.touch;
  settings.hold_law = point.hold_law;
  return setup;
}

// A level one, as stiff as the loop lets it be.
haptic::ReliefCell surface_of(const LoopPoint &point, double height) {
  return {.height = static_cast<float>(height),
          .stiffness = haptic::kMostReliefStiffness,
          .friction = static_cast<float>(point.friction),
          .validity = 1};
}

// Why a figure says nothing: a force that was off is calm. Empty if it says something.
std::string why_idle(const LoopInHand &held, bool worked) {
  if (held.loop.statistics().overspeeds > 0)
    return "the grip was let go";
  if (held.loop.holds())
    return "the force is held";
  return worked ? "" : "no force";
}

// A thing at that place, which sways as the point says.
void take_thing(LoopInHand &held, const LoopPoint &point, const Vector3 &place) {
  held.ahead = 3 * held.frame / 2;
  held.thing = [&point, place](double time) {
    const double way = point.swing * std::sin(2 * std::numbers::pi * point.sway * time);
    return Vector3(place + way * Vector3(0.8, 0.6, 0));
  };
}

void await_take(LoopInHand &held) {
  while (held.loop.statistics().carry_stiffness == 0)
    held.tick();
}

// Reads the largest extent of the force along an axis, N.
class Extent {
public:
  void add(const Vector3 &force) {
    least_ = least_.cwiseMin(force);
    most_ = most_.cwiseMax(force);
  }
  double value() const { return (most_ - least_).maxCoeff(); }

private:
  Vector3 least_ = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 most_ = -least_;
};

// The largest force from now on for so long, N.
double largest_force(LoopInHand &held, double seconds) {
  double most = 0;
  for (const double end = held.time() + seconds; held.time() < end;) {
    held.tick();
    most = std::max(most, held.force().norm());
  }
  return most;
}

// The laws that know the hand are at work when it is tapped, the others when the film moves. It
// stands still again before the hand is thrown out of its place. Returns the largest force, N.
double blow(LoopInHand &held, const LoopPoint &point) {
  constexpr double kBlown = 0.15;                      // N
  constexpr double kAboveDeadband = 10;                // px/s
  constexpr std::int64_t kFrame = 5 * LoopInHand::kMs; // what comes later comes too late
  const std::int64_t frame = std::exchange(held.frame, kFrame);
  const double share = std::numbers::pi / 2 * kBlown / point.max_force;
  held.film.x() = std::max(std::tan(share) / point.alpha, kAboveDeadband);
  for (const double end = held.time() + 0.1; held.time() < end && held.force().norm() < kBlown;)
    held.tick();
  held.film.setZero();
  const double most = std::max(held.force().norm(), largest_force(held, 0.2));
  held.frame = frame;
  return most;
}

// Pushes for 20 ms. A tap that would make the hand faster than 0.8 m/s lets go of the grip (1 m/s).
double tap(LoopInHand &held, const LoopPoint &point) {
  constexpr double kTap = 0.02;    // s
  constexpr double kFastest = 0.8; // m/s
  const Vector3 direction =
      point.touch == TouchMode::off ? Vector3::UnitX() : Vector3(0.8, 0, -0.6);
  const Vector3 push = held.hand().push;
  held.hand().push += std::min(point.tap, kFastest * point.hand.mass) / kTap * direction;
  const double most = largest_force(held, kTap);
  held.hand().push = push;
  return most;
}

// The hand lies on the surface with the load, or with as much as the surface carries at 15 mm: late
// ticks make it soft. Its own spring gives way until the surface carries most of that.
void lie_down(LoopInHand &held, const LoopPoint &point) {
  constexpr double kGivesWay = 0.05; // s
  constexpr double kHeaviest = 2;    // N
  constexpr double kLoaded = 2;      // s
  constexpr double kFor = 4;         // s
  constexpr double kDeepest = kLiesAt - 0.015;
  const double load = std::min(point.load * point.max_force, kHeaviest);
  HeldGrip &hand = held.hand();
  const double begin = held.time();
  double before = begin;
  bool deep = false;
  while (held.time() < begin + kFor) {
    const double since = held.time() - begin;
    deep = deep || hand.position().z() < kDeepest;
    if (!deep)
      hand.push.z() = -load * std::min(since / kLoaded, 1.0);
    const double share = std::min((held.time() - before) / kGivesWay, 1.0);
    before = held.time();
    hand.target += share * (hand.position() - hand.target);
    hand.goal = hand.target;
    held.tick();
  }
}

Outcome rest(const LoopPoint &point) {
  constexpr double kRun = 20;          // s
  constexpr double kLooked = 5;        // s
  constexpr double kTapAtWork = 0.002; // N; 0.4 N·s/m of 5 mm/s at least
  const bool lies = point.touch != TouchMode::off;
  LoopInHand held(setup_of(point, {0.004, -0.002, lies ? kLiesAt + 0.0005 : 0.001}));
  if (point.hand == kSimulated)
    held.hand().turning_hand.emplace();
  if (lies)
    held.surface = surface_of(point, kLiesAt);
  held.wait(kFadedIn);
  double worked = 0; // N
  if (lies)
    lie_down(held, point);
  else if (point.hold_law != HoldLaw::motion)
    take_thing(held, point, held.hand().position());
  else if (point.law != "drag" && point.law != "inertial")
    worked = blow(held, point);
  worked = std::max(worked, tap(held, point));
  held.wait(kRun - kLooked - held.time());
  Extent extent;
  Vector3 mean = Vector3::Zero();
  std::size_t ticks = 0;
  for (; held.time() < kRun; ++ticks) {
    held.tick();
    extent.add(held.force());
    mean += held.force();
  }
  const bool at_work = lies ? mean.z() / static_cast<double>(ticks) > -held.hand().push.z() / 10
                            : worked > kTapAtWork;
  return {extent.value(), 0.05, why_idle(held, at_work)};
}

// Ways of a hand that goes as it likes, whatever the force: from a place 2 mm above the surface to
// the depth, sideways, out and back. Without a surface, the way is in the plane of the frame.
class Way {
public:
  static constexpr double kAbove = 0.002; // m

  Way(const LoopPoint &point, const Vector3 &place, bool has_surface = true,
      bool pulls_at_rest = true)
      : point_(point), place_(place), held(setup_of(point, at(0, 0), pulls_at_rest)) {
    held.hand().leads = true;
    held.hand().presses = true;
    held.hand().acceleration = point.acceleration;
    if (has_surface && point.touch != TouchMode::off)
      held.surface = surface_of(point, place.z());
    if (point.hold_law != HoldLaw::motion)
      take_thing(held, point, place);
    held.wait(kFadedIn);
    begun_ = work();
  }

  // Stages: 0 above the surface, 1 half way in, 2 at the bottom, 3 half way out, 4 out, as at 0.
  void go(const std::function<void(int)> &reach_stage = [](int) {}) {
    const double depth = point_.depth;
    const auto stage = [&](int number) {
      held.wait(point_.pause);
      reach_stage(number);
    };
    stage(0);
    lead(0, depth / 2, point_.in);
    stage(1);
    lead(0, depth, point_.in);
    stage(2);
    lead(point_.sideways, depth, point_.out);
    lead(point_.sideways, depth / 2, point_.out);
    stage(3);
    come_out();
    stage(4);
  }
  void come_out() {
    lead(point_.sideways, -kAbove, point_.out);
    lead(0, -kAbove, point_.out);
    worked_ = std::max(worked_, largest_force(held, kFadedIn));
  }
  void begin_to_lead(double sideways, double depth, double speed) {
    held.hand().goal = at(sideways, depth);
    held.hand().speed = speed;
  }
  void lead(double sideways, double depth, double speed) {
    begin_to_lead(sideways, depth, speed);
    while (held.hand().target != held.hand().goal)
      tick();
  }
  void tick(double later = 0) {
    held.tick(later);
    worked_ = std::max(worked_, held.force().norm());
  }

  // What the strings have done on the grip, against what is wanted, mJ. What the loop knew before a
  // jump acts until the exchange after the next; one of both may be late, s.
  Outcome outcome(bool must_work = true, double late = 0) {
    const Pace &pace = point_.pace;
    const double period = (pace.uneven ? 2 : 1) / pace.rate;
    return {1e3 * (work() - begun_), 0.1 * point_.max_force,
            why_idle(held, worked_ > kAtWork || !must_work),
            1e3 * point_.max_force * point_.out * (period + std::max(late, period))};
  }

private:
  // J, of the strings, but for what the thing has done on them by its way.
  double work() { return held.hand().work() - held.work_of_thing(); }
  Vector3 at(double sideways, double depth) const {
    if (point_.touch == TouchMode::off)
      return place_ + Vector3(-depth, sideways, 0);
    return place_ + Vector3(sideways, 0, -depth);
  }

  const LoopPoint &point_;
  Vector3 place_;
  double begun_ = 0;  // J
  double worked_ = 0; // N

public:
  LoopInHand held;
};

const Vector3 kPlace(-0.004, 0.003, 0);

Outcome closed_way(const LoopPoint &point) {
  Way way(point, kPlace);
  way.go();
  return way.outcome();
}

constexpr double kLate = 10; // ms

// One tick comes that long after the one before, on the way out.
void go_with_a_late_tick(Way &way, const LoopPoint &point) {
  way.lead(0, point.depth, point.in);
  way.held.wait(point.pause);
  way.begin_to_lead(0, -Way::kAbove, point.out);
  const Vector3 bottom = way.held.hand().target;
  while ((way.held.hand().target - bottom).norm() < point.depth * point.late_at)
    way.tick();
  way.tick(kLate - 1e3 / point.pace.rate);
  way.come_out();
}

Outcome late_tick(const LoopPoint &point) {
  Way way(point, kPlace);
  go_with_a_late_tick(way, point);
  Outcome outcome = way.outcome(true, 1e-3 * kLate);
  outcome.most = 1;
  return outcome;
}

Outcome paid_back(const LoopPoint &point) {
  Way way(point, kPlace);
  go_with_a_late_tick(way, point);
  for (int i = 0; i < 3; ++i)
    way.go();
  return way.outcome(true, 1e-3 * kLate);
}

// m/s, within a second.
double fastest_when_let_go(LoopInHand &held) {
  HeldGrip &hand = held.hand();
  hand.leads = false;
  double fastest = 0;
  for (const double end = held.time() + 1; held.time() < end;) {
    held.tick();
    fastest = std::max(fastest, hand.velocity().norm());
  }
  return fastest;
}

// Pressed as hard as may be, and then a free grip.
Outcome let_go(const LoopPoint &point) {
  constexpr double kHeight = 0.022; // m; 5 N are 25 mm deep at 200 N/m, twice as much at 500 Hz
  constexpr double kLowest = -0.03; // m
  LoopInHand held(setup_of(point, {0, 0, kHeight + Way::kAbove}));
  held.surface = surface_of(point, kHeight);
  HeldGrip &hand = held.hand();
  hand.leads = true;
  held.wait(kFadedIn);
  hand.goal = {0, 0, kLowest};
  hand.speed = point.in;
  while (hand.target != hand.goal && held.force().norm() < 0.98 * point.max_force)
    held.tick();
  hand.goal = hand.target;
  held.wait(kFadedIn);
  hand.goal = {0, 0, kLowest}; // the damper of a fast hand is gone
  hand.speed = 0.05;
  while (hand.target != hand.goal && held.force().norm() < 0.98 * point.max_force)
    held.tick();
  hand.goal = hand.target;
  held.wait(point.pause);
  const double pressed = held.force().norm();
  return {fastest_when_let_go(held), point.max_force > 1 ? 0.8 : 0.4,
          pressed < 0.2 * point.max_force ? "pressed with less than a fifth of max-force" : ""};
}

// --- What happens to the loop.

// Begins or ends what `event` names.
void happen(LoopInHand &held, const LoopPoint &point, bool begins) {
  const auto hold = [&](std::uint32_t holds) {
    begins ? held.loop.hold(holds) : held.loop.unhold(holds);
  };
  if (point.event == "release")
    hold(haptic::kHoldReleased);
  else if (point.event == "pause")
    hold(haptic::kHoldPaused);
  else if (point.event == "suspend")
    hold(haptic::kHoldSuspended);
  else if (point.event == "dead-man")
    held.hand().presses = !begins;
  else if (point.event == "interrupted" && begins)
    held.hand().intervene();
  else if (point.event == "silent")
    held.hand().answers = !begins;
  else if (point.event == "unplugged")
    held.hand().plugged_in = !begins;
  else if (point.event == "motion")
    held.film.x() = begins ? 300 : 0; // px/s
  else if (point.event == "not-finite")
    held.film.x() = begins ? std::numeric_limits<double>::quiet_NaN() : 0;
  else if (point.event == "budget")
    held.settings.continuous_force = begins ? 0.05 : 0; // N rms
  else if (point.event == "max-force")
    held.settings.law_settings.max_force = begins ? 0 : point.max_force;
  const auto &states = haptic::kHoldStateNames;
  if (const auto state = std::ranges::find(states, point.event); state != states.end()) {
    held.hold = begins ? static_cast<HoldState>(state - states.begin()) : HoldState::held;
    held.confidence = haptic::is_followed(held.hold) || held.hold == HoldState::none ? 1 : 0;
  }
  held.set();
}

// While the force is held the strings rest, and minimum tension pulls off the centre. What that
// does is not the touch's.
Outcome through(const LoopPoint &point) {
  Way way(point, kPlace, true, false);
  way.go([&](int stage) {
    if (stage == point.stages.from)
      happen(way.held, point, true);
    if (stage == point.stages.to)
      happen(way.held, point, false);
  });
  return way.outcome(point.stages.from >= 2); // before, it may forbid every force
}

// The pose jumps, and the strings then pull otherwise where no force is wanted. That is not what
// is asked: the same way without a surface is subtracted. From a centre that is off, strings seem
// to slip. Minimum tension is then at rest, and not at the same time without a surface.
Outcome through_calibrate(const LoopPoint &point) {
  const auto outcome_of = [&](bool touches) {
    Way way(point, kPlace + Vector3(0, 0, point.height), touches, false);
    way.go([&](int stage) {
      if (stage == point.stages.from)
        way.held.loop.calibrate();
    });
    return way.outcome();
  };
  Outcome outcome = outcome_of(true);
  outcome.figure -= outcome_of(false).figure;
  return outcome;
}

// Giving force up is no jump: how far the force is from what it was, or from a part of it.
Outcome calibrate_jump(const LoopPoint &point) {
  constexpr double kSoon = 0.05; // s
  Way way(point, kPlace + Vector3(0, 0, point.height));
  way.lead(0, point.depth, point.in);
  way.held.wait(point.pause);
  way.tick();
  const Vector3 before = way.held.force();
  way.held.loop.calibrate();
  double jump = 0;
  for (const double end = way.held.time() + kSoon; way.held.time() < end;) {
    way.tick();
    const Vector3 force = way.held.force();
    const double part =
        std::clamp(force.dot(before) / std::max(before.squaredNorm(), 1e-12), 0.0, 1.0);
    jump = std::max(jump, (force - part * before).norm());
  }
  return {jump, 0.05, before.norm() < kAtWork ? "no force" : ""};
}

// The thing sways, and carries a hand that has its own will.
Outcome carried(const LoopPoint &point) {
  constexpr double kSettled = 2; // periods
  constexpr double kLooked = 3;  // periods
  const Vector3 place(0.004, -0.002, 0.001);
  LoopInHand held(setup_of(point, place));
  held.wait(kFadedIn); // with the rest tension a free grip moves
  take_thing(held, point, place);
  await_take(held);
  const Vector3 taken = held.hand().position() - held.thing(held.time());
  held.wait(kSettled / point.sway);
  double distance = 0; // m²
  double sway = 0;
  for (const double end = held.time() + kLooked / point.sway; held.time() < end;) {
    held.tick();
    const Vector3 thing = held.thing(held.time());
    distance += (held.hand().position() - thing - taken).head<2>().squaredNorm();
    sway += (thing - place).squaredNorm();
  }
  return {100 * std::sqrt(distance / sway), point.sway < 0.5 ? 10.0 : 30.0, why_idle(held, true)};
}

// Drawn out as far as the spring pulls, and then a free grip.
Outcome let_go_of_thing(const LoopPoint &point) {
  constexpr double kFarthest = 0.022; // m
  LoopInHand held(setup_of(point, {-0.01, 0, 0}));
  HeldGrip &hand = held.hand();
  hand.leads = true;
  held.wait(kFadedIn);
  take_thing(held, point, hand.position());
  await_take(held);
  hand.goal = {kFarthest, 0, 0};
  hand.speed = point.in;
  while (hand.target != hand.goal)
    held.tick();
  held.wait(point.pause);
  held.tick(); // the hand stands
  const double pulled = held.force().norm();
  return {fastest_when_let_go(held), point.max_force > 1 ? 0.8 : 0.4,
          pulled < 0.2 * point.max_force ? "pulled with less than a fifth of max-force" : ""};
}

// The thing goes away from a hand that stays; then what the event says.
Outcome thing_off(const LoopPoint &point) {
  constexpr double kLongest = 100; // s
  LoopInHand held(setup_of(point, Vector3::Zero()));
  HeldGrip &hand = held.hand();
  hand.leads = hand.presses = true;
  held.wait(kFadedIn);
  take_thing(held, point, Vector3::Zero());
  held.ahead = 0;
  await_take(held);
  hand.goal.x() = 0.02;
  hand.speed = 0.02;
  held.settings.slew_rate = 1000; // a slow force has to come, too
  held.set();
  while (hand.target != hand.goal)
    held.tick();
  held.settings.slew_rate = point.slew_rate;
  held.set();
  held.wait(0.1);
  const double force = held.force().norm();
  happen(held, point, true);
  const double begin = held.time();
  while (!held.loop.wrench().force.isZero(0) && held.time() < begin + kLongest)
    held.tick();
  return {1e3 * (held.time() - begin), 100, force < 0.1 ? "less than 0.1 N" : ""};
}

// A film that always pushes on a hand that is led round, or a surface that lifts it, or both.
Outcome work(const LoopPoint &point) {
  constexpr double kRadius = 0.02;                   // m
  constexpr double kDepth = 0.01;                    // m, of the hand in the surface
  constexpr double kRun = 10;                        // s
  constexpr double kWindow = 5;                      // s
  constexpr double kFastestSurface = 0.1;            // m/s
  constexpr double kSurfaceTurns = 0.2;              // s
  constexpr double kFilm = 20000;                    // px/s; no hand is faster
  const double ahead = 0.02 + 0.4 / point.slew_rate; // s, by what interpolation and slew rate delay
  LoopInHand held(setup_of(point, {kRadius, 0, 0}));
  held.frame = 10 * LoopInHand::kMs;
  held.hand().leads = true;
  held.hand().speed = point.speed;
  held.film.x() = kFilm;
  if (point.touch != TouchMode::off)
    held.surface = surface_of(point, 0);
  // A slow force has first to come.
  held.wait(kFadedIn + std::min(point.max_force / point.slew_rate, 60.0));

  struct Part {
    double time = 0; // s
    double work = 0; // J
  };
  std::deque<Part> done;
  double sum = 0; // of what the strings did in the window; what the hand did is none
  double most = 0;
  double before = held.hand().work();
  for (const double begin = held.time(); held.time() < begin + kRun;) {
    const double angle = point.speed / kRadius * (held.time() - begin);
    if (point.film_leads) {
      const double film = angle + point.speed / kRadius * ahead;
      held.film = kFilm * Vector3(-std::sin(film), -std::cos(film), 0); // y down
    }
    held.hand().goal = kRadius * Vector3(std::cos(angle), std::sin(angle), 0);
    if (held.surface) {
      const double phase = std::fmod(held.time() - begin, 2 * kSurfaceTurns);
      const double rise = kFastestSurface * std::min(phase, 2 * kSurfaceTurns - phase);
      held.surface->height = static_cast<float>(rise);
      held.hand().goal.z() = rise - kDepth;
    }
    held.tick();
    const double by = std::max(held.hand().work() - before, 0.0);
    before = held.hand().work();
    done.push_back({held.time(), by});
    sum += by;
    while (done.front().time < held.time() - kWindow) {
      sum -= done.front().work;
      done.pop_front();
    }
    most = std::max(most, sum);
  }
  const bool damped = point.damping * point.speed > point.max_force / 2; // little is left
  return {most, 2.5, most < 0.01 && !damped ? "less than 10 mJ" : ""};
}

Outcome off(const LoopPoint &point) {
  constexpr double kLongest = 100; // s
  LoopInHand held(setup_of(point, Vector3::Zero()));
  held.frame = LoopInHand::kMs;
  HeldGrip &hand = held.hand();
  hand.leads = hand.presses = true;
  hand.speed = 0.1; // m/s
  held.film.x() = 1e5;
  if (point.touch != TouchMode::off) {
    held.surface = surface_of(point, 0);
    hand.goal.z() = -0.03;
  }
  held.settings.slew_rate = 1000; // a slow force has to come, too
  held.set();
  held.wait(1);
  held.settings.slew_rate = point.slew_rate;
  held.set();
  held.wait(0.1);
  const double force = held.force().norm();
  Outcome outcome{0, 100, force < 0.1 ? "less than 0.1 N" : ""};
  if (point.event == "late") {
    held.tick(25);
  } else if (point.event == "overspeed") {
    hand.goal.y() = 1;
    hand.speed = 1.5;
    for (int i = 0; i < 1000 && held.loop.statistics().overspeeds == 0; ++i)
      held.tick();
  } else {
    happen(held, point, true);
  }
  const double begin = held.time();
  while (!held.loop.wrench().force.isZero(0) && held.time() < begin + kLongest)
    held.tick();
  outcome.figure = 1e3 * (held.time() - begin);
  return outcome;
}

// --- The table.

const std::vector<TouchMode> kTouched{TouchMode::surface, TouchMode::surface_and_motion};
const std::vector<double> kFrictions{0.0, 0.5};
const std::vector<double> kDepths{0.005, 0.01, 0.02};
const std::vector<double> kSpeeds{0.05, 0.3, 0.9};
const std::vector<std::string> kOffEvents{"max-force", "release", "dead-man",
                                          "suspend",   "silent",  "unplugged",
                                          "overspeed", "late",    "not-finite"};

Axis taps() {
  return axis("tap", &LoopPoint::tap, {0.01, 0.1});
}
Axis loads() {
  return axis("load", &LoopPoint::load, {0.2, 0.5, 0.8});
}
Axis frictions() {
  return axis("friction", &LoopPoint::friction, kFrictions);
}
Axis depths() {
  return axis("depth", &LoopPoint::depth, kDepths);
}
// From a centre that is 25 mm wrong, turns of 90 rad/s are measured.
Axis calibrated_depths() {
  return axis("depth", &LoopPoint::depth, {0.005, 0.01});
}
Axis ins() {
  return axis("in", &LoopPoint::in, kSpeeds);
}
Axis outs() {
  return axis("out", &LoopPoint::out, kSpeeds);
}
// A hand that is 0.9 m/s fast after 4 mm, and one that jumps to it.
Axis accelerations() {
  return axis("acceleration", &LoopPoint::acceleration,
              {100.0, std::numeric_limits<double>::infinity()});
}
Axis slew_rates(const std::vector<double> &values) {
  return axis("slew-rate", &LoopPoint::slew_rate, values);
}
Axis pauses() {
  return axis("pause", &LoopPoint::pause, {0.0, 0.4});
}
Axis heights() {
  return axis("height", &LoopPoint::height, {-0.005, 0.005, 0.01});
}
Axis late_ats() {
  return axis("late-at", &LoopPoint::late_at, {0.05, 0.25, 0.5, 0.75, 0.95});
}
Axis events(const std::vector<std::string> &names) {
  return axis("event", &LoopPoint::event, names);
}
Axis stages(const std::vector<Stages> &values) {
  return axis("stages", &LoopPoint::stages, values);
}
Axis laws_of_the_hand() {
  return axis("law", &LoopPoint::law, std::vector<std::string>{"drag", "inertial"});
}

std::vector<LoopRow> rows_of(const Axis &device, const Axis &forces) {
  return {
      {"still-frame",
       "N peak to peak in the last 5 of 20 s",
       {device, laws(), alphas(), forces, taps(), hands(), any_paces()},
       rest},
      {"surface",
       "N peak to peak in the last 5 of 20 s",
       {device, touches({TouchMode::surface}), forces, loads(), frictions(), taps(), hands(),
        any_paces()},
       rest},
      {"surface+law",
       "N peak to peak in the last 5 of 20 s",
       {device, touches({TouchMode::surface_and_motion}), laws_of_the_hand(), alphas(), forces,
        loads(), frictions(), taps(), hands(), few_paces()},
       rest},
      {"closed-way",
       "mJ that the strings do on the hand",
       {device, touches(kTouched), laws_of_the_hand(), forces, frictions(), slew_rates({20, 1000}),
        depths(), ins(), outs(), accelerations(),
        axis("sideways", &LoopPoint::sideways, {0.0, 0.01}), pauses(), paces_on_time()},
       closed_way},
      {"closed-way-law",
       "mJ that the strings do on the hand",
       {device, laws_of_the_hand(), alphas(), forces, slew_rates({20, 1000}), depths(), ins(),
        outs(), accelerations(), axis("sideways", &LoopPoint::sideways, {0.0, 0.01}),
        paces_on_time()},
       closed_way},
      {"late-tick",
       "mJ that the strings do on the hand",
       {device, touches(kTouched), forces, frictions(), slew_rates({20, 1000}), depths(), ins(),
        outs(), accelerations(), late_ats(), pauses(), steady_paces()},
       late_tick},
      {"paid-back",
       "mJ that the strings do on the hand, after three more ways",
       {device, touches(kTouched), forces, frictions(), slew_rates({20, 1000}), depths(), ins(),
        outs(), accelerations(), late_ats(), pauses(), steady_paces()},
       paid_back},
      {"let-go",
       "m/s of 0.1 kg",
       {device, axis("hand", &LoopPoint::hand, std::vector<Hand>{{0.1, 0.5, 0}}), touches(kTouched),
        forces, frictions(), slew_rates({20, 1000}), ins(), pauses(), paces_on_time()},
       let_go},
      {"through",
       "mJ that the strings do on the hand",
       {device, touches(kTouched),
        events({"release", "pause", "dead-man", "budget", "max-force", "motion", "interrupted"}),
        stages({{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}), forces,
        frictions(), axis("depth", &LoopPoint::depth, {0.005, 0.02}),
        axis("in", &LoopPoint::in, {0.05, 0.9}), axis("out", &LoopPoint::out, {0.05, 0.9}),
        accelerations(), pauses(), steady_paces()},
       through},
      {"through-calibrate",
       "mJ that the strings do on the hand, more than without a surface",
       {device, touches(kTouched), stages({{1, 1}, {2, 2}, {3, 3}}), heights(), forces, frictions(),
        slew_rates({20, 1000}), calibrated_depths(), ins(), outs(), accelerations(), pauses(),
        steady_paces()},
       through_calibrate},
      {"calibrate",
       "N by which the force jumps within 50 ms",
       {device, touches(kTouched), heights(), forces, frictions(), slew_rates({20, 1000}),
        calibrated_depths(), ins(), pauses(), steady_paces()},
       calibrate_jump},
      {"work",
       "J in 5 s",
       {device, touches({TouchMode::off, TouchMode::surface_and_motion}),
        axis("law", &LoopPoint::law, std::vector<std::string>{"arctan", "arctan-axis", "linear"}),
        axis("alpha", &LoopPoint::alpha, {0.01, 10.0}),
        axis("max-force", &LoopPoint::max_force, {1.0, 2.5, 5.0}), slew_rates({0.1, 1, 20, 1000}),
        axis("damping", &LoopPoint::damping, {0.0, 1.0}), axis("speed", &LoopPoint::speed, kSpeeds),
        axis("film-leads", &LoopPoint::film_leads, std::vector<bool>{false, true}), few_paces()},
       work},
      {"carried",
       "% of the sway, rms, by which the hand is off the thing",
       {device, axis("hand", &LoopPoint::hand, carried_hands()),
        axis("hold-law", &LoopPoint::hold_law, std::vector{HoldLaw::carry}),
        axis("swing", &LoopPoint::swing, {0.0057}), axis("sway", &LoopPoint::sway, {0.2, 1.0}),
        forces,
        axis("pace", &LoopPoint::pace,
             std::vector<Pace>{{.rate = 1000}, {.rate = 2000}, {.rate = 4000}})},
       carried},
      {"still-thing",
       "N peak to peak in the last 5 of 20 s",
       {device, hold_laws(), laws_of_the_hand(), alphas(), forces, taps(), hands(), any_paces()},
       rest},
      {"closed-way-thing",
       "mJ that the strings do on the hand, less what the thing does",
       {device, hold_laws(), laws_of_the_hand(), forces, slew_rates({20, 1000}), depths(), ins(),
        outs(), accelerations(), axis("sideways", &LoopPoint::sideways, {0.0, 0.01}),
        axis("swing", &LoopPoint::swing, {0.0, 0.003}), pauses(), paces_on_time()},
       closed_way},
      {"late-tick-thing",
       "mJ that the strings do on the hand",
       {device, hold_laws(), forces, slew_rates({20, 1000}), depths(), ins(), outs(),
        accelerations(), late_ats(), pauses(), steady_paces()},
       late_tick},
      {"paid-back-thing",
       "mJ that the strings do on the hand, after three more ways",
       {device, hold_laws(), forces, slew_rates({20, 1000}), depths(), ins(), outs(),
        accelerations(), late_ats(), pauses(), steady_paces()},
       paid_back},
      {"through-thing",
       "mJ that the strings do on the hand",
       {device, hold_laws(),
        events({"release", "pause", "dead-man", "budget", "max-force", "interrupted", "none",
                "about", "hidden", "lost"}),
        stages({{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}), forces,
        axis("depth", &LoopPoint::depth, {0.005, 0.02}), axis("in", &LoopPoint::in, {0.05, 0.9}),
        axis("out", &LoopPoint::out, {0.05, 0.9}), accelerations(), pauses(), steady_paces()},
       through},
      {"let-go-thing",
       "m/s of 0.1 kg",
       {device, axis("hand", &LoopPoint::hand, std::vector<Hand>{{0.1, 0.5, 0}}), hold_laws(),
        forces, slew_rates({20, 1000}), ins(), axis("pause", &LoopPoint::pause, {0.1, 0.4}),
        paces_on_time()},
       let_go_of_thing},
      {"off-thing",
       "ms until the force is zero",
       {device, hold_laws(),
        events({"none", "about", "lost", "refused", "max-force", "release", "dead-man", "suspend",
                "silent", "unplugged", "not-finite"}),
        forces, slew_rates({2, 20, 1000}), any_paces()},
       thing_off},
      {"off",
       "ms until the force is zero",
       {device, touches({TouchMode::off, TouchMode::surface, TouchMode::surface_and_motion}),
        events(kOffEvents), forces, slew_rates({0.1, 20, 1000}), any_paces()},
       off},
  };
}

const std::vector<LoopRow> &rows(Bench bench) {
  static const std::vector<LoopRow> on_strings = rows_of(geometries(), max_forces(kSpidar.force));
  static const std::vector<LoopRow> on_arm = rows_of(arm(), max_forces(kArm.force));
  return bench == Bench::strings ? on_strings : on_arm;
}

} // namespace

std::size_t LoopRow::size() const {
  std::size_t points = 1;
  for (const Axis &each : axes)
    points *= each.names.size();
  return points;
}

LoopPoint LoopRow::at(std::size_t index) const {
  LoopPoint point;
  for (const Axis &each : axes) {
    each.set(point, index % each.names.size());
    index /= each.names.size();
  }
  return point;
}

std::string LoopRow::words(std::size_t index) const {
  std::string words;
  for (const Axis &each : axes) {
    words += (words.empty() ? "" : " ") + each.names[index % each.names.size()];
    index /= each.names.size();
  }
  return words;
}

std::vector<std::size_t> LoopRow::select(const std::string &only, std::size_t count,
                                         unsigned seed) const {
  std::vector<std::string> wanted;
  std::istringstream words_of(only);
  for (std::string word; words_of >> word;)
    wanted.push_back(" " + word + " ");
  std::vector<std::size_t> selected;
  for (std::size_t i = 0; i < size(); ++i) {
    const std::string all = wanted.empty() ? "" : " " + words(i) + " ";
    if (std::ranges::all_of(wanted,
                            [&](const std::string &word) { return all.find(word) != all.npos; }))
      selected.push_back(i);
  }
  if (count == 0 || count >= selected.size())
    return selected;
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(selected[i], selected[i + random() % (selected.size() - i)]);
  selected.resize(count);
  return selected;
}

// Greedy: each point begins with three values that no point before it has together, and takes of
// each other axis the value that brings most such threes; of equal ones, another one than the point
// before.
std::vector<std::size_t> LoopRow::threes() const {
  struct Value {
    std::size_t axis;
    std::size_t value;
    auto operator<=>(const Value &) const = default;
  };
  using Three = std::array<Value, 3>; // by axis
  std::set<Three> missing;
  const auto for_threes = [](std::size_t count, auto &&body) {
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = a + 1; b < count; ++b)
        for (std::size_t c = b + 1; c < count; ++c)
          body(a, b, c);
  };
  for_threes(axes.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
    for (std::size_t i = 0; i < axes[a].names.size(); ++i)
      for (std::size_t j = 0; j < axes[b].names.size(); ++j)
        for (std::size_t k = 0; k < axes[c].names.size(); ++k)
          missing.insert({Value{a, i}, {b, j}, {c, k}});
  });
  const auto brings = [&](const std::vector<Value> &chosen, Value next) {
    std::size_t count = 0;
    for (std::size_t a = 0; a < chosen.size(); ++a)
      for (std::size_t b = a + 1; b < chosen.size(); ++b) {
        Three three{chosen[a], chosen[b], next};
        std::ranges::sort(three);
        count += missing.count(three);
      }
    return count;
  };
  std::vector<std::size_t> points;
  while (!missing.empty()) {
    std::vector<Value> chosen(missing.begin()->begin(), missing.begin()->end());
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      if (std::ranges::count(chosen, axis, &Value::axis) > 0)
        continue;
      const std::size_t values = axes[axis].names.size();
      Value best{axis, points.size() % values};
      std::size_t most = brings(chosen, best);
      for (std::size_t i = 1; i < values; ++i) {
        const Value next{axis, (points.size() + i) % values};
        if (const std::size_t count = brings(chosen, next); count > most) {
          best = next;
          most = count;
        }
      }
      chosen.push_back(best);
    }
    std::ranges::sort(chosen);
    std::size_t index = 0;
    for (std::size_t axis = axes.size(); axis-- > 0;)
      index = index * axes[axis].names.size() + chosen[axis].value;
    points.push_back(index);
    for_threes(axes.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
      missing.erase({chosen[a], chosen[b], chosen[c]});
    });
  }
  return points;
}

std::span<const LoopRow> closed_loop_table(Bench bench) {
  return rows(bench);
}

const LoopRow &closed_loop_row(std::string_view name, Bench bench) {
  for (const LoopRow &row : rows(bench))
    if (row.name == name)
      return row;
  throw std::invalid_argument("no row '" + std::string(name) + "' in the table of the closed loop");
}

} // namespace test
