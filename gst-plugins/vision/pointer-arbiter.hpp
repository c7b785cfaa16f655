// SPDX-License-Identifier: LGPL-2.1-or-later
// Who points: the haptic device, the mouse or touch screen, or the application.
#pragma once

#include <chrono>
#include <optional>

namespace haptic {

/// Fractions of the frame, 0..1, origin at its top left.
struct Pointer {
  double x = 0.5;
  double y = 0.5;
  double z = 0; ///< -1..1 of the half workspace, towards the user; only a device has it
  bool operator==(const Pointer &) const = default;
};

enum class PointerSource { automatic, haptic, navigation, property };

/// Keeps the newest position from each source. Not thread-safe: the owner locks.
class PointerArbiter {
public:
  using Time = std::chrono::steady_clock::time_point;

  /// A device that is silent for longer has been put down.
  static constexpr std::chrono::seconds kHapticTimeout{1};

  PointerSource source = PointerSource::automatic;
  Pointer property;

  void point_haptic(Pointer pointer, Time now) { haptic_ = Dated{pointer, now}; }
  void point_navigation(Pointer pointer) { navigation_ = pointer; }

  /// Forgets what came as events.
  void forget() {
    haptic_.reset();
    navigation_.reset();
  }

  /// `automatic`: the device if it spoke within kHapticTimeout, else the mouse, else the property.
  /// A chosen source that never spoke leaves the property in use.
  Pointer in_use(Time now) const {
    const bool fresh = haptic_ && now - haptic_->arrived <= kHapticTimeout;
    if (haptic_ &&
        (source == PointerSource::haptic || (source == PointerSource::automatic && fresh)))
      return haptic_->pointer;
    if (navigation_ && (source == PointerSource::navigation || source == PointerSource::automatic))
      return *navigation_;
    return property;
  }

private:
  struct Dated {
    Pointer pointer;
    Time arrived;
  };
  std::optional<Dated> haptic_;
  std::optional<Pointer> navigation_;
};

} // namespace haptic
