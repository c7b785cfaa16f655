// SPDX-License-Identifier: LGPL-2.1-or-later
// How much of a region each patch stands for, where the patches disagree.
#pragma once

#include "patches/patch-grid.hpp"

#include <array>
#include <cstddef>

namespace haptic {

/// Each patch votes for the pixels around it.
class PixelVotes {
public:
  /// Sets `share` of the patches, which are in pixels of the finest plane like `region`. The planes
  /// are `level` halvings of it. `noise`: variance of a pixel, grey levels squared. All shares are
  /// 0 if the pixels do not decide. Where layers lie over one another (a reflection), the patches
  /// of the commonest displacement share the whole region. Returns the share of the pixels that no
  /// patch explains.
  float count(const Plane &earlier, const Plane &later, int level, const Area &region, float noise,
              std::span<Patch> patches);

  static constexpr int kSide = 16;        ///< px that a patch votes for, along each axis
  static constexpr int kLargestSide = 64; ///< px of a region; the rest of a larger one has no vote

  /// Of the region, or a part of it: px of the planes.
  struct Box {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    /// px of whole vectors.
    int padded_width() const { return (width + 7) / 8 * 8; }
  };

  /// The window of a patch.
  struct Ballot {
    Box window; ///< cut at the region, relative to it
    Displacement centre;
    Displacement displacement;
    float offset = 0; ///< grey levels
    float weight = 0;
    std::size_t layer = 0;
  };

  /// Patches of one displacement, which vote together.
  struct Layer {
    Box box; ///< of all windows, relative to the region
    Displacement displacement;
    float offset = 0; ///< grey levels
    float weight = 0;
    float members = 0;
    std::size_t first = 0; ///< of `ratios`
  };

  /// Room for vectors that run over the end of a row.
  static constexpr int kStride = kLargestSide + kSide;
  using Pixels = std::array<float, std::size_t{kStride} * (kLargestSide + 8)>;

  /// Pixels that the windows hold.
  struct Counts {
    int pixels = 0;
    int unclear = 0;
    int unexplained = 0;
  };

  struct Sheets {
    std::array<Ballot, kMaxPatches> ballots;
    std::array<Layer, kMaxPatches> layers;
    std::size_t patches = 0;
    std::size_t used_layers = 0;
    /// (E0 / (E0 + E))^3 for the pixels of each layer.
    alignas(64) std::array<float, std::size_t{kMaxPatches} * kSide * kSide + kSide> ratios;
    alignas(64) Pixels totals;   ///< weights of all patches
    alignas(64) Pixels least;    ///< residual energy of the best layer
    alignas(64) Pixels windows;  ///< of the patches of a layer
    alignas(64) Pixels energies; ///< of five pixels one below the other
  };

private:
  void fill_in(const Plane &earlier, const Plane &later, float scale, const Box &box,
               std::span<const Patch> patches);
  void join(std::size_t patch);

  Sheets sheets_;
};

} // namespace haptic
