// SPDX-License-Identifier: LGPL-2.1-or-later
// A frame whose luma is a plane in memory.
#pragma once

#include "moving-texture.hpp"
#include "pixels/kept-luma.hpp"

#include <stdexcept>

namespace test {

/// The pixels must stay. An area outside them throws std::out_of_range.
class PlaneSource final : public haptic::LumaSource {
public:
  explicit PlaneSource(const haptic::LumaView &pixels) : pixels_(pixels) {}
  explicit PlaneSource(const Frame &frame)
      : pixels_{frame.pixels.data(), frame.width, frame.height, frame.width} {}

  haptic::LumaView plane(const haptic::Rectangle &area) const override {
    if (area.x < 0 || area.y < 0 || area.x + area.width > pixels_.width ||
        area.y + area.height > pixels_.height)
      throw std::out_of_range("an area outside the frame");
    return {pixels_.pixels + area.y * pixels_.stride + area.x, area.width, area.height,
            pixels_.stride};
  }
  void convert(const haptic::Rectangle & /*area*/, std::uint8_t * /*to*/,
               std::ptrdiff_t /*stride*/) const override {}

private:
  haptic::LumaView pixels_;
};

} // namespace test
