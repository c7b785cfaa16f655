// SPDX-License-Identifier: LGPL-2.1-or-later
// The luma of one frame around a place that moves, so that no pixel is converted twice.
#pragma once

#include "pixels/luma-view.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptic {

/// The luma of one frame, of any format. Areas must lie inside the frame.
class LumaSource {
public:
  virtual ~LumaSource() = default;

  /// The luma of an area in the memory of the frame. No pixels if luma has no plane of its own.
  virtual LumaView plane(const Rectangle &area) const = 0;

  /// Writes the luma of an area to rows that are `stride` bytes apart.
  virtual void convert(const Rectangle &area, std::uint8_t *to, std::ptrdiff_t stride) const = 0;
};

/// One instance holds luma of one frame at a time. Not thread-safe.
class KeptLuma {
public:
  /// The luma of an area. Converts only the part that the call before did not return. `frame` shows
  /// the same pixels in all calls since forget(). The view is valid until the next call.
  LumaView read(const LumaSource &frame, const Rectangle &area);

  /// Another frame follows.
  void forget() { kept_ = {}; }

private:
  void make_room(const Rectangle &area);
  void convert(const LumaSource &frame, const Rectangle &part);
  std::ptrdiff_t offset(int x, int y) const;

  Rectangle room_; // for which there is memory; may extend beyond the frame
  Rectangle kept_; // the part of it that is converted
  std::vector<std::uint8_t> pixels_;
};

} // namespace haptic
