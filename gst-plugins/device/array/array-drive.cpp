// SPDX-License-Identifier: LGPL-2.1-or-later
#include "array/array-drive.hpp"

#include "samples/field-sampler.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {

ArrayDrive::ArrayDrive(const ArrayLayout &layout)
    : map_(layout), stroke_(map_), place_(place_on_skin(0.5, 0.5)),
      sites_(layout.actuators.size()) {}

double ArrayDrive::Site::amplitude(double alpha, double dt) {
  const PlanarVelocity &v = conditioner.step(motion, 0, dt).velocity;
  const double speed = std::hypot(v.x, v.y);
  return gate * arctan_gain(speed, alpha, 1) * speed;
}

void ArrayDrive::set(Site &site, const MotionSample &sample) {
  site.gate = is_plausible(sample) ? confidence_gate(sample.confidence) : 0;
  if (is_plausible(sample)) // the noise beside a speed is not felt
    site.motion = scale_motion(sample, kReferenceWidth);
}

PointerPosition ArrayDrive::place_in_frame(const SkinPlace &place) const {
  // All actuators of a line are in the middle of the frame.
  const Eigen::Array2d size = (map_.highest() - map_.lowest()).array();
  const Eigen::Array2d from = (place - map_.lowest()).array();
  const Eigen::Array2d share = (size > 0).select(from / size.max(1e-9), 0.5);
  return {.x = share.x(), .y = 1 - share.y()};
}

SkinPlace ArrayDrive::place_on_skin(double x, double y) const {
  return map_.lowest() + (map_.highest() - map_.lowest()).cwiseProduct(SkinPlace(x, 1 - y));
}

void ArrayDrive::follow(const MotionSample &sample, const DriveSettings &) {
  rest();
  set(pointer_, sample);
  place_ = place_on_skin(sample.pointer_x, sample.pointer_y);
}

void ArrayDrive::follow(const MotionField &field, const DriveSettings &settings) {
  rest();
  set(pointer_, sample_field(field, settings.pointer));
  place_ = place_on_skin(settings.pointer.x, settings.pointer.y);
  if (settings.map != MapChoice::field)
    return;
  for (std::size_t i = 0; i < sites_.size(); ++i)
    set(sites_[i], sample_field(field, place_in_frame(map_.places()[i])));
}

void ArrayDrive::rest() {
  pointer_.gate = 0;
  for (Site &site : sites_)
    site.gate = 0;
}

void ArrayDrive::step(double dt, const DriveSettings &settings, std::span<double> amplitudes) {
  if (settings.map == MapChoice::field) {
    for (std::size_t i = 0; i < sites_.size(); ++i)
      amplitudes[i] = sites_[i].amplitude(settings.alpha, dt);
    return;
  }
  const double amplitude = pointer_.amplitude(settings.alpha, dt);
  if (settings.map == MapChoice::point) {
    map_.share_energy(place_, amplitudes);
  } else {
    // Leaves that swing by millimetres would hardly move on the skin: the stroke is as fast as the
    // motion is strong.
    const PlanarVelocity &v = pointer_.motion.velocity;
    const double speed = std::hypot(v.x, v.y);
    const double share = speed > 0 ? amplitude / speed : 0;
    stroke_.step(share * Eigen::Vector2d(v.x, -v.y), dt, amplitudes);
  }
  for (double &share : amplitudes)
    share = amplitude * std::sqrt(share); // the energy is the amplitude squared
}

} // namespace haptic
