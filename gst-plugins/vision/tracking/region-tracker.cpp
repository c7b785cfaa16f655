// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/region-tracker.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace haptic {
namespace {

std::unique_ptr<PatchTracker> make_tracker(TrackerMethod method) {
  switch (method) {
  case TrackerMethod::opencv:
    return make_opencv_tracker();
  case TrackerMethod::layers:
    return make_layer_tracker();
  default:
    return make_fast_tracker();
  }
}

} // namespace

bool is_identical(const LumaView &one, const LumaView &other) {
  for (int y = 0; y < one.height; ++y)
    if (std::memcmp(one.pixels + y * one.stride, other.pixels + y * other.stride,
                    static_cast<std::size_t>(one.width)) != 0)
      return false;
  return true;
}

void RegionTracker::set_method(TrackerMethod method, int max_points) {
  if (std::exchange(method_, method) != method) {
    tracker_ = make_tracker(method);
    earlier_was_measured_ = false;
  }
  tracker_->set_max_points(max_points);
}

Areas RegionTracker::areas(const Rectangle &region, int frame_width, int frame_height) const {
  const int margin = tracker_->margin(std::max(region.width, region.height));
  return {region, crop_around(region, margin, frame_width, frame_height), frame_width,
          frame_height};
}

// The views of the pair are valid afterwards only if the pixels changed.
Repetition RegionTracker::repetition(const LumaSource &earlier, const LumaSource &frame,
                                     const CropPair &pair) {
  const bool same_here = is_identical(pair.previous, pair.current);
  return judge_.judge(same_here, [&] {
    return moving_crop_ == Rectangle{} || moving_crop_ == pair.crop ||
           is_identical(earlier_luma_.read(earlier, moving_crop_), luma_.read(frame, moving_crop_));
  });
}

// A frame that the tracker cannot measure is a gap, not the end of the stream.
void RegionTracker::run(const CropPair &pair, Finding &finding) {
  try {
    tracker_->measure(pair, measurement_);
  } catch (const std::exception &error) {
    finding.error = error.what();
    measurement_.clear();
    tracker_->reset();
  }
}

Finding RegionTracker::compare(const LumaSource &earlier, const LumaSource &frame,
                               const Areas &areas, std::uint64_t interval) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  luma_.forget();
  const FramePair frames{earlier, frame, areas.frame_width, areas.frame_height};
  CropPair pair{earlier_luma_.read(earlier, areas.crop),
                luma_.read(frame, areas.crop),
                areas.crop,
                areas.region,
                earlier_was_measured_,
                repeats_,
                &frames,
                1e-9F * static_cast<float>(interval)};
  Finding finding;
  switch (repetition(earlier, frame, pair)) {
  case Repetition::duplicate:
    // The next interval then spans both frames, as its displacement does. The earlier frame stays
    // the one that the tracker saw last.
    return {.flags = kMotionDuplicate, .becomes_reference = false};
  case Repetition::still:
    if (!tracker_->measures_unchanged()) {
      finding.flags = kMotionStill;
      ++repeats_;
      break;
    }
    pair.previous = earlier_luma_.read(earlier, areas.crop);
    pair.current = luma_.read(frame, areas.crop);
    run(pair, finding);
    finding.flags = measurement_.flags;
    finding.time = Clock::now() - begin;
    break;
  case Repetition::none:
    moving_crop_ = areas.crop;
    repeats_ = 0;
    run(pair, finding);
    finding.flags = measurement_.flags;
    finding.time = Clock::now() - begin;
    break;
  }
  earlier_was_measured_ = finding.time.has_value();
  std::swap(earlier_luma_, luma_);
  return finding;
}

void RegionTracker::skip() {
  earlier_luma_.forget();
  earlier_was_measured_ = false;
}

void RegionTracker::forget() {
  skip();
  judge_.forget();
  repeats_ = 0;
  moving_crop_ = {};
  tracker_->reset();
}

} // namespace haptic
