// SPDX-License-Identifier: LGPL-2.1-or-later
// cairo draws the textures, once.
#pragma once

#include "scene/canvas.hpp"
#include "scene/noise.hpp"

#include <cairo.h>
#include <memory>

namespace film {

/// 0..1
struct Colour {
  float red = 0;
  float green = 0;
  float blue = 0;

  Colour operator*(float factor) const { return {red * factor, green * factor, blue * factor}; }
};

constexpr Colour mix(const Colour &a, const Colour &b, float share) {
  return {mix(a.red, b.red, share), mix(a.green, b.green, share), mix(a.blue, b.blue, share)};
}

/// Of premultiplied ARGB32.
constexpr std::uint32_t opaque(const Colour &colour) {
  const auto byte = [](float value) {
    return static_cast<std::uint32_t>(value <= 0 ? 0 : value >= 1 ? 255 : value * 255 + 0.5F);
  };
  return 0xff000000U | byte(colour.red) << 16 | byte(colour.green) << 8 | byte(colour.blue);
}

class Drawing {
public:
  Drawing(int width, int height)
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height)),
        cairo_(cairo_create(surface_.get())) {}

  cairo_t *get() { return cairo_.get(); }

  void set(const Colour &colour, float alpha = 1) {
    cairo_set_source_rgba(cairo_.get(), static_cast<double>(colour.red),
                          static_cast<double>(colour.green), static_cast<double>(colour.blue),
                          static_cast<double>(alpha));
  }

  Texture texture() {
    cairo_surface_flush(surface_.get());
    Texture made{cairo_image_surface_get_width(surface_.get()),
                 cairo_image_surface_get_height(surface_.get()),
                 {}};
    const unsigned char *row = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int y = 0; y < made.height; ++y, row += stride) {
      const auto *pixels = reinterpret_cast<const std::uint32_t *>(row);
      for (int x = 0; x < made.width; ++x)
        made.pixels.push_back(unpack(pixels[x]));
    }
    return made;
  }

private:
  struct Releaser {
    void operator()(cairo_surface_t *surface) const noexcept { cairo_surface_destroy(surface); }
    void operator()(cairo_t *cairo) const noexcept { cairo_destroy(cairo); }
  };
  std::unique_ptr<cairo_surface_t, Releaser> surface_;
  std::unique_ptr<cairo_t, Releaser> cairo_;
};

/// Where the sun is, seen from the frame: to the left, up, and towards the camera.
inline constexpr float kSunX = -0.55F;
inline constexpr float kSunY = -0.66F;
inline constexpr float kSunZ = 0.51F;

} // namespace film
