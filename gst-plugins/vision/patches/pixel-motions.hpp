// SPDX-License-Identifier: LGPL-2.1-or-later
// Motions fitted to the pixels that follow them: one where layers lie over one another (a
// reflection), two where things lie side by side. `noise` is the variance of a pixel, grey levels
// squared.
#pragma once

#include "patches/patch-grid.hpp"

#include <array>
#include <cstddef>

namespace haptic {

struct DominantMotion {
  Displacement displacement;
  float share = 1; ///< of the pixels, that it explains but for noise
};

/// The translation that most pixels of a region follow. `start` is about a pixel away. Pixels that
/// leave the plane do not count; if most do, the result is the start.
DominantMotion find_dominant_motion(const Plane &earlier, const Plane &later, const Area &region,
                                    Displacement start, float noise);

struct TwoMotions {
  Displacement first;
  Displacement second;
  float share = 0;       ///< of the pixels, that follow the second
  float unexplained = 1; ///< share of the pixels that follow neither
};

/// Which of two motions the pixels of a region follow.
class MotionLabels {
public:
  /// Fits both translations to the pixels that follow them, from about a pixel away.
  TwoMotions find(const Plane &earlier, const Plane &later, const Area &region, Displacement first,
                  Displacement second, float noise);

  /// Whether the pixel at a place in the plane, or the nearest one of the region, follows the
  /// second motion.
  bool follows_second(float x, float y) const;

  /// The mean squared residual about that pixel, of the motion that fits better.
  float energy(float x, float y) const;

  static constexpr int kLargestSide = 64; ///< px of a region; the rest of a larger one is left out

  static constexpr int kMargin = 24; ///< px; vectors run over the end of a row

  /// Pixels of the plane, the last ones excluded.
  struct Box {
    int left = 0;
    int top = 0;
    int right = 0;
    int bottom = 0;

    int width() const { return right - left; }
    int height() const { return bottom - top; }
    int stride() const { return width() + kMargin; } ///< of a row of its pixels in the sheets
  };
  using Pixels = std::array<float, std::size_t{kLargestSide + kMargin} * (kLargestSide + 8)>;

  struct Sheets {
    alignas(64) Pixels energies;              ///< squared residuals, of 4 px more on every side
    alignas(64) Pixels columns;               ///< their sums over a column of a box
    alignas(64) std::array<Pixels, 2> wide;   ///< means over a wide box, of both motions
    alignas(64) std::array<Pixels, 2> narrow; ///< over a narrow one
  };

private:
  std::size_t place_of(float x, float y) const;

  Box box_;
  Sheets sheets_;
};

} // namespace haptic
