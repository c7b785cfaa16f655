// SPDX-License-Identifier: LGPL-2.1-or-later
// Leaves with veins, in every light from deep shadow to the sun shining through them.
#pragma once

#include "drawing.hpp"

#include <vector>

namespace film {

/// The point where the stem holds the leaf, as shares of width and height; the tip is on the right.
inline constexpr Point kLeafBase{0.06F, 0.5F};

class LeafTextures {
public:
  /// `length` of a leaf in px.
  explicit LeafTextures(float length);

  /// `light` 0..1; `kind` 0 … kKinds − 1.
  const Texture &leaf(int kind, float light) const;
  /// A dark mass of leaves seen deep in the crown, as wide as ten leaves.
  const Texture &mass(int kind) const { return masses_[static_cast<std::size_t>(kind)]; }

  static constexpr int kKinds = 5;

private:
  static constexpr int kLights = 28;

  std::vector<Texture> leaves_;
  std::vector<Texture> masses_;
};

} // namespace film
