// SPDX-License-Identifier: LGPL-2.1-or-later
// How much of a region each patch stands for, where the patches disagree.
#pragma once

#include "patch-grid.hpp"

#include <array>

namespace haptic {

/// Each patch votes for the pixels around it.
class PixelVotes {
public:
  /// Sets `share` of the patches, which are in pixels of the finest plane like `region`. The planes
  /// are `level` halvings of it. `noise`: variance of a pixel, grey levels squared. All shares are
  /// 0 if the pixels do not decide. Where layers lie over one another (a reflection), the patches
  /// of the commonest displacement share the whole region.
  void count(const Plane &earlier, const Plane &later, int level, const Area &region, float noise,
             std::span<Patch> patches);

  static constexpr int kSide = 16;        ///< px that a patch votes for, along each axis
  static constexpr int kLargestSide = 64; ///< px of a region; the rest of a larger one has no vote
  using Weights = std::array<float, std::size_t{kSide} * kSide>;

  /// The window of a patch, px of the planes.
  struct Ballot {
    int x = 0; ///< its first pixel
    int y = 0;
    Displacement displacement;
    std::array<float, kSide> across; ///< weight of a column
    std::array<float, kSide> down;   ///< weight of a row, and of the patch
  };

  /// Of pixels around a region: a window that reaches beyond it needs no clipping.
  static constexpr int kStride = kLargestSide + 2 * kSide;
  using Pixels = std::array<float, std::size_t{kStride} * kStride>;

private:
  struct Box {
    int x, y, width, height;
  };
  enum class Finding { unclear, apart, layers };

  static std::size_t pixel(int x, int y);
  static std::size_t used_pixels(const Box &box);
  std::size_t first_pixel(std::size_t patch, const Box &box) const;
  void vote(const Plane &earlier, const Plane &later, float scale, const Box &box, float noise,
            std::span<const Patch> patches);
  Finding judge(const Box &box, float limit);
  void share_out(const Box &box, std::span<Patch> patches) const;

  std::array<Ballot, kMaxPatches> ballots_;
  alignas(64) std::array<Weights, kMaxPatches> weights_;
  alignas(64) Pixels totals_;   // weights of all patches
  alignas(64) Pixels least_;    // residual energy of the best patch
  alignas(64) Pixels inverses_; // of the totals; 0 outside the region
};

} // namespace haptic
