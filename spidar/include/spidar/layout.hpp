// SPDX-License-Identifier: LGPL-2.1-or-later
// The layout of the public structs, which library and user must agree on. It must not depend on
// the user's compiler options; a program for which it does fails to compile here.
#pragma once

#include "spidar/geometry.hpp"
#include "spidar/haptic-device.hpp"
#include "spidar/limited-device.hpp"

#include <cstddef>

namespace spidar::layout {

/// Whether T has this size and is aligned as a double. Some 32-bit machines pad differently.
template <class T>
constexpr bool is(std::size_t size) {
  return sizeof(void *) < 8 || (sizeof(T) == size && alignof(T) == alignof(double));
}

static_assert(is<Vector3>(24));
static_assert(is<Matrix3>(72));
static_assert(is<StringLengths>(64));
static_assert(is<Tensions>(64));
static_assert(is<Pose>(96) && offsetof(Pose, position) == 0 && offsetof(Pose, rotation) == 24);
static_assert(is<Wrench>(48) && offsetof(Wrench, force) == 0 && offsetof(Wrench, torque) == 24);
static_assert(sizeof(Counts) == 32 && sizeof(DacWords) == 16);

static_assert(offsetof(DeviceState, pose) == 0);
static_assert(offsetof(DeviceState, velocity) == 96);
static_assert(offsetof(DeviceState, counts) == 120);
static_assert(offsetof(DeviceState, lengths) == 152);
static_assert(offsetof(DeviceState, tensions) == 216);
static_assert(offsetof(DeviceState, realised) == 280);
static_assert(offsetof(DeviceState, feasible) == 328);
static_assert(offsetof(DeviceState, valid) == 329);
static_assert(offsetof(DeviceState, interrupted) == 330);
static_assert(offsetof(DeviceState, slipping) == 331);
static_assert(offsetof(DeviceState, slipped) == 332);
static_assert(offsetof(DeviceState, angular_velocity) == 336);
static_assert(offsetof(DeviceState, pressed) == 360);
static_assert(offsetof(DeviceState, acted) == 368);
static_assert(offsetof(DeviceState, moved) == 416);
static_assert(offsetof(DeviceState, turned) == 440);
static_assert(offsetof(DeviceState, given_up) == 464);
static_assert(is<DeviceState>(512));

static_assert(is<ForceLimits>(40));
static_assert(offsetof(ForceLimits, force) == 0 && offsetof(ForceLimits, damping) == 32);
static_assert(is<DeviceLimits>(152));

// From its first number: the size of std::string before it depends on the standard library.
static_assert(offsetof(Geometry, attachments) - offsetof(Geometry, motors) == 192);
static_assert(offsetof(Geometry, metres_per_count) - offsetof(Geometry, motors) == 384);
static_assert(offsetof(Geometry, volts_per_newton) - offsetof(Geometry, motors) == 448);
static_assert(offsetof(Geometry, digits_per_volt) - offsetof(Geometry, motors) == 512);
static_assert(offsetof(Geometry, dac_limit) - offsetof(Geometry, motors) == 520);
static_assert(offsetof(Geometry, tension_min) - offsetof(Geometry, motors) == 528);
static_assert(offsetof(Geometry, tension_max) - offsetof(Geometry, motors) == 536);
static_assert(offsetof(Geometry, grip_radius) - offsetof(Geometry, motors) == 544);
static_assert(offsetof(Geometry, workspace_half) - offsetof(Geometry, motors) == 552);
static_assert(offsetof(Geometry, button) - offsetof(Geometry, motors) == 576);
static_assert(is<Geometry>(offsetof(Geometry, motors) + 592));

} // namespace spidar::layout
