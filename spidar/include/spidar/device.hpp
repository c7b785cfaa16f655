// A SPIDAR-G as its user sees it: pose out, wrench in, limits kept.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/export.hpp"
#include "spidar/geometry.hpp"

#include <memory>
#include <string>

namespace spidar {

/// What one tick found and did.
struct DeviceState {
  Pose pose;
  Vector3 velocity = Vector3::Zero(); ///< m/s, low-passed
  Counts counts{};
  StringLengths lengths = StringLengths::Zero();
  Tensions tensions = Tensions::Zero(); ///< N, as last commanded, with the D/A's resolution
  Wrench realised;                      ///< what these tensions do at this pose
  bool feasible = true;                 ///< the commanded wrench was within the limits
  bool valid = false;                   ///< the pose can be trusted
  bool interrupted = false; ///< since the exchange before, the guardian had put the motors at rest
};

/// Not thread-safe: exchange() and command() belong to one thread; everything else before that
/// thread starts or after it ended.
class SPIDAR_API Device {
public:
  /// Has the motors guarded against the end of this process (Controller::guard()), and starts with
  /// minimum tension in all strings. The centre is where the controller knows it to be
  /// (Controller::home()), else where the grip is once the strings are taut (calibrate()): within
  /// 1 s, normally 50 ms. `period` is the time between two calls of exchange(), s. Throws Error
  /// (geometry, argument, io).
  Device(std::unique_ptr<Controller> controller, Geometry geometry, double period = 0.001);
  ~Device(); ///< leaves minimum tension behind

  /// One tick: sends what was last commanded, receives the counts, solves the pose. False when the
  /// device did not answer; the state then keeps its last pose with valid = false. Real-time safe.
  bool exchange() noexcept;

  /// False when the device has gone for good (unplugged, its guardian dead): make another Device.
  bool connected() const noexcept;

  /// Tensions for `wrench` at the present pose, sent by the next exchange. A wrench that is not
  /// finite counts as zero. Tensions never leave the geometry's limits. Real-time safe.
  void command(const Wrench &wrench) noexcept;

  /// Takes the present grip position as workspace centre and identity orientation. Real-time safe.
  void calibrate() noexcept;

  const DeviceState &state() const noexcept;
  const Geometry &geometry() const noexcept;
  std::string description() const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace spidar
