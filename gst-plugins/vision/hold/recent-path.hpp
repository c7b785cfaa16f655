// SPDX-License-Identifier: LGPL-2.1-or-later
// Where a thing was in the last seconds.
#pragma once

#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace haptic {

/// Not thread-safe.
class RecentPath {
public:
  struct Place {
    double time = 0; ///< s
    PatchPose pose;
  };

  void clear() { count_ = 0; }
  /// Later than all before.
  void add(double time, const PatchPose &pose) { places_[count_++ % kRoom] = {time, pose}; }

  /// The latest place that is not later; the earliest that is kept, if all are. There must be one.
  const Place &before(double time) const {
    std::size_t back = 1;
    while (back < kept() && latest(back).time > time)
      ++back;
    return latest(back);
  }

  struct Swing {
    float x = 0; ///< the middle of the box about the places
    float y = 0;
    float size = 0; ///< half the diagonal of the box
  };
  /// Of the places since then; at the latest one without such.
  Swing swing(double since) const {
    if (kept() == 0)
      return {};
    PatchPose low = latest(1).pose;
    PatchPose high = low;
    for (std::size_t back = 2; back <= kept() && latest(back).time >= since; ++back) {
      const PatchPose &pose = latest(back).pose;
      low.x = std::min(low.x, pose.x);
      low.y = std::min(low.y, pose.y);
      high.x = std::max(high.x, pose.x);
      high.y = std::max(high.y, pose.y);
    }
    return {(low.x + high.x) / 2, (low.y + high.y) / 2,
            std::hypot(high.x - low.x, high.y - low.y) / 2};
  }

private:
  static constexpr std::size_t kRoom = 128; // two seconds at 60 frames a second

  std::size_t kept() const { return std::min(count_, kRoom); }
  const Place &latest(std::size_t back) const { return places_[(count_ - back) % kRoom]; }

  std::array<Place, kRoom> places_;
  std::size_t count_ = 0;
};

} // namespace haptic
