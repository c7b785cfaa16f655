// A SPIDAR-G without the hardware: encoders and D/A with their real resolution, a grip with mass,
// strings that only pull, and a hand that holds the grip.
#pragma once

#include "spidar/controller.hpp"
#include "spidar/geometry.hpp"

#include <memory>
#include <string>

namespace spidar {

/// Where the hand wants the grip to be: `hold:X,Y,Z`, `circle:RADIUS,PERIOD`, `file:PATH` (lines
/// `t,x,y,z`, interpolated) or `free` (nobody holds it). X, Y, Z and RADIUS in -1..1 of the half
/// workspace, PERIOD and t in s.
class HandScript {
public:
  virtual ~HandScript() = default;
  /// False when nobody holds the grip. `time` in s from the start; `target` in m.
  virtual bool target(double time, const Vector3 &workspace_half,
                      Vector3 &target) const noexcept = 0;
};

/// Throws Error (argument, not_found) that names what is accepted.
std::unique_ptr<HandScript> parse_hand_script(const std::string &text);

class Simulator final : public Controller {
public:
  /// Each exchange advances the simulated time by `period` seconds.
  Simulator(const Geometry &geometry, std::unique_ptr<HandScript> hand, double period = 0.001);
  ~Simulator() override;

  bool exchange(const DacWords &words, Counts &counts) noexcept override;
  std::string description() const override;

  /// The true pose of the simulated grip, for tests.
  const Pose &pose() const noexcept;

private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace spidar
