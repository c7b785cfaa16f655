// SPDX-License-Identifier: LGPL-2.1-or-later
// Reliefs of known shape, and hands that touch them through everything between the law and the
// motors. The clock is driven by hand.
#pragma once

#include "device-limits.hpp"
#include "safety/safety-chain.hpp"
#include "touch/contact-law.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <Eigen/Geometry>
#include <functional>
#include <numbers>

namespace test {

using haptic::ReliefField;
using haptic::ReliefSurface;
using spidar::Vector3;

inline const Vector3 kHalf(0.025, 0.025, 0.025); // m, workspace of the default geometry
constexpr int kCells = 64;
constexpr double kTick = 0.001; // s

using Shape = std::function<double(double, double)>; // m of m

// Every cell with the height of its centre.
inline ReliefField relief_of(const Shape &height, double stiffness = 200, double friction = 0,
                             int cells = kCells) {
  ReliefField relief;
  relief.frame_width = relief.frame_height = 640;
  relief.columns = relief.rows = static_cast<std::uint16_t>(cells);
  relief.interval = 33'333'333;
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells; ++column) {
      const double x = kHalf.x() * ((2 * column + 1.0) / cells - 1);
      const double y = kHalf.y() * (1 - (2 * row + 1.0) / cells);
      relief.cells.push_back({static_cast<float>(height(x, y)), static_cast<float>(stiffness),
                              static_cast<float>(friction), 1});
    }
  return relief;
}

inline Shape flat(double height = 0) {
  return [height](double, double) { return height; };
}

inline ReliefSurface surface_of(const ReliefField &relief) {
  return {relief, relief, 1, kHalf};
}

inline double degrees_between(const Vector3 &a, const Vector3 &b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

// A hand: its target pulls the grip with a spring and a damper.
struct HandModel {
  const char *name;
  double mass;      // kg
  double damping;   // N·s/m
  double stiffness; // N/m
  int swings;       // ms until it rests where it is led
  const spidar::DeviceLimits *device = &kSpidar;
  // N/m, of the surfaces: as stiff as the device holds, at a slew rate that follows them.
  double stiffest() const noexcept { return device->stiffest_spring(kTick); }
  double slew_rate() const noexcept { // N/s
    return stiffest() * haptic::ContactLaw::kFastestSurface;
  }
};
// A grip that lies on the surface (strings alone damp it), an arm that gives way, and the hand of
// the simulated device.
constexpr HandModel kLying{"lying", 0.1, 0.5, 20, 2500};
constexpr HandModel kLight{"light", 0.15, 2.5, 100, 500};
constexpr HandModel kStiff{"stiff", 0.4, 40, 1000, 500};
// The same with what the arm of test::kArm has more of mass and damping. It takes b / k longer to
// rest, and 16 µm are 0.05 N there.
constexpr HandModel kLyingOnArm{"lying_on_arm", 0.2, 7.5, 20, 3000, &kArm};
constexpr HandModel kLightOnArm{"light_on_arm", 0.25, 9.5, 100, 1000, &kArm};
constexpr HandModel kStiffOnArm{"stiff_on_arm", 0.5, 47, 1000, 500, &kArm};

// The loop of a hand that touches: encoder, low-pass of the speed, law, safety chain, and the tick
// that a command needs to the motors.
class TouchLoop {
public:
  TouchLoop(const HandModel &model, const Vector3 &start)
      : slew_rate(model.slew_rate()), model_(model), chain_(*model.device), position(start) {}

  void tick(const ReliefSurface &surface, const Vector3 &target) {
    const double count = model_.device->metres_per_count;
    constexpr double kVelocityTime = 1 / (2 * std::numbers::pi * 35);
    const Vector3 seen = (position / count).array().round() * count;
    seen_velocity_ +=
        (1 - std::exp(-kTick / kVelocityTime)) * ((seen - seen_before_) / kTick - seen_velocity_);
    haptic::SafetyChain::Input input;
    input.moved = seen - seen_before_;
    seen_before_ = seen;
    const Vector3 acting = force; // the exchange sends what the tick before has computed
    const haptic::Contact contact = law.step(
        surface, seen,
        {.device = *model_.device, .slew_rate = slew_rate, .energy = chain_.energy_of_hand()},
        kTick);
    surface_work += std::max(0.0, contact.surface_work);
    input.acted.force = acted_;
    acted_ = acting;
    input.touch = {.force = contact.force,
                   .surface_work = contact.surface_work,
                   .energy = contact.energy,
                   .released = contact.released};
    input.measured = true;
    input.trust = 1;
    input.interval = 1.0 / 30;
    input.max_force = 1;
    input.max_torque = 0.02;
    input.slew_rate = slew_rate;
    input.damping = 1;
    input.hand_velocity = seen_velocity_;
    input.dt = kTick;
    force = chain_.step(input).force;
    move(acting, target);
  }

  haptic::ContactLaw law;
  double slew_rate;                // N/s
  Vector3 force = Vector3::Zero(); // N, as commanded
  double work = 0;                 // J, of the force on the hand
  double surface_work = 0;         // J, that a level surface does by its own movement

private:
  void move(const Vector3 &acting, const Vector3 &target) {
    constexpr int kSteps = 4;
    for (int i = 0; i < kSteps; ++i) {
      const double dt = kTick / kSteps;
      const Vector3 pull = model_.stiffness * (target - position) - model_.damping * velocity;
      velocity += dt / model_.mass * (pull + acting);
      position += dt * velocity;
      work += dt * acting.dot(velocity);
    }
  }

  HandModel model_;
  haptic::SafetyChain chain_;
  Vector3 acted_ = Vector3::Zero(); // N, until this tick
  Vector3 seen_before_ = Vector3::Zero();
  Vector3 seen_velocity_ = Vector3::Zero();

public:
  Vector3 position;                   // m
  Vector3 velocity = Vector3::Zero(); // m/s
};

} // namespace test
