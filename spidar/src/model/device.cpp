// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/device.hpp"

#include "fail.hpp"
#include "model/drive-scale.hpp"
#include "model/slip-detector.hpp"
#include "model/string-kinematics.hpp"
#include "spidar/pose-solver.hpp"
#include "spidar/tension-solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

namespace spidar {

namespace {

// No hand moves faster; a turn counts at the grip radius.
constexpr double kFastest = 5;      // m/s
constexpr double kSamePlace = 1e-5; // m; to which a pose is solved
// Eight lengths fit a pose to the precision of the geometry; worse means slack or a slipped string.
constexpr double kLargestResidual = 0.005; // m rms
constexpr double kTurningCutoff = 100;     // Hz; a grip turns up faster than it moves off

// To minimum tension and back. It changes no tension by more than 0.05 N a millisecond.
constexpr double kBalancing = 0.1;  // s
constexpr double kOldCounts = 0.01; // s: a tick that is later holds the force

constexpr double kSettleWindow = 0.05; // s without movement: the strings are taut
constexpr double kLongestSettling = 1; // s
constexpr std::int32_t kSettledCounts = 3;
constexpr int kMostSilentTicks = 10; // while starting

// The lightest hand is a free grip, which its strings alone damp. No unit's mass, damping and
// inertia are published; these are those of the simulator, and the smallest of its hands.
constexpr double kGripMass = 0.1;      // kg
constexpr double kStringDamping = 0.5; // N·s/m
// More damping pumps a light grip up, also over a still frame: relative-law-test.cpp, of counts of
// up to 35 µm.
constexpr double kMostDamping = 2;    // N·s/m
constexpr double kFastestRate = 4000; // Hz, that was tried
// Of a count: how far that of one of eight strings moves the place, at the centre.
constexpr double kFlickerWay = 0.375;
// Each flicker costs k counts²; 200 N/m and 17 µm are 0.06 µJ.
constexpr double kFlicker = 2e-5; // W/N
// Against a grip of 2e-5 kg m² (docs/force.md#turning).
constexpr double kTurnBrake = 7.5e-3; // N·m·s
// A free grip under no force is turned by no more than minimum tension does in the workspace.
constexpr double kSideTorque = 0.012; // N·m

double seconds(std::int64_t nanoseconds) noexcept {
  return static_cast<double>(nanoseconds) * 1e-9;
}

// Share of a new value in a first-order low-pass after `elapsed` s.
double low_pass_share(double cutoff, double elapsed) noexcept {
  return 1 - std::exp(-2 * std::numbers::pi * cutoff * elapsed);
}

bool can_reach(const Pose &from, const Pose &to, double grip_radius, double time) noexcept {
  const Vector3 turn = rotation_vector(from.rotation.transpose() * to.rotation);
  return std::max((to.position - from.position).norm(), grip_radius * turn.norm()) <=
         kSamePlace + kFastest * time;
}

} // namespace

// One motor pulls a force, and a couple of them a torque. The damping of the strings holds what it
// does at the fastest rate.
DeviceLimits limits_of(const Geometry &geometry) noexcept {
  DeviceLimits limits;
  limits.force = geometry.tension_max;
  limits.torque = 2 * geometry.tension_max * geometry.grip_radius;
  limits.rate = kFastestRate;
  limits.degrees_of_freedom = 6;
  for (const double count : geometry.metres_per_count)
    limits.metres_per_count = std::max(limits.metres_per_count, std::abs(count));
  limits.flicker_way = kFlickerWay * limits.metres_per_count;
  limits.physical_damping = kStringDamping;
  limits.damping = kMostDamping;
  limits.mass = kGripMass;
  limits.stiffness = kStringDamping * kFastestRate / limits.delay;
  limits.flicker = kFlicker;
  limits.grip_is_free = true;
  limits.turn_brake = kTurnBrake;
  limits.side_torque = kSideTorque;
  return limits;
}

namespace {

// No string pulls more than its largest word says, or the solver would count on more than comes.
Geometry within_words(Geometry geometry) noexcept {
  for (std::size_t i = 0; i < kStrings; ++i)
    geometry.tension_max = std::min(geometry.tension_max,
                                    geometry.dac_limit / std::abs(digits_per_newton(geometry, i)));
  return geometry;
}

} // namespace

struct Device::Implementation {
  std::unique_ptr<Controller> controller;
  Geometry geometry;
  DeviceLimits limits;
  double period;
  PoseSolver pose_solver;
  TensionSolver tension_solver;
  SlipDetector slip;
  StringLengths home_lengths;
  Counts home_counts{};
  Counts counts{};
  DacWords words{};
  DeviceState state;
  WrenchMatrix pull;                        ///< at the pose of the state
  Pose last_solved;                         ///< also if it was rejected
  std::optional<std::int64_t> exchanged_at; ///< ns, monotonic
  double since_exchange = 0;                ///< s, between the last two exchanges
  double since_valid = 0;                   ///< s, from the last valid pose to the last exchange
  double since_answer = 0;                  ///< s, from the counts to the last exchange
  bool takes_centre = false;                ///< again at the next answer, if the counts were old
  bool velocity_known = false;              ///< the pose before is part of the same movement
  Tensions at_rest;                         ///< N, of relax()
  Tensions at_motors;                       ///< N, since the last exchange
  Tensions acting;                          ///< N, between the last two exchanges
  Tensions impulse = Tensions::Zero();      ///< N·s, since the last valid pose
  double balanced = 0;                      ///< 0..1 of the pull that minimum tension has here
  bool rests = false;
  bool tracked = false;         ///< a pose was accepted since start()
  bool button_released = false; ///< once at least

  Implementation(std::unique_ptr<Controller> the_controller, Geometry the_geometry,
                 double the_period)
      : controller(std::move(the_controller)), geometry(within_words(std::move(the_geometry))),
        limits(limits_of(geometry)), period(the_period), pose_solver(geometry),
        tension_solver(geometry), slip(geometry.grip_radius),
        home_lengths(string_lengths(geometry, {})), pull(string_kinematics(geometry, {}).pull) {
    relax();
    at_rest = at_motors = acting = state.tensions;
    controller->guard(words);
  }

  void set_tensions(const Tensions &tensions) noexcept {
    for (std::size_t i = 0; i < kStrings; ++i) {
      words[i] = word_of_tension(geometry, i, tensions[i]);
      state.tensions[i] = tension_of_word(geometry, i, words[i]);
    }
    state.realised = realised_wrench(pull, state.tensions);
  }

  void command(const Wrench &wrench) noexcept {
    const double step = since_exchange / kBalancing;
    balanced += std::clamp((rests ? 0 : 1) - balanced, -step, step);
    const Tensions minimum = Tensions::Constant(geometry.tension_min);
    const Wrench kept = realised_wrench(pull, (1 - balanced) * minimum);
    const TensionSolver::Result result =
        tension_solver.solve({wrench.force + kept.force, wrench.torque + kept.torque}, state.pose);
    set_tensions(result.tensions);
    state.given_up = {wrench.force - result.realised.force, wrench.torque - result.realised.torque};
    state.feasible = state.given_up.force.norm() <= TensionSolver::kFeasible;
  }

  void relax() noexcept {
    set_tensions(Tensions::Constant(geometry.tension_min));
    balanced = 0;
  }

  void update_lengths() noexcept {
    state.counts = counts;
    for (std::size_t i = 0; i < kStrings; ++i)
      state.lengths[i] = home_lengths[i] + (static_cast<double>(counts[i]) - home_counts[i]) *
                                               geometry.metres_per_count[i];
  }

  /// The words that were just sent act from now on, those of the exchange before acted until now.
  void note_words() noexcept {
    acting = state.interrupted ? at_rest : at_motors;
    at_motors = state.interrupted ? at_rest : state.tensions;
    impulse += since_exchange * acting;
  }

  /// Midpoint rule: what a tension does is the way by which its string becomes shorter.
  void tell_what_acted() noexcept {
    const Tensions mean = since_valid > 0 ? Tensions(impulse / since_valid) : acting;
    const Pose middle{state.pose.position - state.moved / 2,
                      turned(state.pose.rotation, -state.turned / 2)};
    state.acted = realised_wrench(string_kinematics(geometry, middle).pull, mean);
  }

  // v' = (x_n - x_n-1) / dt and w' = rotation vector of (R_n R_n-1^T) / dt, each low-passed, with
  // the measured dt.
  void accept(const Pose &pose) noexcept {
    const Vector3 moved = pose.position - state.pose.position;
    const Vector3 turn = rotation_vector(pose.rotation * state.pose.rotation.transpose());
    if (!velocity_known) {
      state.velocity.setZero();
      state.angular_velocity.setZero();
    } else if (since_valid > 0) {
      state.velocity += low_pass_share(DeviceLimits::kSpeedCutoff, since_valid) *
                        (moved / since_valid - state.velocity);
      state.angular_velocity += low_pass_share(kTurningCutoff, since_valid) *
                                (turn / since_valid - state.angular_velocity);
    }
    state.moved = velocity_known ? moved : Vector3::Zero();
    state.turned = velocity_known ? turn : Vector3::Zero();
    state.pose = pose;
    pull = string_kinematics(geometry, pose).pull;
    tell_what_acted();
    velocity_known = true;
    since_valid = 0;
    impulse.setZero();
    state.valid = true;
  }

  void reject() noexcept {
    state.valid = false;
    state.moved.setZero();
    state.turned.setZero();
    tell_what_acted();
  }

  void update_pose() noexcept {
    const PoseSolver::Result solved = pose_solver.solve(state.lengths, state.pose);
    if (solved.singular)
      return reject();
    slip.step(solved.misfit, solved.pose, since_exchange);
    if (solved.residual > kLargestResidual)
      return reject();
    const bool continues = can_reach(state.pose, solved.pose, geometry.grip_radius, since_valid);
    // The same new place twice is no error: the grip has moved while no pose was valid.
    const bool confirmed =
        !state.valid && can_reach(last_solved, solved.pose, geometry.grip_radius, since_exchange);
    last_solved = solved.pose;
    if (!continues && !confirmed)
      return reject();
    if (!continues) {
      if (tracked) // the hand may do anything between start() and the first exchange
        slip.jump(solved.misfit);
      velocity_known = false;
    }
    accept(solved.pose);
    tracked = true;
  }

  bool exchange(std::int64_t now) noexcept {
    since_exchange = exchanged_at ? std::max(seconds(now - *exchanged_at), 0.0) : period;
    since_valid += since_exchange;
    const double age_of_counts = since_answer + since_exchange;
    const bool are_old = !exchanged_at || age_of_counts > kOldCounts;
    exchanged_at = now;
    controller->set_time(now);
    const bool answered = controller->exchange(words, counts);
    since_answer = answered ? 0 : age_of_counts;
    state.interrupted = controller->interrupted();
    if (state.interrupted)
      balanced = 0;
    state.pressed = answered && (controller->pressed() || button_is_pressed());
    note_words();
    if (!answered) {
      reject();
      return false;
    }
    if (std::exchange(takes_centre, false) && are_old)
      take_centre();
    update_lengths();
    update_pose();
    state.slipping = slip.slipping();
    state.slipped = slip.slipped();
    return true;
  }

  bool button_is_pressed() noexcept {
    if (!geometry.button)
      return false;
    const bool pressed = geometry.button->is_pressed(controller->inputs());
    button_released = button_released || !pressed;
    return pressed && button_released;
  }

  /// The counts are those of the last answer. The hand may have moved since.
  void calibrate() noexcept {
    const bool answers = since_answer == 0;
    take_centre();
    state.valid = answers;
    takes_centre = true;
  }

  void take_centre() noexcept {
    home_counts = counts;
    update_lengths();
    state.pose = last_solved = {};
    slip.calibrate();
    state.slipping = state.slipped = false;
    velocity_known = false;
    accept({});
  }

  bool moved_since(const Counts &before) const noexcept {
    for (std::size_t i = 0; i < kStrings; ++i)
      if (std::abs(static_cast<std::int64_t>(counts[i]) - before[i]) > kSettledCounts)
        return true;
    return false;
  }

  /// Waits until the motors have wound up the slack: it would shift the centre.
  void settle() {
    std::optional<Counts> before; // those of the first answer are of before the motors pulled
    int silent = 0;
    double still = 0;
    for (double time = 0; time < kLongestSettling && still < kSettleWindow; time += period) {
      if (!controller->exchange(words, counts)) {
        if (++silent >= kMostSilentTicks)
          fail(Cause::io, messages::kUsbSilent, controller->description().c_str());
      } else {
        silent = 0;
        still += period;
        if (!before || moved_since(*before)) {
          before = counts;
          still = 0;
        }
      }
      std::this_thread::sleep_for(std::chrono::duration<double>(period));
    }
  }

  void start() {
    if (controller->home(home_counts)) {
      // The first pose may be anywhere in the workspace; there is none before it to jump from.
      if (!controller->exchange(words, counts))
        return;
      update_lengths();
      const PoseSolver::Result solved = pose_solver.solve(state.lengths, {});
      last_solved = solved.pose;
      if (!solved.singular)
        accept(solved.pose);
      return;
    }
    settle();
    take_centre();
  }
};

Device::Device(std::unique_ptr<Controller> controller, Geometry geometry, double period) {
  if (!controller)
    fail(Cause::argument, messages::kNoController);
  if (!(period >= 1e-5 && period <= 0.1))
    fail(Cause::argument, messages::kPeriod, "device");
  check_geometry(geometry);
  implementation_ =
      std::make_unique<Implementation>(std::move(controller), std::move(geometry), period);
  implementation_->start();
}

Device::~Device() {
  Implementation &device = *implementation_;
  device.relax();
  for (int i = 0; i < 2; ++i) // a controller may lose one
    device.controller->exchange(device.words, device.counts);
}

bool Device::exchange(std::int64_t now) noexcept {
  return implementation_->exchange(now);
}

void Device::command(const Wrench &wrench) noexcept {
  const bool finite = wrench.force.allFinite() && wrench.torque.allFinite();
  implementation_->command(finite ? wrench : Wrench{});
}

void Device::let_rest(bool rests) noexcept {
  implementation_->rests = rests;
}

void Device::limit_side_torque(double limit) noexcept {
  implementation_->tension_solver.limit_side_torque(limit);
}

void Device::rest() noexcept {
  implementation_->relax();
}

void Device::calibrate() noexcept {
  implementation_->calibrate();
}

bool Device::connected() const noexcept {
  return implementation_->controller->connected();
}

const DeviceState &Device::state() const noexcept {
  return implementation_->state;
}

const Geometry &Device::geometry() const noexcept {
  return implementation_->geometry;
}

const Vector3 &Device::workspace_half() const noexcept {
  return implementation_->geometry.workspace_half;
}

const DeviceLimits &Device::limits() const noexcept {
  return implementation_->limits;
}

std::string Device::description() const {
  return implementation_->controller->description();
}

std::string Device::remark() const {
  return implementation_->controller->remark();
}

std::string Device::identity() const {
  return implementation_->controller->identity();
}

std::uint16_t Device::inputs() const noexcept {
  return implementation_->controller->inputs();
}

} // namespace spidar
