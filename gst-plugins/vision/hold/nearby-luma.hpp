// SPDX-License-Identifier: LGPL-2.1-or-later
// The luma about a place in a frame, reduced, on three layers.
#pragma once

#include "hold/patch-kernels.hpp"
#include "pixels/frame-reduction.hpp"
#include "pixels/image-kernels.hpp"
#include "pixels/kept-luma.hpp"

#include <array>

namespace haptic {

inline constexpr int kHoldLayers = 3; ///< spacings of 1, 2 and 4 reduced pixels

/// A part of one layer, smoothed. Lengths are reduced pixels of the frame; pixel i covers i..i+1.
struct LumaLayer {
  Plane plane;
  float x = 0;    ///< left edge of the first column
  float y = 0;    ///< upper edge of the first row
  float unit = 1; ///< side of a pixel of the plane

  /// Index of a pixel of the plane whose middle lies there.
  float column(float at) const { return (at - x) / unit - 0.5F; }
  float row(float at) const { return (at - y) / unit - 0.5F; }

  /// Whether it reaches so many of its pixels about a place.
  bool reaches(float at_x, float at_y, int radius) const;

  /// Samples a patch with the spacing of the layer. Returns false, and leaves the samples, if one
  /// of them is outside the plane.
  bool sample(const PatchPose &pose, PatchSamples &samples) const;
};

/// Not thread-safe. Keeps its memory unless it has to grow.
class NearbyLuma {
public:
  /// How often frames so large are halved: down to 960 px in width, where a hold is nearly as exact
  /// as in larger ones, at a quarter of the cost. At least one row is left.
  static int halvings(int frame_width, int frame_height);

  /// Reads the square of `reach` reduced pixels about a place. Pixels outside the frame are those
  /// of its border. `frame` must stay until the next call.
  void read(const LumaSource &frame, int frame_width, int frame_height, int halvings, float x,
            float y, int reach);

  /// The part of a layer about a place. It reaches `radius` of its pixels, or less where the square
  /// that was read ends; one that is there already and reaches `least` is kept. Valid until the
  /// same layer is asked for again.
  const LumaLayer &layer(int index, float x, float y, int radius, int least);

private:
  KeptLuma frame_luma_;
  FrameReduction reduction_;
  FrameReduction layer_reduction_;
  ByteImage padded_;
  LumaView view_; // reduced
  int left_ = 0;  // of the view, reduced pixels of the frame
  int top_ = 0;
  std::array<LumaLayer, kHoldLayers> layers_; // empty planes: not of this frame
};

} // namespace haptic
