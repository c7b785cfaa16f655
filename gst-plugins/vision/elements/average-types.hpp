// SPDX-License-Identifier: LGPL-2.1-or-later
// The enumerations of properties that choose how velocities become one.
#pragma once

#include "glue/property-table.hpp"
#include "velocity/velocity-estimate.hpp"

namespace haptic {

inline GType average_type() {
  static const GType type = register_enum<Average>(
      "GstVelocityAvgAverage",
      {{Average::model, "A motion model fitted to the points, at the pointer", "model"},
       {Average::pointed, "The same of the points that move with what the pointer points at",
        "pointed"},
       {Average::mean, "The mean of the points' velocities", "mean"},
       {Average::median, "The median of each component", "median"}});
  return type;
}

inline GType motion_model_type() {
  static const GType type = register_enum<ModelChoice>(
      "GstVelocityAvgMotionModel",
      {{ModelChoice::automatic, "The smallest that explains the points", "auto"},
       {ModelChoice::still, "Nothing moves", "static"},
       {ModelChoice::translation, "All points move alike", "translation"},
       {ModelChoice::similarity, "Points also turn and grow about the pointer", "similarity"},
       {ModelChoice::affine, "Points also shear and stretch", "affine"}});
  return type;
}

} // namespace haptic
