// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/device.hpp"

#include "drive-scale.hpp"
#include "fail.hpp"
#include "spidar/pose-solver.hpp"
#include "spidar/tension-solver.hpp"
#include "string-kinematics.hpp"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <thread>

namespace spidar {

namespace {

// No hand moves faster; a turn counts at the grip radius.
constexpr double kFastest = 5; // m/s
// Eight lengths fit a pose to the precision of the geometry; worse means slack or a slipped string.
constexpr double kLargestResidual = 0.005; // m rms
constexpr double kVelocityCutoff = 35;     // Hz; one count per tick is 17 mm/s before it

constexpr double kSettleWindow = 0.05; // s without movement: the strings are taut
constexpr double kLongestSettling = 1; // s
constexpr std::int32_t kSettledCounts = 3;
constexpr int kMostSilentTicks = 10; // while starting

double jump(const Pose &from, const Pose &to, double grip_radius) noexcept {
  const double angle = Eigen::AngleAxisd(Matrix3(from.rotation.transpose() * to.rotation)).angle();
  return std::max((to.position - from.position).norm(), grip_radius * angle);
}

} // namespace

struct Device::Implementation {
  std::unique_ptr<Controller> controller;
  Geometry geometry;
  double period;
  PoseSolver pose_solver;
  TensionSolver tension_solver;
  StringLengths home_lengths;
  Counts home_counts{};
  Counts counts{};
  DacWords words{};
  DeviceState state;
  Pose last_solved; ///< also if it was rejected
  int ticks_since_valid = 0;
  bool velocity_known = false; ///< the pose before is part of the same movement

  Implementation(std::unique_ptr<Controller> the_controller, Geometry the_geometry,
                 double the_period)
      : controller(std::move(the_controller)), geometry(std::move(the_geometry)),
        period(the_period), pose_solver(geometry), tension_solver(geometry),
        home_lengths(string_lengths(geometry, {})) {
    relax();
    controller->guard(words);
  }

  void set_tensions(const Tensions &tensions) noexcept {
    for (std::size_t i = 0; i < kStrings; ++i) {
      words[i] = word_of_tension(geometry, i, tensions[i]);
      state.tensions[i] = tension_of_word(geometry, i, words[i]);
    }
    state.realised = realised_wrench(string_kinematics(geometry, state.pose).pull, state.tensions);
  }

  void relax() noexcept { set_tensions(Tensions::Constant(geometry.tension_min)); }

  void update_lengths() noexcept {
    state.counts = counts;
    for (std::size_t i = 0; i < kStrings; ++i)
      state.lengths[i] = home_lengths[i] + (static_cast<double>(counts[i]) - home_counts[i]) *
                                               geometry.metres_per_count[i];
  }

  void accept(const Pose &pose) noexcept {
    if (velocity_known) {
      const double elapsed = period * (ticks_since_valid + 1);
      const double share = 1 - std::exp(-2 * std::numbers::pi * kVelocityCutoff * elapsed);
      state.velocity += share * ((pose.position - state.pose.position) / elapsed - state.velocity);
    } else {
      state.velocity.setZero();
    }
    velocity_known = true;
    ticks_since_valid = 0;
    state.pose = pose;
    state.valid = true;
  }

  void reject() noexcept {
    ++ticks_since_valid;
    state.valid = false;
  }

  void update_pose() noexcept {
    const PoseSolver::Result solved = pose_solver.solve(state.lengths, state.pose);
    if (solved.singular || solved.residual > kLargestResidual)
      return reject();
    const double most = kFastest * period;
    const bool continues =
        jump(state.pose, solved.pose, geometry.grip_radius) <= most * (ticks_since_valid + 1);
    // The same new place twice is no error: the grip has moved while no pose was valid.
    const bool confirmed =
        ticks_since_valid > 0 && jump(last_solved, solved.pose, geometry.grip_radius) <= most;
    last_solved = solved.pose;
    if (!continues && !confirmed)
      return reject();
    if (!continues)
      velocity_known = false;
    accept(solved.pose);
  }

  bool exchange() noexcept {
    const bool answered = controller->exchange(words, counts);
    state.interrupted = controller->interrupted();
    if (!answered) {
      reject();
      return false;
    }
    update_lengths();
    update_pose();
    return true;
  }

  void calibrate() noexcept {
    home_counts = counts;
    update_lengths();
    state.pose = last_solved = {};
    velocity_known = false;
    ticks_since_valid = 0;
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
    Counts before = counts;
    int silent = 0;
    double still = 0;
    for (double time = 0; time < kLongestSettling && still < kSettleWindow; time += period) {
      if (!controller->exchange(words, counts)) {
        if (++silent >= kMostSilentTicks)
          fail(Cause::io, messages::kUsbSilent, controller->description().c_str());
      } else {
        silent = 0;
        still += period;
        if (moved_since(before)) {
          before = counts;
          still = 0;
        }
      }
      std::this_thread::sleep_for(std::chrono::duration<double>(period));
    }
  }

  void start() {
    if (controller->home(home_counts)) {
      exchange();
      // The first pose may be anywhere in the workspace; there is none before it to jump from.
      const PoseSolver::Result solved = pose_solver.solve(state.lengths, {});
      ticks_since_valid = 0;
      last_solved = solved.pose;
      if (!solved.singular)
        accept(solved.pose);
      return;
    }
    settle();
    calibrate();
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
  // Twice: a controller may lose one.
  implementation_->relax();
  implementation_->exchange();
  implementation_->exchange();
}

bool Device::exchange() noexcept {
  return implementation_->exchange();
}

void Device::command(const Wrench &wrench) noexcept {
  const bool finite = wrench.force.allFinite() && wrench.torque.allFinite();
  const TensionSolver::Result result = implementation_->tension_solver.solve(
      finite ? wrench : Wrench{}, implementation_->state.pose);
  implementation_->set_tensions(result.tensions);
  implementation_->state.feasible = result.feasible;
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

std::string Device::description() const {
  return implementation_->controller->description();
}

} // namespace spidar
