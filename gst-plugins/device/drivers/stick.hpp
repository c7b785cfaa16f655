// SPDX-License-Identifier: LGPL-2.1-or-later
// What a joystick, gamepad or wheel under Linux says: where its stick is, and whether a button is
// pressed.
#pragma once

#include <bitset>
#include <libevdev/libevdev.h>
#include <spidar/haptic-device.hpp>

namespace haptic {

struct StickState {
  spidar::Vector3 place = spidar::Vector3::Zero(); ///< -1..1, 0 in the middle, y up
  bool pressed = false;                            ///< any of its buttons
};

/// Not for several threads at once.
class Stick {
public:
  Stick() = default;
  /// Reads the axes and buttons of `device`.
  explicit Stick(const libevdev *device);

  bool has_x() const noexcept { return x_.half > 0; }
  /// Not so for a wheel, whose pedals are no second axis.
  bool has_y() const noexcept { return y_.half > 0; }
  bool has_button() const noexcept { return buttons_.any(); }
  /// The largest step of a coordinate of the place; 0 without an axis.
  double step() const noexcept;

  /// What `device` says now. A button counts only after it was seen released: a switch that stays
  /// on is no hand.
  StickState read(const libevdev *device) noexcept;

private:
  struct Axis {
    unsigned code = 0;
    double middle = 0;
    double half = 0; // of the range; 0: there is no such axis
  };
  static Axis axis(const libevdev *device, unsigned code);
  static double value(const libevdev *device, const Axis &axis) noexcept;

  static constexpr unsigned kFirstButton = BTN_JOYSTICK;
  static constexpr unsigned kEndOfButtons = BTN_DIGI;
  using Buttons = std::bitset<kEndOfButtons - kFirstButton>;

  Axis x_;
  Axis y_;
  Buttons buttons_;
  Buttons released_; // at least once
};

} // namespace haptic
