// SPDX-License-Identifier: LGPL-2.1-or-later
// The methods that are compared: the project's trackers and their peers. Each computes one velocity
// from two frames and a pointer.
#pragma once

#include "samples/motion-sample.hpp"
#include "scenes/scenes.hpp"
#include "tracking/patch-tracker.hpp"
#include "velocity/velocity-estimate.hpp"

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace lab {

/// The input of a method: the whole luma of both frames.
struct Task {
  cv::Mat previous;
  cv::Mat current;
  Vector pointer{0.5, 0.5}; ///< fractions of the frame
  int side = 30;            ///< px, of the region
  bool continues = false;   ///< previous was `current` of the task before
};

struct Reading {
  Vector velocity;       ///< px per frame; zero where nothing was measured
  double confidence = 0; ///< 0..1; 0: nothing was measured
  double spin = 0;       ///< rad per frame
  double divergence = 0; ///< per frame
  haptic::MotionModel model = haptic::MotionModel::none;
};

/// One instance per stream.
class Method {
public:
  virtual ~Method() = default;
  virtual Reading measure(const Task &task) = 0;
  /// Forgets the stream.
  virtual void forget() {}
};

struct Configuration {
  std::string method;
  std::string parameters;
  bool is_peer = true;
  bool is_default = false; ///< as its authors or this project ship it
  std::function<std::unique_ptr<Method>()> make;
};

/// How patches become a velocity.
struct Estimator {
  haptic::Average average = haptic::Average::model;
  haptic::ModelChoice choice = haptic::ModelChoice::automatic;
  haptic::EstimateParts parts = {};
  bool has_history = true; ///< of the choice of the model
};

/// What velocityavg makes of the patches of a frame.
Reading estimate(const haptic::Measurement &measurement, const haptic::Rectangle &region,
                 const Task &task, const Estimator &estimator, haptic::ModelHistory &history);

/// A tracker of the project and the average over its patches, as in the elements.
class TrackerMethod final : public Method {
public:
  explicit TrackerMethod(std::unique_ptr<haptic::PatchTracker> tracker,
                         const Estimator &estimator = {});
  Reading measure(const Task &task) override;
  void forget() override { tracker_->reset(); }

private:
  std::unique_ptr<haptic::PatchTracker> tracker_;
  Estimator estimator_;
  haptic::ModelHistory history_;
  haptic::Measurement measurement_;
};

std::unique_ptr<Method> make_default();

/// method=fast.
std::unique_ptr<Method> make_fast();

/// Every configuration of the sweep; `quick`: the defaults and a few more.
std::vector<Configuration> configurations(bool quick);

/// The default without one of its parts, named in `parameters`.
std::vector<Configuration> configurations_without_parts();

/// Only the peers.
std::vector<Configuration> peer_configurations(bool quick);

/// As shipped except for the number of points; only methods with that parameter.
std::vector<Configuration> configurations_of(int points);

/// Includes PyrLK on the crop.
Configuration lucas_kanade_of(int points);

} // namespace lab
