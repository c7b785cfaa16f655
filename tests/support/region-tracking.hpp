// SPDX-License-Identifier: LGPL-2.1-or-later
// One region of two frames, measured by a tracker of the project.
#pragma once

#include "moving-texture.hpp"
#include "tracking/patch-tracker.hpp"
#include "tracking/region.hpp"
#include "velocity/velocity-estimate.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <utility>

namespace test {

inline haptic::LumaView view(Frame &frame, const haptic::Rectangle &crop) {
  return {&frame.at(crop.x, crop.y), crop.width, crop.height, frame.width};
}

/// The region of both frames with the margin that the tracker wants.
inline haptic::CropPair crop_pair(Frame &previous, Frame &current, const haptic::Rectangle &region,
                                  const haptic::PatchTracker &tracker) {
  const haptic::Rectangle crop =
      haptic::crop_around(region, tracker.margin(std::max(region.width, region.height)),
                          previous.width, previous.height);
  return {view(previous, crop), view(current, crop), crop, region};
}

/// What velocityavg makes of it at the middle of the region, in px per frame.
inline haptic::VelocityEstimate estimate(const haptic::Measurement &found,
                                         const haptic::Rectangle &region) {
  const auto x = static_cast<float>(region.x);
  const auto y = static_cast<float>(region.y);
  const auto width = static_cast<float>(region.width);
  const auto height = static_cast<float>(region.height);
  return haptic::estimate_velocity({.patches = found.view(),
                                    .candidates = found.candidates,
                                    .pointer_x = x + width / 2,
                                    .pointer_y = y + height / 2,
                                    .interval = 1,
                                    .region_x = x,
                                    .region_y = y,
                                    .region_width = width,
                                    .region_height = height},
                                   haptic::Average::model, haptic::ModelChoice::automatic);
}

/// A tracker and its last measurement.
class RegionTracking : public ::testing::Test {
protected:
  static constexpr int kSide = 30; // px, of the region

  explicit RegionTracking(std::unique_ptr<haptic::PatchTracker> made) : tracker(std::move(made)) {}

  const haptic::Measurement &track(Frame &previous, Frame &current,
                                   const haptic::Rectangle &region) {
    tracker->measure(crop_pair(previous, current, region, *tracker), measurement);
    return measurement;
  }
  /// The region is in the middle.
  const haptic::Measurement &track(Frame &previous, Frame &current) {
    return track(previous, current,
                 {(previous.width - kSide) / 2, (previous.height - kSide) / 2, kSide, kSide});
  }

  static Shift mean(const haptic::Measurement &found) {
    Shift sum;
    for (const haptic::Patch &patch : found.view()) {
      sum.x += static_cast<double>(patch.dx) / found.count;
      sum.y += static_cast<double>(patch.dy) / found.count;
    }
    return sum;
  }

  std::unique_ptr<haptic::PatchTracker> tracker;
  haptic::Measurement measurement;
};

} // namespace test
