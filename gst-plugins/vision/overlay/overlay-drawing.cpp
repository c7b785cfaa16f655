// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/overlay-drawing.hpp"

#include <algorithm>
#include <cairo.h>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

namespace haptic {
namespace {

// Of the frame's height.
constexpr double kLine = 1.0 / 360;
constexpr double kText = 1.0 / 40;
constexpr double kNewton = 1.0 / 4;
constexpr double kLongestArrow = 1.0 / 2;

constexpr double kThinnestLine = 1;  // px
constexpr double kSmallestText = 10; // px
constexpr double kShortestArrow = 1; // px

// Of the line.
constexpr double kOutline = 1;
constexpr double kArrowLine = 2;
constexpr double kForceAside = kArrowLine + 2 * kOutline; // of the velocity, whose direction it has
constexpr double kHead = 3.5;                             // of an arrow's own line
constexpr double kDot = 2;
constexpr double kProxyRing = 5; // radius
constexpr double kProxyDot = 2.5;
constexpr double kSmallestHeld = 4; // radius
constexpr double kDash = 3;         // and its round ends
constexpr double kDashGap = 8;

constexpr double kPatchScale = 0.25; // so that the arrows of neighbours do not cross

constexpr double kFaintest = 0.35; // opacity at the lowest confidence

struct CairoDeleter {
  void operator()(cairo_t *cairo) const { cairo_destroy(cairo); }
  void operator()(cairo_surface_t *surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_scaled_font_t *font) const { cairo_scaled_font_destroy(font); }
  void operator()(cairo_font_face_t *face) const { cairo_font_face_destroy(face); }
  void operator()(cairo_font_options_t *options) const { cairo_font_options_destroy(options); }
};
template <typename T>
using Owned = std::unique_ptr<T, CairoDeleter>;

Owned<cairo_scaled_font_t> make_font(double size) {
  const Owned<cairo_font_face_t> face(
      cairo_toy_font_face_create("sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL));
  const Owned<cairo_font_options_t> options(cairo_font_options_create());
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  cairo_matrix_t scale;
  cairo_matrix_t identity;
  cairo_matrix_init_scale(&scale, size, size);
  cairo_matrix_init_identity(&identity);
  return Owned<cairo_scaled_font_t>(
      cairo_scaled_font_create(face.get(), &scale, &identity, options.get()));
}

void set_color(cairo_t *cairo, std::uint32_t argb, double opacity) {
  const auto part = [&](int shift) { return ((argb >> shift) & 0xff) / 255.0; };
  cairo_set_source_rgba(cairo, part(16), part(8), part(0), part(24) * opacity);
}

void add_arrow(cairo_t *cairo, double x0, double y0, double x1, double y1, double line) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  cairo_move_to(cairo, x0, y0);
  cairo_line_to(cairo, x1, y1);
  const double head = std::min(kHead * line, length / 2) / length;
  const double bx = (x0 - x1) * head;
  const double by = (y0 - y1) * head;
  cairo_move_to(cairo, x1 + bx - by * 0.6, y1 + by + bx * 0.6);
  cairo_line_to(cairo, x1, y1);
  cairo_line_to(cairo, x1 + bx + by * 0.6, y1 + by - bx * 0.6);
}

// The path in its colour with a white outline.
void stroke_outlined(cairo_t *cairo, double line, double outline, std::uint32_t argb,
                     double opacity) {
  cairo_set_source_rgba(cairo, 1, 1, 1, opacity);
  cairo_set_line_width(cairo, line + 2 * outline);
  cairo_stroke_preserve(cairo);
  set_color(cairo, argb, opacity);
  cairo_set_line_width(cairo, line);
  cairo_stroke(cairo);
}

} // namespace

OverlayDrawing::OverlayDrawing(const OverlayScene &scene, const OverlayLook &look)
    : aspect_(scene.pixel_aspect), width_(scene.frame_width * aspect_), height_(scene.frame_height),
      line_(std::max(kThinnestLine, height_ * kLine)),
      text_(std::max(kSmallestText, height_ * kText)),
      opacity_(kFaintest + (1 - kFaintest) * scene.confidence), look_(look) {
  if (look.style == OverlayStyle::none)
    return;
  if (scene.confidence > 0)
    place_measurement(scene);
  if (scene.proxy && std::isfinite((*scene.proxy)[0]) && std::isfinite((*scene.proxy)[1])) {
    proxy_ = square((*scene.proxy)[0], (*scene.proxy)[1]);
    touches_ = scene.touches;
  }
  if (scene.held.state != HoldState::none)
    place_held(scene);
  find_extent();
}

void OverlayDrawing::place_measurement(const OverlayScene &scene) {
  const Point corner = square(scene.region_x, scene.region_y);
  region_ = Box{corner.x, corner.y, scene.region_width * aspect_, scene.region_height};
  const Point pointer = square(scene.pointer_x, scene.pointer_y);
  velocity_ =
      arrow(pointer, scene.velocity_x * aspect_ * look_.scale, scene.velocity_y * look_.scale);
  if (scene.force) {
    const double newton = height_ * kNewton;
    force_ = arrow(pointer, (*scene.force)[0] * newton, -(*scene.force)[1] * newton);
    if (force_)
      force_ = aside(*force_, kForceAside * line_);
  }
  if (look_.style == OverlayStyle::full) {
    const double times = scene.interval > 0 ? kPatchScale * look_.scale / scene.interval : 0;
    for (const GstHapticPatch &patch : scene.patches) {
      const auto dx = static_cast<double>(patch.dx);
      const auto dy = static_cast<double>(patch.dy);
      const Point now =
          square(static_cast<double>(patch.x) + dx, static_cast<double>(patch.y) + dy);
      patches_.push_back(arrow(now, dx * aspect_ * times, dy * times).value_or(Arrow{now, now}));
    }
    label_ = label(scene.label, *region_, Side::below);
  }
}

void OverlayDrawing::place_held(const OverlayScene &scene) {
  const HeldPlace &held = scene.held;
  const auto place = [&](float x, float y) {
    return Point{static_cast<double>(x) * width_, static_cast<double>(y) * height_};
  };
  const bool is_known = held.state != HoldState::lost && held.state != HoldState::refused;
  const double radius =
      is_known ? std::max(kSmallestHeld * line_, static_cast<double>(held.radius) * width_) : 0;
  held_ = Held{place(held.x, held.y), radius, held.state != HoldState::held, {}, {}};
  for (const HeldTrail::Point &point : scene.trail)
    held_->trail.push_back({place(point.x, point.y), point.joined});
  if (held.state != HoldState::held) {
    const Point &at = held_->centre;
    held_->word = label(std::string(hold_words(held.state)),
                        {at.x - radius, at.y - radius, 2 * radius, 2 * radius}, Side::above);
  }
}

std::optional<OverlayDrawing::Arrow> OverlayDrawing::arrow(Point from, double dx, double dy) const {
  const double length = std::hypot(dx, dy);
  if (!(length >= kShortestArrow) || !std::isfinite(length))
    return std::nullopt;
  const double shorter = std::min(1.0, height_ * kLongestArrow / length);
  return Arrow{from, {from.x + dx * shorter, from.y + dy * shorter}};
}

// Returns the arrow moved to its right.
OverlayDrawing::Arrow OverlayDrawing::aside(const Arrow &arrow, double distance) {
  const double length = std::hypot(arrow.to.x - arrow.from.x, arrow.to.y - arrow.from.y);
  const double dx = -(arrow.to.y - arrow.from.y) / length * distance;
  const double dy = (arrow.to.x - arrow.from.x) / length * distance;
  return {{arrow.from.x + dx, arrow.from.y + dy}, {arrow.to.x + dx, arrow.to.y + dy}};
}

// Returns a label on this side of the box, or on the other if there is no room. A frame that is too
// small has none.
std::optional<OverlayDrawing::Label> OverlayDrawing::label(const std::string &text,
                                                           const Box &about, Side side) const {
  if (text.empty())
    return std::nullopt;
  cairo_text_extents_t extents;
  cairo_scaled_font_text_extents(make_font(text_).get(), text.c_str(), &extents);
  const double margin = text_ * 0.3;
  const double gap = 3 * line_;
  const double width = extents.x_advance + 2 * margin;
  const double height = text_ + 2 * margin;
  if (width > width_ || height > height_)
    return std::nullopt;
  const double above = about.y - gap - height;
  const double below = about.y + about.height + gap;
  const bool is_below = side == Side::below ? below + height <= height_ : above < 0;
  const double y = std::max(0.0, std::min(is_below ? below : above, height_ - height));
  const double x = std::clamp(about.x + about.width / 2 - width / 2, 0.0, width_ - width);
  return Label{text, {x, y, width, height}, {x + margin, y + margin + text_ * 0.8}};
}

void OverlayDrawing::find_extent() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double left = kInfinity;
  double top = kInfinity;
  double right = -kInfinity;
  double bottom = -kInfinity;
  const auto cover = [&](Point point, double margin) {
    left = std::min(left, point.x - margin);
    top = std::min(top, point.y - margin);
    right = std::max(right, point.x + margin);
    bottom = std::max(bottom, point.y + margin);
  };
  const auto cover_box = [&](const Box &box, double margin) {
    cover({box.x, box.y}, margin);
    cover({box.x + box.width, box.y + box.height}, margin);
  };
  const auto cover_arrow = [&](const Arrow &arrow, double line) {
    // The head's barbs lie within its length about the tip.
    const double margin = (kHead + 1) * line + kOutline * line_;
    cover(arrow.from, margin);
    cover(arrow.to, margin);
  };
  if (region_)
    cover_box(*region_, 2 * line_);
  if (proxy_)
    cover(*proxy_, (kProxyRing + 3) * line_);
  if (label_)
    cover_box(label_->box, 1);
  if (held_) {
    cover(held_->centre, held_->radius + 3 * line_);
    for (const TrailPoint &point : held_->trail)
      cover(point.place, 3 * line_);
    if (held_->word)
      cover_box(held_->word->box, 1);
  }
  for (const Arrow &patch : patches_)
    cover_arrow(patch, line_);
  for (const auto &arrow : {force_, velocity_})
    if (arrow)
      cover_arrow(*arrow, kArrowLine * line_);

  if (left > right)
    return;
  const auto pixel = [](double x, double most) {
    return static_cast<int>(std::clamp(x, 0.0, most));
  };
  const double columns = width_ / aspect_;
  const int x = pixel(std::floor(left / aspect_), columns);
  const int y = pixel(std::floor(top), height_);
  extent_ = {x, y, pixel(std::ceil(right / aspect_), columns) - x,
             pixel(std::ceil(bottom), height_) - y};
  if (extent_.width <= 0 || extent_.height <= 0)
    extent_ = {};
}

void OverlayDrawing::paint(std::uint8_t *pixels, int stride) const {
  const Owned<cairo_surface_t> surface(cairo_image_surface_create_for_data(
      pixels, CAIRO_FORMAT_ARGB32, extent_.width, extent_.height, stride));
  const Owned<cairo_t> owned(cairo_create(surface.get()));
  cairo_t *cairo = owned.get();
  cairo_translate(cairo, -extent_.x, -extent_.y);
  cairo_scale(cairo, 1 / aspect_, 1);
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
  if (region_)
    paint_measurement(cairo);
  if (held_)
    paint_held(cairo);
  if (proxy_)
    paint_proxy(cairo);
  cairo_surface_flush(surface.get());
}

// A ring; with a dot in it while the hand touches.
void OverlayDrawing::paint_proxy(cairo_t *cairo) const {
  constexpr double kWhole = 2 * std::numbers::pi;
  cairo_new_path(cairo);
  cairo_arc(cairo, proxy_->x, proxy_->y, kProxyRing * line_, 0, kWhole);
  cairo_set_source_rgba(cairo, 0, 0, 0, 0.6);
  cairo_set_line_width(cairo, 3 * line_);
  cairo_stroke_preserve(cairo);
  cairo_set_source_rgba(cairo, 1, 1, 1, 1);
  cairo_set_line_width(cairo, 1.5 * line_);
  cairo_stroke(cairo);
  if (!touches_)
    return;
  cairo_arc(cairo, proxy_->x, proxy_->y, kProxyDot * line_, 0, kWhole);
  cairo_set_source_rgba(cairo, 1, 1, 1, 1);
  cairo_set_line_width(cairo, 2 * line_);
  cairo_stroke_preserve(cairo);
  set_color(cairo, look_.hold_color, 1);
  cairo_fill(cairo);
}

void OverlayDrawing::paint_measurement(cairo_t *cairo) const {
  // Inside its border, on whole pixels.
  cairo_rectangle(cairo, region_->x + line_ / 2, region_->y + line_ / 2, region_->width - line_,
                  region_->height - line_);
  cairo_set_source_rgba(cairo, 0, 0, 0, 0.6);
  cairo_set_line_width(cairo, 3 * line_);
  cairo_stroke_preserve(cairo);
  cairo_set_source_rgba(cairo, 1, 1, 1, 1);
  cairo_set_line_width(cairo, line_);
  cairo_stroke(cairo);

  // Needles: there may be thirty in as many pixels, and no room for heads and outlines. The
  // confidence is that of the velocity, not theirs.
  set_color(cairo, look_.velocity_color, 1);
  cairo_set_line_width(cairo, line_);
  for (const Arrow &patch : patches_) {
    cairo_move_to(cairo, patch.from.x, patch.from.y);
    cairo_line_to(cairo, patch.to.x, patch.to.y);
  }
  cairo_stroke(cairo);
  cairo_set_line_width(cairo, kDot * line_);
  for (const Arrow &patch : patches_) {
    cairo_move_to(cairo, patch.from.x, patch.from.y);
    cairo_line_to(cairo, patch.from.x, patch.from.y);
  }
  cairo_stroke(cairo);

  for (const auto &[arrow, color] :
       {std::pair(force_, look_.force_color), std::pair(velocity_, look_.velocity_color)})
    if (arrow) {
      add_arrow(cairo, arrow->from.x, arrow->from.y, arrow->to.x, arrow->to.y, kArrowLine * line_);
      stroke_outlined(cairo, kArrowLine * line_, kOutline * line_, color, opacity_);
    }
  if (label_)
    paint_label(cairo, *label_);
}

// Its path, and a ring that is solid only where the place is exact.
void OverlayDrawing::paint_held(cairo_t *cairo) const {
  cairo_new_path(cairo);
  for (const TrailPoint &point : held_->trail) {
    if (!point.joined)
      cairo_move_to(cairo, point.place.x, point.place.y);
    cairo_line_to(cairo, point.place.x, point.place.y);
  }
  stroke_outlined(cairo, line_, kOutline * line_, look_.hold_color, 1);
  if (held_->radius > 0) {
    const double dashes[] = {kDash * line_, kDashGap * line_};
    if (held_->dashed)
      cairo_set_dash(cairo, dashes, 2, 0);
    cairo_arc(cairo, held_->centre.x, held_->centre.y, held_->radius, 0, 2 * std::numbers::pi);
    stroke_outlined(cairo, kArrowLine * line_, kOutline * line_, look_.hold_color, 1);
    cairo_set_dash(cairo, nullptr, 0, 0);
  }
  if (held_->word)
    paint_label(cairo, *held_->word);
}

void OverlayDrawing::paint_label(cairo_t *cairo, const Label &label) const {
  const Box &box = label.box;
  cairo_rectangle(cairo, box.x, box.y, box.width, box.height);
  cairo_set_source_rgba(cairo, 0, 0, 0, 0.6);
  cairo_fill(cairo);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, text_);
  cairo_set_source_rgba(cairo, 1, 1, 1, 1);
  cairo_move_to(cairo, label.baseline.x, label.baseline.y);
  cairo_show_text(cairo, label.text.c_str());
}

} // namespace haptic
