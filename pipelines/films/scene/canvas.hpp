// SPDX-License-Identifier: LGPL-2.1-or-later
// A frame that is painted with textures, and the true motion of what its pixels show.
#pragma once

#include "samples/motion-field.hpp"

#include <cmath>
#include <compare>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace film {

struct Point {
  float x = 0; // px, to the right
  float y = 0; // px, down

  Point operator+(const Point &other) const { return {x + other.x, y + other.y}; }
  Point operator-(const Point &other) const { return {x - other.x, y - other.y}; }
  Point operator*(float factor) const { return {x * factor, y * factor}; }
};

inline float length(const Point &point) {
  return std::hypot(point.x, point.y);
}

/// x' = xx·x + xy·y + x0, y' = yx·x + yy·y + y0.
struct Affine {
  float xx = 1, xy = 0, yx = 0, yy = 1;
  float x0 = 0, y0 = 0;

  Point operator()(const Point &p) const {
    return {xx * p.x + xy * p.y + x0, yx * p.x + yy * p.y + y0};
  }
  /// First `inner`, then this.
  Affine operator*(const Affine &inner) const;
  Affine inverse() const;
  /// Turns about `centre`, positive from x to y.
  static Affine rotation(const Point &centre, float radians);
};

/// Where a thing is in this frame and where it was in the frame before.
struct Pose {
  Affine now;
  Affine before;

  Pose operator*(const Pose &inner) const { return {now * inner.now, before * inner.before}; }
};

/// Premultiplied 8-bit blue, red, green and alpha in lanes of 16 bits: one multiplication weighs
/// all four.
using Pixel = std::uint64_t;

constexpr Pixel kLanes = 0x00ff00ff00ff00ff;

/// From and to cairo's ARGB32.
constexpr Pixel unpack(std::uint32_t argb) {
  return (argb & 0x00ff00ffU) | (static_cast<Pixel>(argb & 0xff00ff00U) << 24);
}
constexpr std::uint32_t pack(Pixel pixel) {
  return static_cast<std::uint32_t>(pixel) | static_cast<std::uint32_t>(pixel >> 24);
}

struct Texture {
  int width = 0;
  int height = 0;
  std::vector<Pixel> pixels;

  const Pixel *row(int y) const { return &pixels[static_cast<std::size_t>(y) * width]; }
};

/// Displacement since the frame before, in 1/512 px.
struct Motion {
  std::int16_t x = 0;
  std::int16_t y = 0;
};

constexpr float kMotionUnits = 512;

/// Of px; far away motions are limited.
Motion to_motion(float x, float y);

/// What a thing is that points are chosen on; everything else is `other`.
enum class Kind : std::uint8_t { other, crown_leaf, branch, grass, blade, flag };

/// A thing that moves, and which part of it is drawn: each part has texels of its own.
struct Thing {
  Kind kind = Kind::other;
  std::uint32_t number = 0; // of the things of this kind
  std::uint32_t part = 0;
  auto operator<=>(const Thing &) const = default;
};

/// A point of a thing: it stays where it is on the thing.
struct MaterialPoint {
  Thing thing;
  Point texel; // of a span: x is the share of its width, y is 0; of a row: y is 0
};

/// How far the blades of one row lean: the thing at texel u is seen at u − offset + share · now[x].
struct Lean {
  std::span<const float> now;    // px, for each x
  std::span<const float> before; // in the frame before
  float share;
  float offset; // texels
};

/// One frame. It is painted from the front to the back: each draw function adds what earlier ones
/// left free. Covered pixels cost next to nothing. The motion of a pixel is that of the thing that
/// makes it more than half covered.
class Canvas {
public:
  Canvas(int width, int height);

  /// From the next frame on, points() says where these are, and material() what is seen.
  void follow(std::vector<MaterialPoint> points);

  /// Begins a new frame.
  void clear();

  int width() const { return width_; }
  int height() const { return height_; }
  const Motion &motion(int x, int y) const {
    return motions_[static_cast<std::size_t>(y) * width_ + x];
  }

  /// What the pixel shows; after follow().
  const MaterialPoint &material(int x, int y) const {
    return materials_[static_cast<std::size_t>(y) * width_ + x];
  }
  /// Where each point of follow() is, px from the centre of the top left pixel. Points that were
  /// not drawn are far away.
  const std::vector<Point> &points() const { return points_; }

  /// The pose maps texels to px.
  void draw(const Texture &texture, const Pose &pose, const Thing &thing = {});

  /// The same, only within the triangle of these corners (texels).
  void draw_triangle(const Texture &texture, const Pose &pose, const Point &a, const Point &b,
                     const Point &c, int gain, const Thing &thing);

  /// One row of a thing that leans. `gain` (256: unchanged) multiplies the colours.
  void draw_row(const Pixel *texels, int length, int y, const Lean &lean,
                std::span<const std::uint16_t> gain, const Thing &thing = {});

  /// A band from x to x + width of one row, in one colour.
  void draw_span(int y, float x, float width, Pixel colour, Motion motion, const Thing &thing);

  /// Mean displacement of the pixels of this box since the frame before, in px. `kept(motion)`
  /// says which pixels count; at least one does.
  template <typename Kept>
  Point mean_motion(int left, int top, int right, int bottom, Kept &&kept) const {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::int64_t count = 0;
    for (int j = top; j < bottom; ++j)
      for (int i = left; i < right; ++i)
        if (const Motion &here = motion(i, j); kept(here)) {
          x += here.x;
          y += here.y;
          ++count;
        }
    const double scale = 1 / (static_cast<double>(kMotionUnits) * static_cast<double>(count));
    return {static_cast<float>(static_cast<double>(x) * scale),
            static_cast<float>(static_cast<double>(y) * scale)};
  }
  Point mean_motion(int left, int top, int right, int bottom) const {
    return mean_motion(left, top, right, bottom, [](const Motion &) { return true; });
  }

  /// Mean motion of each cell's pixels, in px/s; `interval` in ns.
  void field_of(std::uint64_t interval, haptic::MotionField &field) const;

  /// Planar 4:2:0, BT.709, limited range. Width and height are even.
  void write_i420(std::span<std::uint8_t> bytes) const;

  /// Returns whether the file could be written.
  bool write_png(const std::string &path);

private:
  std::uint32_t *row(int y) { return &pixels_[static_cast<std::size_t>(y) * width_]; }
  Motion *motion_row(int y) { return &motions_[static_cast<std::size_t>(y) * width_]; }
  template <typename Keep>
  void paint(const Texture &texture, const Pose &pose, const Thing &thing, int top, int bottom,
             int gain, Keep &&keep);
  // Says where the followed points of this thing are: at place(texel).
  template <typename Place>
  void place_points(const Thing &thing, Place &&place);
  void show(int x, int y, const Thing &thing, const Point &texel) {
    if (!materials_.empty())
      materials_[static_cast<std::size_t>(y) * width_ + x] = {thing, texel};
  }

  int width_;
  int height_;
  std::vector<std::uint32_t> pixels_; // ARGB32
  std::vector<Motion> motions_;
  std::vector<MaterialPoint> materials_;                         // empty if nothing is followed
  std::multimap<Thing, std::pair<std::size_t, Point>> followed_; // index and texel
  std::vector<Point> points_;
};

/// What is seen of `under` below `over`, and `over`.
constexpr Pixel add_below(Pixel over, Pixel under) {
  const Pixel alpha = over >> 48;
  return over + (((under * (256 - alpha - (alpha >> 7))) >> 8) & kLanes);
}

/// Multiplies the colours by gain / 256; no colour may exceed 255.
constexpr Pixel brighten(Pixel pixel, unsigned gain) {
  constexpr Pixel kColours = 0x000000ff00ff00ff;
  return ((((pixel & kColours) * gain) >> 8) & kColours) | (pixel & ~kColours);
}

} // namespace film
