// SPDX-License-Identifier: LGPL-2.1-or-later
// From a frame of depth or disparity to the relief of a grid of cells.
#pragma once

#include "samples/relief-field.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

enum class DepthKind { depth, disparity };
enum class CellHeight { median, nearest };

/// What the numbers of pixels mean, and what becomes of them.
struct DepthScale {
  DepthKind kind = DepthKind::depth;
  double scale = 0.001;   ///< depth: m per unit; disparity: m * unit (focal length * baseline)
  double near = 0.3;      ///< m from the camera: the highest place of the relief
  double far = 4;         ///< m from the camera: the lowest place
  double range = 0.04;    ///< m between both, half of it above z = 0
  double stiffness = 200; ///< N/m
  double friction = 0.3;  ///< Coulomb coefficient
  CellHeight cell_height = CellHeight::median;
};

/// Pixels of 8 bits, or of 16 with the lower byte first; not owned.
struct DepthView {
  const std::uint8_t *pixels = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::ptrdiff_t stride = 0; ///< bytes from row to row
  int pixel_size = 2;        ///< bytes
};

/// Keeps its memory from frame to frame.
class DepthRelief {
public:
  /// Fills the cells of `relief`, whose columns and rows are set. Returns whether there is a
  /// surface: a cell of which some pixels lie between near and far.
  bool make(const DepthView &depth, const DepthScale &scale, ReliefField &relief);

private:
  std::vector<int> offsets_;         // of the columns that are read, bytes
  std::vector<ReliefCell> measured_; // before holes are filled
};

/// Of a hole of one cell between two known ones, left and right or above and below.
inline constexpr float kFilledValidity = 0.25F;

/// Fills each cell without validity that lies between two that have one, left and right or above
/// and below, with the lower of them: a camera does not see what the nearer thing hides, so the
/// hole belongs to what lies behind. Of two pairs, the one that agrees better counts. Larger holes
/// stay.
void fill_narrow_holes(std::span<const ReliefCell> measured, int columns,
                       std::span<ReliefCell> filled);

} // namespace haptic
