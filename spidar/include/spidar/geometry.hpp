// The constants of one SPIDAR-G: data that its user can measure and edit, never code.
#pragma once

#include "spidar/types.hpp"

#include <string>
#include <vector>

namespace spidar {

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
                            0.025}; ///< m from the centre; equation 1 maps it to the picture
};

/// Name of the geometry used when none is given.
inline constexpr const char *kDefaultGeometry = "spidar-g6x3r";

/// Names that load_geometry() knows without a file.
std::vector<std::string> builtin_geometries();

/// `name_or_file` is the name of a built-in geometry, a name found as NAME.ini in a directory of
/// $SPIDAR_GEOMETRY_PATH or the installed geometry directory, or a path to a GKeyFile
/// (docs/formats/geometry.md). Throws Error: not_found, or geometry with the key and reason,
/// also when the wrench-closure test fails (it says which direction cannot be pulled).
Geometry load_geometry(const std::string &name_or_file);

/// String lengths at a pose.
StringLengths string_lengths(const Geometry &geometry, const Pose &pose);

/// Directions in which the strings cannot pull at the centre, in words ("turn about +y"), empty if
/// the geometry has wrench closure: every wrench is a positive combination of string pulls.
std::string unreachable_directions(const Geometry &geometry);

} // namespace spidar
