// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pixels/kept-luma.hpp"

#include <algorithm>

namespace haptic {
namespace {

// px that an area may move to either side before all of it is converted anew. A hand that crosses a
// frame of 1920 px in a second moves by as much between two frames, at 60 frames a second.
constexpr int kRoom = 32;

bool is_empty(const Rectangle &area) {
  return area.width <= 0 || area.height <= 0;
}

} // namespace

std::ptrdiff_t KeptLuma::offset(int x, int y) const {
  return static_cast<std::ptrdiff_t>(y - room_.y) * room_.width + (x - room_.x);
}

void KeptLuma::make_room(const Rectangle &area) {
  kept_ = {};
  room_ = {area.x - kRoom, area.y - kRoom, area.width + 2 * kRoom, area.height + 2 * kRoom};
  const std::size_t needed =
      static_cast<std::size_t>(room_.width) * static_cast<std::size_t>(room_.height);
  if (pixels_.size() < needed)
    pixels_.resize(needed);
}

void KeptLuma::convert(const LumaSource &frame, const Rectangle &part) {
  if (!is_empty(part))
    frame.convert(part, pixels_.data() + offset(part.x, part.y), room_.width);
}

LumaView KeptLuma::read(const LumaSource &frame, const Rectangle &area) {
  if (const LumaView plane = frame.plane(area); plane.pixels)
    return plane;
  const Rectangle known = intersection(kept_, area);
  if (is_empty(known) || intersection(room_, area) != area) {
    make_room(area);
    convert(frame, area);
  } else {
    const int right = known.x + known.width;
    const int bottom = known.y + known.height;
    convert(frame, {area.x, area.y, area.width, known.y - area.y});
    convert(frame, {area.x, bottom, area.width, area.y + area.height - bottom});
    convert(frame, {area.x, known.y, known.x - area.x, known.height});
    convert(frame, {right, known.y, area.x + area.width - right, known.height});
  }
  kept_ = area;
  return {pixels_.data() + offset(area.x, area.y), area.width, area.height, room_.width};
}

} // namespace haptic
