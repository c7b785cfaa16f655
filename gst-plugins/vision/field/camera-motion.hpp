// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of the background of a frame, as the camera makes it, from a motion field.
#pragma once

#include "samples/motion-field.hpp"

#include <array>
#include <span>

namespace haptic {

/// v = translation + gradient · (place − centre of the frame).
struct CameraMotion {
  /// `none`: the frame has no background, `still`: the camera stands. All else is 0 then.
  MotionModel model = MotionModel::none;
  double x = 0; ///< px/s, at the centre of the frame
  double y = 0; ///< px/s
  /// 1/s: ∂vx/∂x, ∂vx/∂y, ∂vy/∂x, ∂vy/∂y
  std::array<double, 4> gradient = {};
};

/// Of the cells with a confidence of 0.5, a quarter that rests or moves alike, spread over the
/// frame, is the background (Fischler and Bolles, CACM 24(6), 1981; the random numbers are the same
/// at each call). Returns rest, or the smallest of translation, similarity and affine that explains
/// clearly more cells; affine only if half of the cells agree. `cells` has the cells of `shape`;
/// `interval` in s between the two frames, > 0. Sizes in px.
CameraMotion find_camera_motion(std::span<const FieldCell> cells, const FieldShape &shape,
                                double width, double height, double interval);

/// Subtracts the motion from each cell that moves. One at rest on the screen, as a caption or a
/// smooth sky, stays at rest.
void subtract(const CameraMotion &camera, std::span<FieldCell> cells, const FieldShape &shape,
              double width, double height);

} // namespace haptic
