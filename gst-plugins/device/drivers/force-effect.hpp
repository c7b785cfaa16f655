// SPDX-License-Identifier: LGPL-2.1-or-later
// From a force to the effect that Linux drivers of joysticks and wheels play.
#pragma once

#include "samples/force-defaults.hpp"

#include <cstdint>
#include <linux/input.h>
#include <spidar/types.hpp>

namespace haptic {

/// The kind of force that a device can exert.
enum class ForceKind { constant, rumble };

/// No joystick reports its strength: the highest `max-force` is its full level, N. With the default
/// of 1 N a wheel uses a fifth of its strength.
inline constexpr double kFullForce = kHighestForce;

/// Duration of an effect, ms: the longest time that a force outlives a program that stands still.
inline constexpr std::uint16_t kEffectLength = 100;

/// Returns the effect for the part of the force in the plane of the frame (N, x to the right, y
/// up); without a y axis only for its x. A force that is not finite counts as zero. `id` is the
/// driver's, -1 for a new effect. Rumble has no direction.
ff_effect force_effect(const spidar::Vector3 &force, ForceKind kind, bool has_y,
                       std::int16_t id) noexcept;

/// Returns whether its level is zero.
bool is_silent(const ff_effect &effect) noexcept;

/// Returns whether the two differ by less than can be felt.
bool feels_alike(const ff_effect &a, const ff_effect &b) noexcept;

} // namespace haptic
