// SPDX-License-Identifier: LGPL-2.1-or-later
// The curves of MPEG haptics between keyframes (ISO/IEC 23090-31:2025, clause 5.7, curve_type), as
// straight lines. The formulas are those of the standard's reference software.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// The values of .hmpg.
enum class CurveType : std::uint8_t { unknown, cubic, linear, akima, bezier, bspline };

/// Returns whether the curve is drawn as what it is. Others are drawn as straight lines.
bool is_drawn(CurveType type) noexcept;

struct CurvePoint {
  std::int64_t tick = 0;
  double value = 0;
};

/// Draws the curve of one effect while its keyframes come. A line differs from the curve by 2 mN
/// at most, less where the gain is less, but there are no more than 16 lines between two keyframes.
class CurveDrawing {
public:
  /// Straight lines.
  CurveDrawing() noexcept : CurveDrawing(CurveType::linear, 1) {}
  /// `largest` is the force of the largest amplitude, N.
  CurveDrawing(CurveType type, double largest) noexcept;

  /// Appends to `points` what later keyframes do not change. `keys` are in the order of time.
  void append(std::span<const CurvePoint> keys, std::vector<CurvePoint> &points);

  /// Appends the rest, as if no keyframe came any more.
  void finish(std::vector<CurvePoint> &points);

  /// Returns whether there is a rest.
  bool waits() const noexcept { return drawn_ + 1 < keys_.size(); }
  /// Returns the tick of the last keyframe, or `otherwise` if none came.
  std::int64_t last(std::int64_t otherwise) const noexcept {
    return keys_.empty() ? otherwise : keys_.back().tick;
  }

private:
  void draw(std::size_t from, std::vector<CurvePoint> &points) const;
  double slope_between(std::ptrdiff_t from) const;
  double slope_at(std::size_t key) const;

  CurveType type_;
  double finest_;                // largest difference between a line and the curve
  std::vector<CurvePoint> keys_; // from two before the last drawn one on
  std::size_t drawn_ = 0;        // the curve is drawn up to this key
};

} // namespace haptic
