// SPDX-License-Identifier: LGPL-2.1-or-later
// The state of the force in words and as a light.
#pragma once

#include "player/player.hpp"

#include <array>
#include <cairo.h>
#include <string>
#include <string_view>

namespace program {

enum class Light { off, waiting, on, fault };

/// `armed`: of the device; in the states open and closed the session does not say it.
Light light_of(const Session &session, bool armed);

/// Returns whether there is a force, why not, and what brings it back.
std::string session_sentence(const Session &session, bool armed);

/// Knows what makes the force smaller.
class LimitWatch {
public:
  /// Returns what did in most ticks since the call before, in words; empty if nothing did.
  /// `statistics`: of hapticsink; may be null.
  std::string update(const GstStructure *statistics);

private:
  static constexpr std::size_t kLimits = 8;
  struct Ticks {
    guint64 all = 0;
    std::array<guint64, kLimits> limited{};
  };
  Ticks before_;
};

/// Draws the light into a square of `size`: each has a shape of its own beside its colour.
void draw_light(cairo_t *cairo, double size, Light light);

} // namespace program
