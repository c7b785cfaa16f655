// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/average-types.hpp"

#include "velocity/velocity-estimate.hpp"

namespace haptic {

GType average_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(Average::model), "A motion model fitted to the points, at the pointer",
       "model"},
      {static_cast<int>(Average::mean), "The mean of the points' velocities", "mean"},
      {static_cast<int>(Average::median), "The median of each component", "median"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstVelocityAvgAverage", values);
  return type;
}

GType motion_model_type() {
  static const GEnumValue values[] = {
      {static_cast<int>(ModelChoice::automatic), "The smallest that explains the points", "auto"},
      {static_cast<int>(ModelChoice::still), "Nothing moves", "static"},
      {static_cast<int>(ModelChoice::translation), "All points move alike", "translation"},
      {static_cast<int>(ModelChoice::similarity), "Points also turn and grow about the pointer",
       "similarity"},
      {static_cast<int>(ModelChoice::affine), "Points also shear and stretch", "affine"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstVelocityAvgMotionModel", values);
  return type;
}

} // namespace haptic
