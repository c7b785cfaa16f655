// SPDX-License-Identifier: LGPL-2.1-or-later
// What a touch does to the pixels of a frame of any drawn format: the dent under the hand, and the
// shading of a relief.
#pragma once

#include "samples/relief-field.hpp"

#include <cstdint>
#include <gst/video/video.h>
#include <vector>

namespace haptic {

/// Radius of a dent, part of the frame's height.
inline constexpr double kDentRadius = 1.0 / 6;
/// The most that a dent pulls, part of its radius. Beyond 0.35 it would fold the picture.
inline constexpr double kDeepestDent = 0.25;

/// A picture pulled towards a point. A pixel at the distance r shows what was at r + p(r):
/// p = pull * 3.5 t (1 - t²)², t = r / radius. The most, `pull`, is at t = 0.447; slope and value
/// are zero at the radius.
struct Dent {
  double x = 0, y = 0; ///< px of the frame, its middle
  double pull = 0;     ///< px of the frame's height, 0..kDeepestDent * radius; 0: none
  double radius = 0;   ///< px of the frame's height
};

/// The dent of a touch: `deform` in px of pull per mm of depth, `depth` in m. Numbers that are not
/// finite give none.
Dent dent_at(double x, double y, double depth, double deform, int frame_height);

/// One thread. Allocates for the first frame, and for larger ones.
class DentPainter {
public:
  /// Changes the frame, of one of HAPTIC_DRAWN_FORMATS. Pixels outside the radius stay as they are.
  void paint(const Dent &dent, GstVideoFrame &frame);

private:
  void paint_component(const Dent &dent, GstVideoFrame &frame, guint component);

  std::vector<std::uint8_t> before_; // the samples about the dent
};

/// Light on a relief from the top left. One thread; allocates for the first relief, and for larger
/// ones.
class ReliefShading {
public:
  /// A frame is taken to be this high, m, so that heights become slopes.
  static constexpr double kFrameHeight = 0.1;

  /// `strength` 0..1. A level surface stays as it is; the brightness of a slope changes at most by
  /// this part.
  void read(const ReliefField &relief, double strength);
  /// Changes the brightness of the frame, of one of HAPTIC_DRAWN_FORMATS. Pixels of cells without a
  /// surface stay as they are.
  void paint(GstVideoFrame &frame);

private:
  bool find_gains(int row, int width, int height);

  int columns_ = 0;
  int rows_ = 0;
  std::vector<float> light_;         // of each cell, -1..1 times the strength
  std::vector<std::uint8_t> holes_;  // of each cell
  std::vector<float> row_;           // of the cells at one row of pixels
  std::vector<std::int16_t> gains_;  // of the pixels of one row, 256 is 1
  std::vector<std::int16_t> spread_; // of its bytes
};

} // namespace haptic
