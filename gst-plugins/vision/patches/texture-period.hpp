// SPDX-License-Identifier: LGPL-2.1-or-later
// Textures that repeat. One of a single spatial frequency looks the same one period further, so two
// frames alone do not show which of several displacements is the true one.
#pragma once

#include "patches/block-translation.hpp"

namespace haptic {

/// The period of the texture in px, at most `longest`, or 0 if it does not repeat.
float texture_period(const Plane &earlier, std::span<const Template> blocks, float longest);

/// Where the texture repeats, replaces the translation by the one nearest to `last`, the
/// displacement between the two frames before (zero at first: slow motion is likelier than fast).
/// Returns false if that one is too far from `last` to be certain.
bool resolve_period(const Plane &earlier, const Plane &later, std::span<const Template> blocks,
                    float longest, Displacement last, float noise, Translation &whole);

} // namespace haptic
