// SPDX-License-Identifier: LGPL-2.1-or-later
// Draws the measurement over a frame: region, patches, velocity and force; what is touched; and the
// thing that is held.
#pragma once

#include "haptic-patch.h"
#include "overlay/held-trail.hpp"
#include "pixels/luma-view.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

using cairo_t = struct _cairo; // NOLINT(bugprone-reserved-identifier)

namespace haptic {

enum class OverlayStyle {
  none,
  arrows, ///< region, velocity and force; and the thing that is held
  full,   ///< these, the patches, and a label
};

struct OverlayLook {
  OverlayStyle style = OverlayStyle::full;
  std::uint32_t velocity_color = 0xffe69f00; ///< ARGB, orange
  std::uint32_t force_color = 0xff0072b2;    ///< ARGB, blue
  std::uint32_t hold_color = 0xff009e73;     ///< ARGB, green; all of Okabe and Ito
  double scale = 0.5;                        ///< s of motion that an arrow is long
};

/// Coordinates are px of the frame, y down.
struct OverlayScene {
  int frame_width = 0;
  int frame_height = 0;
  double pixel_aspect = 1; ///< width of a pixel over its height
  double region_x = 0, region_y = 0, region_width = 0, region_height = 0;
  double pointer_x = 0, pointer_y = 0;   ///< or where the held thing is: arrows begin there
  double velocity_x = 0, velocity_y = 0; ///< px/s
  double confidence = 0;                 ///< 0..1; 0: nothing was measured, draw the rest
  std::string label;
  std::span<const GstHapticPatch> patches;
  double interval = 0;                        ///< s of the patches' motion; 0: none
  std::optional<std::array<double, 2>> force; ///< N, x to the right, y up
  std::optional<std::array<double, 2>> proxy; ///< px, where a relief holds the hand
  bool touches = false;                       ///< the hand is beneath the relief
  HeldPlace held;                             ///< in fractions of the frame
  std::span<const HeldTrail::Point> trail;    ///< of the held thing
};

class OverlayDrawing {
public:
  /// Copies the parts of the scene that it draws.
  OverlayDrawing(const OverlayScene &scene, const OverlayLook &look);

  /// The part of the frame that is drawn on; empty (width 0): none.
  const Rectangle &extent() const { return extent_; }

  /// Paints pixels of the extent, which must be zero: 32 bits each, ARGB in the byte order of the
  /// machine, premultiplied.
  void paint(std::uint8_t *pixels, int stride) const;

private:
  // Square units: px of the frame's height, so that circles stay round on the screen.
  struct Point {
    double x, y;
  };
  struct Box {
    double x, y, width, height;
  };
  struct Arrow {
    Point from, to;
  };
  struct Label {
    std::string text;
    Box box;
    Point baseline;
  };
  enum class Side { below, above };
  struct TrailPoint {
    Point place;
    bool joined;
  };
  struct Held {
    Point centre;
    double radius; // 0: the place is not known
    bool dashed;
    std::vector<TrailPoint> trail;
    std::optional<Label> word;
  };

  void place_measurement(const OverlayScene &scene);
  Point square(double x, double y) const { return {x * aspect_, y}; }
  std::optional<Arrow> arrow(Point from, double dx, double dy) const;
  static Arrow aside(const Arrow &arrow, double distance);
  void place_held(const OverlayScene &scene);
  std::optional<Label> label(const std::string &text, const Box &about, Side side) const;
  void find_extent();
  void paint_measurement(cairo_t *cairo) const;
  void paint_proxy(cairo_t *cairo) const;
  void paint_held(cairo_t *cairo) const;
  void paint_label(cairo_t *cairo, const Label &label) const;

  double aspect_;
  double width_, height_; // of the frame
  double line_;           // width of the lines
  double text_;           // size of the text
  double opacity_;
  OverlayLook look_;
  std::optional<Box> region_; // nothing: nothing was measured
  std::vector<Arrow> patches_;
  std::optional<Arrow> velocity_, force_;
  std::optional<Point> proxy_;
  bool touches_ = false;
  std::optional<Label> label_;
  std::optional<Held> held_;
  Rectangle extent_;
};

} // namespace haptic
