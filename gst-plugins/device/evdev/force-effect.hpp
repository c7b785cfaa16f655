// SPDX-License-Identifier: LGPL-2.1-or-later
// From a force to the effect that Linux drivers of joysticks and wheels know.
#pragma once

#include <cstdint>
#include <linux/input.h>
#include <spidar/types.hpp>

namespace haptic {

/// What a device can do of what is needed.
enum class ForceKind { constant, rumble };

/// No joystick tells how strong it is: this force is its full one, N. With hapticsink's default of
/// 1 N a strong wheel so uses a fifth of what it has.
inline constexpr double kFullForce = 5;

/// How long the driver plays an effect unless told to go on, ms: the longest that a force outlives
/// a program that stands still.
inline constexpr std::uint16_t kEffectLength = 100;

/// The effect for the part of the force in the plane of the frame (N, x to the right, y up);
/// without a y axis only for its x. A force that is not finite is none. `id` is the driver's, -1
/// for a new effect. Rumble has no direction.
ff_effect force_effect(const spidar::Vector3 &force, ForceKind kind, bool has_y,
                       std::int16_t id) noexcept;

/// Whether it can be felt.
bool is_silent(const ff_effect &effect) noexcept;

/// Whether telling the driver would change nothing that can be felt.
bool feels_alike(const ff_effect &a, const ff_effect &b) noexcept;

} // namespace haptic
