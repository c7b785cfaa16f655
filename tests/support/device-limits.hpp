// SPDX-License-Identifier: LGPL-2.1-or-later
// Two devices whose limits differ in everything: what holds on both comes from no number of one.
#pragma once

#include <limits>
#include <spidar/device.hpp>

namespace test {

inline const spidar::DeviceLimits kSpidar =
    limits_of(spidar::load_geometry(spidar::kDefaultGeometry));

/// A simulated arm of three degrees of freedom (test::HandOnArm). Its joints have the damping that
/// a spring of 3000 N/m needs behind 2.5 ms.
inline const spidar::DeviceLimits kArm = {.force = 12,
                                          .torque = 0,
                                          .rate = 4000,
                                          .degrees_of_freedom = 3,
                                          .metres_per_count = 5e-6,
                                          .flicker_way = 5e-6, // of one joint
                                          .stiffness = 3000,
                                          .physical_damping = 7.5,
                                          .damping = 5,
                                          .mass = 0.2,
                                          .flicker = 2e-5, // k counts² as on the SPIDAR-G
                                          .grip_is_free = true,
                                          .let_go_speed = 1.2};

} // namespace test
