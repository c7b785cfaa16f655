// SPDX-License-Identifier: LGPL-2.1-or-later
// The constants of one SPIDAR-G, from a file that its user can edit (docs/formats/geometry.md). SI
// units; frame of types.hpp. Not for the real-time thread.
#pragma once

#include "spidar/export.hpp"
#include "spidar/types.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace spidar {

/// A button of the grip, wired to an input pin of the controller.
struct GripButton {
  int bit = 0;         ///< of Controller::inputs(), 0 to 3: both USB controllers have these
  bool pressed = true; ///< what the bit is while the button is pressed

  bool is_pressed(std::uint16_t inputs) const noexcept { return (inputs >> bit & 1) == pressed; }
};

struct Geometry {
  std::string name;
  std::array<Vector3, kStrings> motors;          ///< string exit points, workspace frame, m
  std::array<Vector3, kStrings> attachments;     ///< string ends on the grip, grip frame, m
  std::array<double, kStrings> metres_per_count; ///< signed
  std::array<double, kStrings> volts_per_newton; ///< signed
  double digits_per_volt = 415;
  int dac_limit = 4095;        ///< largest magnitude of a D/A word
  double tension_min = 0.3;    ///< N, keeps the strings taut
  double tension_max = 5.0;    ///< N
  double grip_radius = 0.0225; ///< m, scales rotation against translation
  Vector3 workspace_half = {0.025, 0.025,
                            0.025}; ///< m from the centre; equation 1 maps it to the frame
  std::optional<GripButton> button; ///< none is known
};

/// Name of the geometry used when none is given.
inline constexpr const char *kDefaultGeometry = "spidar-g6x3r";

/// Names of the built-in geometries.
SPIDAR_API std::vector<std::string> builtin_geometries();

/// Reads a geometry. `name_or_file` is a path if it has a slash or ends in ".ini"; else a name,
/// looked up as NAME.ini in the directories of $SPIDAR_GEOMETRY_PATH, among the built-in ones, and
/// in the installed directory, in this order. Throws Error: not_found; geometry, with file, key and
/// reason, also if check_geometry() refuses it.
SPIDAR_API Geometry load_geometry(const std::string &name_or_file);

/// Throws Error (geometry) if a device with this geometry cannot be driven: values that are not
/// finite or contradict each other, or strings without wrench closure.
SPIDAR_API void check_geometry(const Geometry &geometry);

/// String lengths at a pose, m.
SPIDAR_API StringLengths string_lengths(const Geometry &geometry, const Pose &pose);

/// Names the directions in which the strings cannot pull at the centre ("turn about +y"). Empty if
/// the geometry has wrench closure: every wrench is a positive combination of string pulls.
SPIDAR_API std::string unreachable_directions(const Geometry &geometry);

} // namespace spidar
