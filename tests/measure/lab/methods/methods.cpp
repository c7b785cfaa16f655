// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/methods.hpp"

#include "plane-source.hpp"
#include "tracking/region.hpp"

#include <algorithm>
#include <iterator>

namespace lab {
namespace {

haptic::LumaView view(const cv::Mat &frame, const haptic::Rectangle &crop) {
  return {frame.ptr(crop.y) + crop.x, crop.width, crop.height,
          static_cast<std::ptrdiff_t>(frame.step)};
}

constexpr float kInterval = 1.0F / 30; // s

struct Knobs {
  haptic::FastTrackerOptions options{};
  int points = haptic::kUsualPatches;
  Estimator estimator{};
};

std::unique_ptr<Method> make_fast(const Knobs &knobs) {
  auto tracker = haptic::make_fast_tracker(knobs.options);
  tracker->set_max_points(knobs.points);
  return std::make_unique<TrackerMethod>(std::move(tracker), knobs.estimator);
}

// A number as text, without trailing zeros.
std::string text(float value) {
  std::string digits = std::to_string(value);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.ends_with('.'))
    digits.pop_back();
  return digits;
}

void add_fast(std::vector<Configuration> &list, std::string parameters, const Knobs &knobs) {
  list.push_back(
      {"fast", std::move(parameters), false, false, [knobs] { return make_fast(knobs); }});
}

std::string text_of_points(int points) {
  return "points=" + std::to_string(points);
}

void add_opencv(std::vector<Configuration> &list, int points) {
  list.push_back(
      {"method=opencv", text_of_points(points), false, points == haptic::kUsualPatches, [points] {
         auto tracker = haptic::make_opencv_tracker();
         tracker->set_max_points(points);
         return std::make_unique<TrackerMethod>(std::move(tracker));
       }});
}

} // namespace

Reading estimate(const haptic::Measurement &measurement, const haptic::Rectangle &region,
                 const Task &task, const Estimator &estimator, haptic::ModelHistory &history) {
  const haptic::VelocityEstimate estimate = haptic::estimate_velocity(
      {.patches = measurement.view(),
       .candidates = measurement.candidates,
       .pointer_x = static_cast<float>(task.pointer.x * task.current.cols),
       .pointer_y = static_cast<float>(task.pointer.y * task.current.rows),
       .interval = static_cast<double>(kInterval),
       .region_x = static_cast<float>(region.x),
       .region_y = static_cast<float>(region.y),
       .region_width = static_cast<float>(region.width),
       .region_height = static_cast<float>(region.height),
       .is_tiled = (measurement.flags & haptic::kTiled) != 0,
       .parts = estimator.parts},
      estimator.average, estimator.choice, history);
  history = estimate.history;
  return {.velocity =
              Vector(estimate.velocity_x, estimate.velocity_y) * static_cast<double>(kInterval),
          .confidence = estimate.confidence,
          .spin = estimate.spin * static_cast<double>(kInterval),
          .divergence = estimate.divergence * static_cast<double>(kInterval),
          .model = estimate.model};
}

TrackerMethod::TrackerMethod(std::unique_ptr<haptic::PatchTracker> tracker,
                             const Estimator &estimator)
    : tracker_(std::move(tracker)), estimator_(estimator) {}

Reading TrackerMethod::measure(const Task &task) {
  const int width = task.previous.cols;
  const int height = task.previous.rows;
  const haptic::Rectangle region =
      haptic::region_at(task.pointer.x, task.pointer.y, task.side, width, height);
  if (!haptic::is_measurable(region))
    return {};
  const haptic::Rectangle crop =
      haptic::crop_around(region, tracker_->margin(task.side), width, height);
  const test::PlaneSource earlier(view(task.previous, {0, 0, width, height}));
  const test::PlaneSource later(view(task.current, {0, 0, width, height}));
  const haptic::FramePair frames{earlier, later, width, height};
  tracker_->measure({.previous = view(task.previous, crop),
                     .current = view(task.current, crop),
                     .crop = crop,
                     .region = region,
                     .continues = task.continues,
                     .frames = &frames,
                     .seconds = kInterval},
                    measurement_);
  if (!task.continues || !estimator_.has_history || (measurement_.flags & haptic::kCut))
    history_ = {};
  if (measurement_.flags & haptic::kCut)
    return {};
  if (measurement_.flags & haptic::kStill) {
    history_ = {.current = haptic::MotionModel::still};
    return {.confidence = 1, .model = haptic::MotionModel::still};
  }
  return estimate(measurement_, region, task, estimator_, history_);
}

std::unique_ptr<Method> make_default() {
  auto tracker = haptic::make_layer_tracker();
  tracker->set_max_points(haptic::kUsualPatches);
  return std::make_unique<TrackerMethod>(std::move(tracker));
}

std::unique_ptr<Method> make_fast() {
  return make_fast(Knobs{});
}

std::vector<Configuration> configurations(bool quick) {
  std::vector<Configuration> list;
  add_fast(list, "default", {});
  list.front().is_default = true;
  add_fast(list, "always-grid", {.options = {.always_grid = true}});
  add_fast(list, "spacing=10", {.options = {.spacing = 10}});
  if (!quick) {
    // Two parameters that trade speed for accuracy are swept together, each other one alone.
    for (const bool always_grid : {false, true})
      for (const float spacing : {4.0F, 5.0F, 6.0F, 7.5F, 10.0F, 15.0F})
        for (const int iterations : {1, 2, 3, 4, 6, 10}) {
          const haptic::FastTrackerOptions options{
              .spacing = spacing, .iterations = iterations, .always_grid = always_grid};
          add_fast(list,
                   "spacing=" + text(spacing) + " iterations=" + std::to_string(iterations) +
                       (always_grid ? " always-grid" : ""),
                   {.options = options, .points = haptic::kMaxPatches});
        }
    for (const int levels : {1, 2, 4, 5})
      add_fast(list, "levels=" + std::to_string(levels), {.options = {.levels = levels}});
    for (const int points : {4, 8, 16, 32, 64})
      add_fast(list, text_of_points(points), {.points = points});
    add_fast(list, "average=mean", {.estimator = {.average = haptic::Average::mean}});
    add_fast(list, "average=median", {.estimator = {.average = haptic::Average::median}});
    add_fast(list, "model=translation",
             {.estimator = {.choice = haptic::ModelChoice::translation}});
    add_fast(list, "model=similarity", {.estimator = {.choice = haptic::ModelChoice::similarity}});
    add_fast(list, "model=affine", {.estimator = {.choice = haptic::ModelChoice::affine}});
  }
  for (const int points : quick ? std::vector{haptic::kUsualPatches} : std::vector{8, 20, 32})
    add_opencv(list, points);
  std::ranges::move(peer_configurations(quick), std::back_inserter(list));
  return list;
}

std::vector<Configuration> configurations_without_parts() {
  std::vector<Configuration> list;
  const auto tracker = [&](const char *name, bool haptic::TrackerParts::*part) {
    Knobs knobs;
    knobs.options.parts.*part = false;
    add_fast(list, name, knobs);
  };
  const auto estimator = [&](const char *name, bool haptic::EstimateParts::*part) {
    Knobs knobs;
    knobs.estimator.parts.*part = false;
    add_fast(list, name, knobs);
  };
  using haptic::EstimateParts;
  using haptic::TrackerParts;
  tracker("test for unchanged pixels", &TrackerParts::still_pixels);
  tracker("rest of a zero translation", &TrackerParts::still_translation);
  tracker("sudden changes", &TrackerParts::sudden);
  tracker("prior", &TrackerParts::prior);
  tracker("search", &TrackerParts::search);
  tracker("period", &TrackerParts::period);
  add_fast(list, "one translation", {.options = {.always_grid = true}});
  tracker("coarse starts", &TrackerParts::coarse_starts);
  tracker("dither", &TrackerParts::dither);
  tracker("bend", &TrackerParts::bend);
  tracker("second pass", &TrackerParts::second_pass);
  tracker("strain", &TrackerParts::strain);
  tracker("noise at rest", &TrackerParts::noise_at_rest);
  tracker("noise of fits", &TrackerParts::noise_of_fits);
  tracker("trust", &TrackerParts::trust);
  tracker("cut", &TrackerParts::cut);
  tracker("votes", &TrackerParts::votes);
  tracker("labels", &TrackerParts::labels);
  tracker("layers", &TrackerParts::layers);
  add_fast(list, "models beyond translation",
           {.estimator = {.choice = haptic::ModelChoice::translation}});
  add_fast(list, "models below affine", {.estimator = {.choice = haptic::ModelChoice::affine}});
  estimator("second motion", &EstimateParts::second_motion);
  estimator("neighbours", &EstimateParts::neighbours);
  estimator("doubt of pixels", &EstimateParts::pixel_confidence);
  add_fast(list, "history of models", {.estimator = {.has_history = false}});
  return list;
}

std::vector<Configuration> configurations_of(int points) {
  std::vector<Configuration> list;
  add_fast(list, text_of_points(points), {.points = points});
  add_opencv(list, points);
  list.push_back(lucas_kanade_of(points));
  return list;
}

} // namespace lab
