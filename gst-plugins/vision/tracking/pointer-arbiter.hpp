// SPDX-License-Identifier: LGPL-2.1-or-later
// Chooses among the pointers of the haptic device, the mouse or touch screen, and the application.
#pragma once

#include "samples/pointer-position.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>

namespace haptic {

/// Fractions of the frame, 0..1, origin at its top left.
struct Pointer {
  double x = 0.5;
  double y = 0.5;
  double z = 0;         ///< -1..1 of the half workspace, towards the user; 0 without a device
  bool pressed = false; ///< a button, or a finger on the screen
  bool operator==(const Pointer &) const = default;
};

/// N, x to the right, y up, z towards the user.
using Force = std::array<double, 3>;

enum class PointerSource { automatic, haptic, navigation, property };

/// Keeps the newest position from each source. Not thread-safe: the owner locks.
class PointerArbiter {
public:
  using Time = std::chrono::steady_clock::time_point;

  /// A device that reports nothing for longer has been put down.
  static constexpr std::chrono::seconds kHapticTimeout{1};

  PointerSource source = PointerSource::automatic;
  Pointer property;

  /// `force` and `proxy`: of the device, as it reported with its position. While a device presses,
  /// no other one points.
  void point_haptic(Pointer pointer, Time now, std::optional<Force> force = std::nullopt,
                    std::optional<ProxyPosition> proxy = std::nullopt,
                    const std::string &device = {}) {
    if (haptic_ && haptic_->pointer.pressed && haptic_is_fresh(now) && haptic_device_ != device)
      return;
    haptic_.emplace(pointer, now, force, proxy); // in place: no copy of an unset force
    haptic_device_ = device;
  }
  /// In px of a frame of this size; clamped at its borders. The button stays as it is.
  void point_navigation(double x, double y, int frame_width, int frame_height) {
    navigation_ = Pointer{.x = std::clamp(x / frame_width, 0.0, 1.0),
                          .y = std::clamp(y / frame_height, 0.0, 1.0),
                          .pressed = navigation_ && navigation_->pressed};
  }
  /// Of the mouse or the finger that pointed last. Without one it has no effect.
  void press_navigation(bool pressed) {
    if (navigation_)
      navigation_->pressed = pressed;
  }

  /// Forgets the pointers that came as events.
  void forget() {
    haptic_.reset();
    navigation_.reset();
  }

  /// `automatic`: the device if it reported within kHapticTimeout, else the mouse, else the
  /// property. A chosen source that never reported leaves the property in use. A device that is
  /// silent presses nothing: the button may have been let go since.
  Pointer in_use(Time now) const {
    if (haptic_ && (source == PointerSource::haptic ||
                    (source == PointerSource::automatic && haptic_is_fresh(now)))) {
      Pointer pointer = haptic_->pointer;
      pointer.pressed = pointer.pressed && haptic_is_fresh(now);
      return pointer;
    }
    if (navigation_ && (source == PointerSource::navigation || source == PointerSource::automatic))
      return *navigation_;
    return property;
  }

  /// The force on the device, or nothing if it is unknown or the device is silent.
  std::optional<Force> force(Time now) const {
    return haptic_ && haptic_is_fresh(now) ? haptic_->force : std::nullopt;
  }
  /// The proxy on a relief, or nothing if there is none or the device is silent.
  std::optional<ProxyPosition> proxy(Time now) const {
    return haptic_ && haptic_is_fresh(now) ? haptic_->proxy : std::nullopt;
  }

private:
  bool haptic_is_fresh(Time now) const {
    return haptic_ && now - haptic_->arrived <= kHapticTimeout;
  }

  struct Dated {
    Dated(Pointer pointer_now, Time now, std::optional<Force> force_now,
          std::optional<ProxyPosition> proxy_now)
        : pointer(pointer_now), arrived(now), force(force_now), proxy(proxy_now) {}
    Pointer pointer;
    Time arrived;
    std::optional<Force> force;
    std::optional<ProxyPosition> proxy;
  };
  std::optional<Dated> haptic_;
  std::string haptic_device_;
  std::optional<Pointer> navigation_;
};

} // namespace haptic
