// SPDX-License-Identifier: LGPL-2.1-or-later
// A simulated SPIDAR-G: encoders and D/A with their real resolution, a grip with mass, strings that
// only pull, and a hand that holds the grip. SI units; frame of types.hpp; one thread.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/geometry.hpp"

#include <cstdint>
#include <memory>
#include <string>

namespace spidar {

/// The place to which the hand pulls the grip: `hold:X,Y,Z`, `circle:RADIUS,PERIOD` (about the
/// centre, from (RADIUS, 0, 0) counter-clockwise as the user sees it), `file:PATH` (lines
/// `t,x,y,z` or `t,x,y,z,pressed`, interpolated, with 1 while the hand presses the button, else 0;
/// stays at the last one; empty lines and lines that begin with # are skipped) or `free` (nobody
/// holds it). X, Y, Z and RADIUS in -1..1 of the half workspace, PERIOD and t in s.
class SPIDAR_API HandScript {
public:
  virtual ~HandScript() = default;
  /// Sets `target` (m) for `time` (s from the start). False if no hand holds the grip.
  virtual bool target(double time, const Vector3 &workspace_half,
                      Vector3 &target) const noexcept = 0;
  /// Whether the hand presses the button of the grip at `time` (s from the start).
  virtual bool presses(double /*time*/) const noexcept { return false; }
};

/// Throws Error (argument, not_found) that names what is accepted.
SPIDAR_API std::unique_ptr<HandScript> parse_hand_script(const std::string &text);

class SPIDAR_API Simulator final : public Controller {
public:
  /// Each exchange after the first advances the simulated time to that of set_time(), or by
  /// `period` seconds if it was not called; the D/A words of the exchange before are at the motors.
  /// A silence of more than a second counts as one. The grip starts at the hand's first target
  /// (`free`: in the centre). Throws Error (geometry, argument).
  Simulator(const Geometry &geometry, std::unique_ptr<HandScript> hand, double period = 0.001);
  ~Simulator() override;

  void set_time(std::int64_t now) noexcept override;
  bool exchange(const DacWords &words, Counts &counts) noexcept override;
  /// The counters' value at the centre: not zero, as after the power-on of a real controller.
  bool home(Counts &counts) const noexcept override;
  std::string description() const override;
  bool pressed() const noexcept override;
  /// The button of the geometry, if it names one; the other pins are 0.
  std::uint16_t inputs() const noexcept override;

  /// The true pose of the simulated grip, for tests.
  const Pose &pose() const noexcept;

private:
  struct SPIDAR_HIDDEN State;
  std::unique_ptr<State> state_;
};

} // namespace spidar
