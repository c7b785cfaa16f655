// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/stick.hpp"

#include <algorithm>

namespace haptic {
namespace {

// Of sticks and wheels, and of gamepads. Those from BTN_BASE6 on are positions of a gear lever
// (hid-lg: the lever of a G27 has 0x12c to 0x12f), and stay on.
bool is_of_a_hand(unsigned code) {
  return (code >= BTN_JOYSTICK && code <= BTN_BASE6) || (code >= BTN_GAMEPAD && code < BTN_DIGI);
}

} // namespace

Stick::Stick(const libevdev *device)
    : x_(axis(device, libevdev_has_event_code(device, EV_ABS, ABS_X) ? ABS_X : ABS_WHEEL)),
      y_(axis(device, ABS_Y)) {
  // Both axes of a stick have one range. A wheel has some hundred to 65536 steps, its pedals other
  // ones, and the first of them is ABS_Y.
  if (y_.half != x_.half)
    y_ = {};
  for (unsigned code = kFirstButton; code < kEndOfButtons; ++code)
    buttons_[code - kFirstButton] =
        is_of_a_hand(code) && libevdev_has_event_code(device, EV_KEY, code);
}

double Stick::step() const noexcept {
  return has_x() ? 1 / x_.half : 0;
}

StickState Stick::read(const libevdev *device) noexcept {
  Buttons down;
  for (unsigned code = kFirstButton; code < kEndOfButtons; ++code)
    down[code - kFirstButton] = libevdev_get_event_value(device, EV_KEY, code) != 0;
  released_ |= ~down;
  return {{value(device, x_), -value(device, y_), 0}, (down & buttons_ & released_).any()};
}

Stick::Axis Stick::axis(const libevdev *device, unsigned code) {
  const input_absinfo *info = libevdev_get_abs_info(device, code);
  if (!info)
    return {};
  const double least = info->minimum;
  const double most = info->maximum;
  return {code, (least + most) / 2, std::max((most - least) / 2, 0.5)};
}

double Stick::value(const libevdev *device, const Axis &axis) noexcept {
  if (axis.half == 0)
    return 0;
  const double there = libevdev_get_event_value(device, EV_ABS, axis.code);
  return std::clamp((there - axis.middle) / axis.half, -1.0, 1.0);
}

} // namespace haptic
