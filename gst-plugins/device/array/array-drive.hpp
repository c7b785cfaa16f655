// SPDX-License-Identifier: LGPL-2.1-or-later
// From the motion in a film to the amplitude of each actuator.
#pragma once

#include "array/array-mapping.hpp"
#include "motion/motion-conditioning.hpp"
#include "samples/force-defaults.hpp"
#include "samples/motion-field.hpp"
#include "samples/pointer-position.hpp"

#include <span>
#include <vector>

namespace haptic {

enum class MapChoice {
  stroke, ///< the motion at the pointer runs across the array in its direction
  field,  ///< each actuator vibrates with the motion at its place of the frame
  point,  ///< the motion at the pointer is felt at the pointer's place on the array
};

struct DriveSettings {
  MapChoice map = MapChoice::stroke;
  double alpha = kDefaultAlpha; ///< s/px, in a frame kReferenceWidth wide
  PointerPosition pointer;      ///< in a field; a sample has its own
};

/// Amplitudes are 0..1: the force of the paper's law as a share of its maximum, times the gate of
/// the confidence. The box about the actuators is the frame. One thread.
class ArrayDrive {
public:
  explicit ArrayDrive(const ArrayLayout &layout);
  ArrayDrive(const ArrayDrive &) = delete; // stroke_ refers to map_
  ArrayDrive &operator=(const ArrayDrive &) = delete;

  /// The motion from now on.
  void follow(const MotionSample &sample, const DriveSettings &settings);
  void follow(const MotionField &field, const DriveSettings &settings);
  /// Nothing is felt from now on.
  void rest();

  /// Sets the amplitude of each actuator, `dt` s after the call before.
  void step(double dt, const DriveSettings &settings, std::span<double> amplitudes);

private:
  // The motion at one place: the pointer's, or an actuator's.
  struct Site {
    Motion motion;
    double gate = 0; // 0..1
    MotionConditioner conditioner;

    double amplitude(double alpha, double dt);
  };

  static void set(Site &site, const MotionSample &sample);
  PointerPosition place_in_frame(const SkinPlace &place) const;
  SkinPlace place_on_skin(double x, double y) const;

  SkinMap map_;
  Stroke stroke_;
  Site pointer_;
  SkinPlace place_; // of the pointer, on the skin
  std::vector<Site> sites_;
};

} // namespace haptic
