// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/canvas.hpp"

#include <algorithm>
#include <cairo.h>
#include <cmath>

namespace film {

namespace {

// Both weights in 1/256.
Pixel bilinear(const Pixel *upper, const Pixel *lower, unsigned right, unsigned down) {
  const unsigned both = right * down >> 8;
  const Pixel sum = upper[0] * (256 - right - down + both) + upper[1] * (right - both) +
                    lower[0] * (down - both) + lower[1] * both;
  return (sum >> 8) & kLanes;
}

// Pixels from this alpha on are covered.
constexpr std::uint32_t kCovered = 250U << 24;

// Adds `under` to a pixel. Returns whether this is what makes it more than half covered.
[[gnu::always_inline]] inline bool add(std::uint32_t &pixel, Pixel under) {
  const std::uint32_t sum = pack(add_below(unpack(pixel), under));
  const bool decides = pixel < 0x80000000U && sum >= 0x80000000U;
  pixel = sum;
  return decides;
}

// Where the texel u is seen: x = u − offset + share·now[x], whose right side changes by less than x
// does. Beside the frame blades lean as at its edge.
float leaning_place(float u, const Lean &lean) {
  const auto last = static_cast<float>(lean.now.size() - 1);
  float x = u - lean.offset;
  for (int i = 0; i < 60; ++i) {
    const float inside = std::clamp(x, 0.0F, last);
    const auto left = static_cast<std::size_t>(std::min(inside, last - 1));
    const float now =
        std::lerp(lean.now[left], lean.now[left + 1], inside - static_cast<float>(left));
    x = u - lean.offset + lean.share * now;
  }
  return x;
}

// The px of a row for which start + step·x is in [0, limit].
struct Limits {
  Limits(float step, float limit)
      : limit_(limit), reciprocal_(1 / (std::abs(step) < 1e-6F ? 1e-6F : step)) {}

  void narrow(float start, float &low, float &high) const {
    const float a = -start * reciprocal_;
    const float b = (limit_ - start) * reciprocal_;
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }

private:
  float limit_;
  float reciprocal_;
};

} // namespace

Motion to_motion(float x, float y) {
  const auto limited = [](float value) {
    return static_cast<std::int16_t>(std::clamp(value * kMotionUnits, -32000.0F, 32000.0F));
  };
  return {limited(x), limited(y)};
}

Affine Affine::operator*(const Affine &inner) const {
  const Point origin = (*this)({inner.x0, inner.y0});
  return {xx * inner.xx + xy * inner.yx,
          xx * inner.xy + xy * inner.yy,
          yx * inner.xx + yy * inner.yx,
          yx * inner.xy + yy * inner.yy,
          origin.x,
          origin.y};
}

Affine Affine::inverse() const {
  const float scale = 1 / (xx * yy - xy * yx);
  Affine found{yy * scale, -xy * scale, -yx * scale, xx * scale, 0, 0};
  const Point origin = found({x0, y0});
  found.x0 = -origin.x;
  found.y0 = -origin.y;
  return found;
}

Affine Affine::rotation(const Point &centre, float radians) {
  const float c = std::cos(radians);
  const float s = std::sin(radians);
  return {
      c, -s, s, c, centre.x - c * centre.x + s * centre.y, centre.y - s * centre.x - c * centre.y};
}

void Canvas::follow(std::vector<MaterialPoint> points) {
  materials_.resize(pixels_.size());
  points_.resize(points.size());
  followed_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    followed_.emplace(points[i].thing, std::pair(i, points[i].texel));
}

void Canvas::clear() {
  constexpr Point kNowhere{-1e6F, -1e6F};
  std::ranges::fill(pixels_, 0);
  std::ranges::fill(materials_, MaterialPoint());
  std::ranges::fill(points_, kNowhere);
}

template <typename Place>
void Canvas::place_points(const Thing &thing, Place &&place) {
  if (thing.kind == Kind::other)
    return;
  const auto [first, last] = followed_.equal_range(thing);
  for (auto it = first; it != last; ++it)
    points_[it->second.first] = place(it->second.second);
}

Canvas::Canvas(int width, int height)
    : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * height),
      motions_(static_cast<std::size_t>(width) * height) {}

// Reads the texture backwards along each row of the frame. A point of the thing that is at p now
// was at before · now⁻¹ · p; the difference changes evenly along a row. `keep` narrows the px of a
// row.
template <typename Keep>
void Canvas::paint(const Texture &texture, const Pose &pose, const Thing &thing, int top,
                   int bottom, int gain, Keep &&keep) {
  constexpr float kFraction = 1 << 16;
  place_points(thing, pose.now);
  const Affine to_texel = pose.now.inverse();
  const Affine to_before = pose.before * to_texel;
  const auto step_u = static_cast<std::int32_t>(to_texel.xx * kFraction);
  const auto step_v = static_cast<std::int32_t>(to_texel.yx * kFraction);
  const std::int32_t last_u = ((texture.width - 1) << 16) - 1;
  const std::int32_t last_v = ((texture.height - 1) << 16) - 1;
  // The last texels are read together with their neighbours.
  const Limits across(to_texel.xx, static_cast<float>(texture.width) - 1.01F);
  const Limits down(to_texel.yx, static_cast<float>(texture.height) - 1.01F);
  for (int y = std::max(top, 0); y <= std::min(bottom, height_ - 1); ++y) {
    const Point first = to_texel({0, static_cast<float>(y)});
    float low = 0;
    auto high = static_cast<float>(width_ - 1);
    across.narrow(first.x, low, high);
    down.narrow(first.y, low, high);
    keep(y, low, high);
    if (!(low <= high))
      continue;
    const auto left = static_cast<int>(std::ceil(low));
    const auto right = static_cast<int>(high);
    const Point at{static_cast<float>(left), static_cast<float>(y)};
    const Point texel = to_texel(at);
    const Point was = to_before(at);
    const auto first_u = static_cast<std::int32_t>(texel.x * kFraction);
    const auto first_v = static_cast<std::int32_t>(texel.y * kFraction);
    const float moved_x = at.x - was.x;
    const float moved_y = at.y - was.y;
    std::uint32_t *pixel = row(y) + left;
    for (int i = 0; i <= right - left; ++i) {
      if (pixel[i] >= kCovered)
        continue;
      const auto u = static_cast<unsigned>(std::clamp(first_u + i * step_u, 0, last_u));
      const auto v = static_cast<unsigned>(std::clamp(first_v + i * step_v, 0, last_v));
      const Pixel *upper = texture.row(static_cast<int>(v >> 16)) + (u >> 16);
      Pixel under = bilinear(upper, upper + texture.width, u >> 8 & 255, v >> 8 & 255);
      if (!(under >> 48))
        continue;
      if (gain != 256)
        under = brighten(under, static_cast<unsigned>(gain));
      if (add(pixel[i], under)) {
        show(left + i, y, thing,
             Point{static_cast<float>(u), static_cast<float>(v)} * (1 / kFraction));
        const auto along = static_cast<float>(i);
        motion_row(y)[left + i] =
            to_motion(moved_x + along * (1 - to_before.xx), moved_y - along * to_before.yx);
      }
    }
  }
}

void Canvas::draw(const Texture &texture, const Pose &pose, const Thing &thing) {
  const auto w = static_cast<float>(texture.width - 1);
  const auto h = static_cast<float>(texture.height - 1);
  float top = 1e9F;
  float bottom = -1e9F;
  for (const Point &corner : {Point{0, 0}, Point{w, 0}, Point{0, h}, Point{w, h}}) {
    const float y = pose.now(corner).y;
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  paint(texture, pose, thing, static_cast<int>(std::ceil(top)),
        static_cast<int>(std::floor(bottom)), 256, [](int, float &, float &) {});
}

void Canvas::draw_triangle(const Texture &texture, const Pose &pose, const Point &a, const Point &b,
                           const Point &c, int gain, const Thing &thing) {
  const Point corners[] = {pose.now(a), pose.now(b), pose.now(c)};
  const auto [upper, lower] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  const auto keep = [&](int y, float &low, float &high) {
    const auto level = static_cast<float>(y);
    float left = 1e9F;
    float right = -1e9F;
    for (int i = 0; i < 3; ++i) {
      const Point &from = corners[i];
      const Point &to = corners[(i + 1) % 3];
      if ((from.y <= level) == (to.y <= level))
        continue;
      const float x = from.x + (to.x - from.x) * (level - from.y) / (to.y - from.y);
      left = std::min(left, x);
      right = std::max(right, x);
    }
    low = std::max(low, left);
    // A px on the edge of two triangles belongs to the right one.
    high = std::min(high, std::ceil(right) - 1);
  };
  paint(texture, pose, thing, static_cast<int>(std::ceil(upper)),
        static_cast<int>(std::floor(lower)), gain, keep);
}

// With B(x, t) the lean and k its share, what is at x now stands at m = x − k·B(x, t), and was at
// x' with x' − k·B(x', t − dt) = m. One step of Newton's method from x: x − x' = k·(B(x, t) − B(x,
// t − dt)) / (1 − k·dB/dx).
void Canvas::draw_row(const Pixel *texels, int length, int y, const Lean &lean,
                      std::span<const std::uint16_t> gain, const Thing &thing) {
  if (y < 0 || y >= height_)
    return;
  place_points(thing, [&](const Point &texel) {
    return Point{leaning_place(texel.x, lean), static_cast<float>(y)};
  });
  std::uint32_t *pixel = row(y);
  const float last = static_cast<float>(length) - 1.01F;
  for (int x = 0; x < width_; ++x) {
    if (pixel[x] >= kCovered)
      continue;
    const float u =
        std::clamp(static_cast<float>(x) + lean.offset - lean.share * lean.now[x], 0.0F, last);
    const auto whole = static_cast<int>(u);
    const auto part = static_cast<unsigned>((u - static_cast<float>(whole)) * 256);
    const Pixel *texel = texels + whole;
    const Pixel under = ((texel[0] * (256 - part) + texel[1] * part) >> 8) & kLanes;
    if (under >> 48 && add(pixel[x], brighten(under, gain[x]))) {
      show(x, y, thing, {u, 0});
      const float slope = lean.now[std::min(x + 1, width_ - 1)] - lean.now[x];
      motion_row(y)[x] =
          to_motion(lean.share * (lean.now[x] - lean.before[x]) / (1 - lean.share * slope), 0);
    }
  }
}

void Canvas::draw_span(int y, float x, float width, Pixel colour, Motion motion,
                       const Thing &thing) {
  if (y < 0 || y >= height_)
    return;
  constexpr float kCentre = 0.5F; // of a pixel, from its left edge
  place_points(thing, [&](const Point &texel) {
    return Point{x + texel.x * width - kCentre, static_cast<float>(y)};
  });
  const int left = std::max(static_cast<int>(std::floor(x)), 0);
  const int right = std::min(static_cast<int>(std::ceil(x + width)), width_);
  std::uint32_t *pixel = row(y);
  for (int i = left; i < right; ++i) {
    const float cover =
        std::min(x + width, static_cast<float>(i + 1)) - std::max(x, static_cast<float>(i));
    const auto weight = static_cast<Pixel>(std::clamp(cover, 0.0F, 1.0F) * 256);
    if (add(pixel[i], ((colour * weight) >> 8) & kLanes)) {
      show(i, y, thing, {(static_cast<float>(i) + kCentre - x) / width, 0});
      motion_row(y)[i] = motion;
    }
  }
}

void Canvas::field_of(std::uint64_t interval, haptic::MotionField &field) const {
  const int columns = field.columns;
  const int rows = field.rows;
  field.interval = interval;
  field.frame_width = static_cast<std::uint32_t>(width_);
  field.frame_height = static_cast<std::uint32_t>(height_);
  field.cells.resize(static_cast<std::size_t>(columns) * rows);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const Point moved = mean_motion(c * width_ / columns, r * height_ / rows,
                                      (c + 1) * width_ / columns, (r + 1) * height_ / rows) *
                          static_cast<float>(1e9 / static_cast<double>(interval));
      field.cells[static_cast<std::size_t>(r) * columns + c] = {moved.x, moved.y, 1};
    }
}

// Y = 16 + 219·(0.2126 R + 0.7152 G + 0.0722 B), Cb and Cr accordingly (ITU-R BT.709), for R, G, B
// in 0..1.
void Canvas::write_i420(std::span<std::uint8_t> bytes) const {
  std::uint8_t *luma = bytes.data();
  std::uint8_t *blue = luma + static_cast<std::size_t>(width_) * height_;
  std::uint8_t *red = blue + static_cast<std::size_t>(width_ / 2) * (height_ / 2);
  for (int y = 0; y < height_; ++y) {
    const std::uint32_t *pixel = &pixels_[static_cast<std::size_t>(y) * width_];
    for (int x = 0; x < width_; ++x) {
      const std::uint32_t p = pixel[x];
      *luma++ = static_cast<std::uint8_t>(
          ((p >> 16 & 255) * 11966 + (p >> 8 & 255) * 40254 + (p & 255) * 4064 + 1081344) >> 16);
    }
    if (y % 2)
      continue;
    for (int x = 0; x < width_; x += 2) {
      int r = 0;
      int g = 0;
      int b = 0;
      for (const std::uint32_t p :
           {pixel[x], pixel[x + 1], pixel[x + width_], pixel[x + width_ + 1]}) {
        r += static_cast<int>(p >> 16 & 255);
        g += static_cast<int>(p >> 8 & 255);
        b += static_cast<int>(p & 255);
      }
      *blue++ = static_cast<std::uint8_t>((-6596 * r - 22189 * g + 28785 * b + 33685504) >> 18);
      *red++ = static_cast<std::uint8_t>((28785 * r - 26145 * g - 2640 * b + 33685504) >> 18);
    }
  }
}

bool Canvas::write_png(const std::string &path) {
  cairo_surface_t *surface =
      cairo_image_surface_create_for_data(reinterpret_cast<unsigned char *>(pixels_.data()),
                                          CAIRO_FORMAT_RGB24, width_, height_, width_ * 4);
  const cairo_status_t status = cairo_surface_write_to_png(surface, path.c_str());
  cairo_surface_destroy(surface);
  return status == CAIRO_STATUS_SUCCESS;
}

} // namespace film
