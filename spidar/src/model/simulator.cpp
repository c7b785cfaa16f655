// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/simulator.hpp"

#include "fail.hpp"
#include "model/drive-scale.hpp"
#include "model/string-kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace spidar {

namespace {

// The grip is a cross of some centimetres; a hand adds its moving mass. Equal inertia about all
// axes, no gravity.
constexpr double kGripMass = 0.1;       // kg
constexpr double kGripInertia = 2e-5;   // kg m²
constexpr double kHandMass = 0.3;       // kg
constexpr double kHandInertia = 1.5e-4; // kg m²

// The hand: a spring to its target with critical damping.
constexpr double kHandStiffness = 1000; // N/m
constexpr double kHandTurning = 1.5;    // N·m/rad

// A string resists winding, so that a free grip comes to rest.
constexpr double kStringDamping = 0.5; // N·s/m

constexpr double kLongestTimeStep = 0.00025; // s
constexpr double kLongestGap = 1;            // s; more would take the next exchange too long
constexpr double kLargestTurn = 80 * std::numbers::pi / 180;

// Counters do not start at zero when the power comes on.
constexpr Counts kPowerOnCounts = {4711, -1234, 20011, -7, 815, -30000, 9973, 123};

} // namespace

struct Simulator::State {
  Geometry geometry;
  std::unique_ptr<HandScript> hand;
  double period;
  double time = 0;                   ///< s, since the first exchange
  double step_left = 0;              ///< s, that the next exchange advances
  std::optional<std::int64_t> clock; ///< ns, of the last set_time()
  bool started = false;
  double reach = 0; ///< m; the grip cannot get farther from the centre
  DacWords words{}; ///< at the motors
  Pose pose;
  Vector3 velocity = Vector3::Zero();
  Vector3 turning = Vector3::Zero(); ///< rad/s, workspace frame

  Counts counts(const StringLengths &lengths) const noexcept {
    Counts result;
    for (std::size_t i = 0; i < kStrings; ++i)
      result[i] = kPowerOnCounts[i] +
                  static_cast<std::int32_t>(std::lround(lengths[i] / geometry.metres_per_count[i]));
    return result;
  }

  Vector6 string_wrench() const noexcept {
    const StringKinematics strings = string_kinematics(geometry, pose);
    Vector6 motion;
    motion << velocity, turning;
    const Tensions shortening = strings.pull.transpose() * motion;
    Tensions tensions;
    for (std::size_t i = 0; i < kStrings; ++i)
      tensions[i] =
          std::max(0.0, tension_of_word(geometry, i, words[i]) - kStringDamping * shortening[i]);
    return strings.pull * tensions;
  }

  /// Semi-implicit Euler: stable, as the steps are short against the hand's 20 ms.
  void step(double dt, bool held, const Vector3 &target, const Vector3 &target_velocity) noexcept {
    Vector6 wrench = string_wrench();
    double mass = kGripMass;
    double inertia = kGripInertia;
    if (held) {
      mass += kHandMass;
      inertia += kHandInertia;
      wrench.head<3>() += kHandStiffness * (target - pose.position) +
                          2 * std::sqrt(kHandStiffness * mass) * (target_velocity - velocity);
      wrench.tail<3>() -= kHandTurning * rotation_vector(pose.rotation) +
                          2 * std::sqrt(kHandTurning * inertia) * turning;
    }
    velocity += dt / mass * wrench.head<3>();
    turning += dt / inertia * wrench.tail<3>();
    pose.position += dt * velocity;
    const Matrix3 rotation = turned(pose.rotation, dt * turning);
    if (Eigen::AngleAxisd(rotation).angle() < kLargestTurn)
      pose.rotation = rotation;
    else
      turning.setZero();
    const double distance = pose.position.norm();
    if (distance > reach) {
      pose.position *= reach / distance;
      velocity.setZero();
    }
  }

  void advance() noexcept {
    Vector3 from = Vector3::Zero();
    Vector3 to = Vector3::Zero();
    hand->target(time, geometry.workspace_half, from);
    const double elapsed = std::exchange(step_left, period);
    if (elapsed <= 0)
      return;
    time += elapsed;
    const bool held = hand->target(time, geometry.workspace_half, to);
    const int steps = std::max(1, static_cast<int>(std::ceil(elapsed / kLongestTimeStep - 1e-9)));
    for (int i = 1; i <= steps; ++i)
      step(elapsed / steps, held, from + (to - from) * i / steps, (to - from) / elapsed);
  }
};

Simulator::Simulator(const Geometry &geometry, std::unique_ptr<HandScript> hand, double period)
    : state_(std::make_unique<State>()) {
  check_geometry(geometry);
  if (!hand)
    fail(Cause::argument, messages::kNoHand);
  if (!(period >= 1e-5 && period <= 0.1))
    fail(Cause::argument, messages::kPeriod, "simulator");
  state_->geometry = geometry;
  state_->hand = std::move(hand);
  state_->period = period;
  state_->step_left = period;
  double nearest = geometry.motors[0].norm();
  for (const Vector3 &motor : geometry.motors)
    nearest = std::min(nearest, motor.norm());
  state_->reach = nearest / 2;
  Vector3 soon = Vector3::Zero();
  if (state_->hand->target(0, geometry.workspace_half, state_->pose.position) &&
      state_->hand->target(period, geometry.workspace_half, soon))
    state_->velocity = (soon - state_->pose.position) / period; // already under way
}

Simulator::~Simulator() = default;

void Simulator::set_time(std::int64_t now) noexcept {
  if (state_->clock)
    state_->step_left =
        std::clamp(static_cast<double>(now - *state_->clock) * 1e-9, 0.0, kLongestGap);
  state_->clock = now;
}

bool Simulator::exchange(const DacWords &words, Counts &counts) noexcept {
  if (state_->started)
    state_->advance();
  state_->started = true;
  state_->words = words;
  counts = state_->counts(string_kinematics(state_->geometry, state_->pose).lengths);
  return true;
}

bool Simulator::home(Counts &counts) const noexcept {
  counts = state_->counts(string_kinematics(state_->geometry, {}).lengths);
  return true;
}

std::string Simulator::description() const {
  return "simulated SPIDAR-G (" + state_->geometry.name + ")";
}

bool Simulator::pressed() const noexcept {
  return state_->hand->presses(state_->time);
}

std::uint16_t Simulator::inputs() const noexcept {
  const std::optional<GripButton> &button = state_->geometry.button;
  return button && pressed() == button->pressed ? static_cast<std::uint16_t>(1U << button->bit) : 0;
}

const Pose &Simulator::pose() const noexcept {
  return state_->pose;
}

} // namespace spidar
