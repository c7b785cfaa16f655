// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <spidar/haptic-device.hpp>
#include <string>

namespace haptic {

/// One row; the members are the columns in their order (docs/formats/csv-log.md). SI units. New
/// columns go to the end.
struct TickRow {
  double time = 0;                                    ///< s, running time
  spidar::Vector3 position = spidar::Vector3::Zero(); ///< m, grip
  std::array<double, 2> velocity{};                   ///< px/s of the frame, y down
  double spin = 0;                                    ///< rad/s
  spidar::Wrench commanded;
  double confidence = 0;                               ///< 0..1
  spidar::Tensions tension = spidar::Tensions::Zero(); ///< N
  double mono = 0;        ///< s of the monotonic clock since the first row
  std::uint32_t hold = 0; ///< Hold (safety-chain.hpp): the reasons why the force is held
  std::array<double, 4> orientation{0, 0, 0, 1}; ///< x, y, z, w: from grip to workspace frame
  double energy = 0; ///< share of the budget for continuous force that is used
  spidar::Vector3 turning = spidar::Vector3::Zero(); ///< rad/s, of the grip
  spidar::Wrench realised;                           ///< what the tensions exert
  spidar::Vector3 proxy = spidar::Vector3::Zero();   ///< m; where the hand touches the surface
  bool touches = false;
  std::uint32_t limits = 0; ///< Limit (safety-chain.hpp): what made the force smaller

  /// Reads the columns that the device knows.
  void read(const spidar::DeviceState &state) noexcept;
};

inline constexpr const char *kTickLogHeader =
    "time,x,y,z,vx,vy,spin,fx,fy,fz,tx,ty,tz,confidence,t0,t1,t2,t3,t4,t5,t6,t7,mono,hold"
    ",qx,qy,qz,qw,energy,wx,wy,wz,rfx,rfy,rfz,rtx,rty,rtz,px,py,pz,touch,limits";

/// Appends one line with its line feed: nine significant digits, "." in every locale. A number that
/// is not finite is written as 0.
void append_row(std::string &text, const TickRow &row);

} // namespace haptic
