// SPDX-License-Identifier: LGPL-2.1-or-later
// The peers: OpenCV's methods, each with the same pixels as the fast tracker.
#include "methods/methods.hpp"
#include "tracking/region.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#ifdef HAVE_OPTFLOW
#include <opencv2/optflow/rlofflow.hpp>
#endif

namespace lab {
namespace {

// The part of both frames that a method reads.
struct Part {
  cv::Mat previous;
  cv::Mat current;
  cv::Rect region; // in the part
};

// The same margin around the region as the fast tracker's.
Part crop(const Task &task) {
  static const auto reference = haptic::make_fast_tracker();
  const int width = task.previous.cols;
  const int height = task.previous.rows;
  const auto region = haptic::region_at(task.pointer.x, task.pointer.y, task.side, width, height);
  const auto around = haptic::crop_around(region, reference->margin(task.side), width, height);
  const cv::Rect rect(around.x, around.y, around.width, around.height);
  return {task.previous(rect),
          task.current(rect),
          {region.x - around.x, region.y - around.y, region.width, region.height}};
}

Part whole(const Task &task) {
  const auto region = haptic::region_at(task.pointer.x, task.pointer.y, task.side,
                                        task.previous.cols, task.previous.rows);
  return {task.previous, task.current, {region.x, region.y, region.width, region.height}};
}

Reading measured(double x, double y, double confidence = 1) {
  if (!std::isfinite(x) || !std::isfinite(y))
    return {};
  return {.velocity = {x, y}, .confidence = confidence};
}

float median(std::vector<float> &values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

constexpr int kGrid = 0; // instead of a number of corners: 4x4 points evenly spread

std::vector<cv::Point2f> places(const Part &part, int corners) {
  std::vector<cv::Point2f> points;
  const cv::Rect &r = part.region;
  const cv::Point2f origin(static_cast<float>(r.x), static_cast<float>(r.y));
  if (corners == kGrid) {
    constexpr int kParts = 4;
    for (int j = 0; j < kParts; ++j)
      for (int i = 0; i < kParts; ++i)
        points.push_back(
            origin +
            cv::Point2f((static_cast<float>(i) + 0.5F) * static_cast<float>(r.width),
                        (static_cast<float>(j) + 0.5F) * static_cast<float>(r.height)) /
                kParts -
            cv::Point2f(0.5F, 0.5F));
    return points;
  }
  cv::goodFeaturesToTrack(part.previous(r), points, corners, 0.01, 3);
  for (auto &point : points)
    point += origin;
  return points;
}

// The mean of the found points. With forward–backward check, the median of the points that return
// to within half a pixel.
template <typename Track>
Reading follow(const Part &part, int corners, bool back_check, const Track &track) {
  std::vector<cv::Point2f> start = places(part, corners);
  if (start.empty())
    return {};
  std::vector<cv::Point2f> end;
  std::vector<cv::Point2f> back;
  std::vector<std::uint8_t> found;
  std::vector<std::uint8_t> found_back;
  track(part.previous, part.current, start, end, found);
  if (back_check)
    track(part.current, part.previous, end, back, found_back);
  std::vector<float> x;
  std::vector<float> y;
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!found[i] || (back_check && (!found_back[i] || cv::norm(back[i] - start[i]) > 0.5)))
      continue;
    x.push_back(end[i].x - start[i].x);
    y.push_back(end[i].y - start[i].y);
  }
  if (x.empty())
    return {};
  const double share = static_cast<double>(x.size()) / static_cast<double>(start.size());
  if (back_check)
    return measured(median(x), median(y), share);
  return measured(cv::mean(x)[0], cv::mean(y)[0], share);
}

struct LucasKanade {
  bool full_frame;
  int window; // px
  int levels;
  int corners;
  bool back_check;
};

// As OpenCV ships it.
constexpr LucasKanade kShipped{.full_frame = false,
                               .window = 21,
                               .levels = 4,
                               .corners = haptic::kUsualPatches,
                               .back_check = false};

class PyrLk final : public Method {
public:
  explicit PyrLk(const LucasKanade &knobs) : knobs_(knobs) {}
  Reading measure(const Task &task) override {
    return follow(
        knobs_.full_frame ? whole(task) : crop(task), knobs_.corners, knobs_.back_check,
        [&](const cv::Mat &from, const cv::Mat &to, const auto &start, auto &end, auto &found) {
          cv::calcOpticalFlowPyrLK(from, to, start, end, found, cv::noArray(),
                                   {knobs_.window, knobs_.window}, knobs_.levels - 1);
        });
  }

private:
  LucasKanade knobs_;
};

#ifdef HAVE_OPTFLOW
struct RlofKnobs {
  int window;
  int top_level;
  bool illumination;
};

class Rlof final : public Method {
public:
  explicit Rlof(const RlofKnobs &knobs)
      : parameters_(cv::optflow::RLOFOpticalFlowParameter::create()) {
    parameters_->setLargeWinSize(knobs.window);
    parameters_->setSmallWinSize(std::min(9, knobs.window));
    parameters_->setMaxLevel(knobs.top_level);
    parameters_->setUseIlluminationModel(knobs.illumination);
    // The global motion prior costs 58 ms, a hundred times the rest; cross-shaped supports need
    // colour.
    parameters_->setUseGlobalMotionPrior(false);
    parameters_->setSupportRegionType(cv::optflow::SR_FIXED);
  }
  Reading measure(const Task &task) override {
    return follow(
        crop(task), haptic::kUsualPatches, false,
        [&](const cv::Mat &from, const cv::Mat &to, const auto &start, auto &end, auto &found) {
          cv::optflow::calcOpticalFlowSparseRLOF(from, to, start, end, found, cv::noArray(),
                                                 parameters_);
        });
  }

private:
  cv::Ptr<cv::optflow::RLOFOpticalFlowParameter> parameters_;
};
#endif

Reading mean_over(const cv::Mat &flow, const cv::Rect &region) {
  const cv::Scalar mean = cv::mean(flow(region));
  return measured(mean[0], mean[1]);
}

class Dis final : public Method {
public:
  Dis(int preset, int finest_scale, bool means) : dis_(cv::DISOpticalFlow::create(preset)) {
    if (finest_scale >= 0)
      dis_->setFinestScale(finest_scale);
    dis_->setUseMeanNormalization(means);
  }
  Reading measure(const Task &task) override {
    const Part part = crop(task);
    flow_.release(); // else it begins with the flow of the frames before
    // It accepts only contiguous rows.
    dis_->calc(part.previous.clone(), part.current.clone(), flow_);
    return mean_over(flow_, part.region);
  }

private:
  cv::Ptr<cv::DISOpticalFlow> dis_;
  cv::Mat flow_;
};

struct FarnebackKnobs {
  int window;
  int levels;
  int neighbourhood;
};

class Farneback final : public Method {
public:
  explicit Farneback(const FarnebackKnobs &knobs) : knobs_(knobs) {}
  Reading measure(const Task &task) override {
    constexpr int kIterations = 3;
    const Part part = crop(task);
    cv::calcOpticalFlowFarneback(part.previous, part.current, flow_, 0.5, knobs_.levels,
                                 knobs_.window, kIterations, knobs_.neighbourhood,
                                 knobs_.neighbourhood == 5 ? 1.1 : 1.5, 0);
    return mean_over(flow_, part.region);
  }

private:
  FarnebackKnobs knobs_;
  cv::Mat flow_;
};

class Phase final : public Method {
public:
  Phase(bool hann, int margin) : hann_(hann), margin_(margin) {}
  Reading measure(const Task &task) override {
    const Part part = crop(task);
    const cv::Rect area =
        (part.region + cv::Size(2 * margin_, 2 * margin_) - cv::Point(margin_, margin_)) &
        cv::Rect({}, part.previous.size());
    part.previous(area).convertTo(previous_, CV_32F);
    part.current(area).convertTo(current_, CV_32F);
    if (hann_ && window_.size() != area.size())
      cv::createHanningWindow(window_, area.size(), CV_32F);
    double response = 0;
    const Vector shift =
        cv::phaseCorrelate(previous_, current_, hann_ ? window_ : cv::noArray(), &response);
    return measured(shift.x, shift.y, std::clamp(response, 0.0, 1.0));
  }

private:
  bool hann_;
  int margin_;
  cv::Mat window_;
  cv::Mat previous_;
  cv::Mat current_;
};

class Ecc final : public Method {
public:
  Ecc(int iterations, int blur) : iterations_(iterations), blur_(blur) {}
  Reading measure(const Task &task) override {
    const Part part = crop(task);
    cv::Mat1f warp(cv::Matx23f::eye());
    // The template is the region, so the warp begins at its corner in the search image.
    warp(0, 2) = static_cast<float>(part.region.x);
    warp(1, 2) = static_cast<float>(part.region.y);
    try {
      const double correlation = cv::findTransformECC(
          part.previous(part.region).clone(), part.current, warp, cv::MOTION_TRANSLATION,
          {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, iterations_, 1e-3}, cv::noArray(),
          blur_);
      return measured(static_cast<double>(warp(0, 2)) - part.region.x,
                      static_cast<double>(warp(1, 2)) - part.region.y,
                      std::clamp(correlation, 0.0, 1.0));
    } catch (const cv::Exception &) { // its way of saying that it did not converge
      return {};
    }
  }

private:
  int iterations_;
  int blur_;
};

// Every integer displacement in reach, then a parabola through the best and its neighbours.
class BlockSearch final : public Method {
public:
  BlockSearch(int reach, int measure) : reach_(reach), measure_(measure) {}
  Reading measure(const Task &task) override {
    const Part part = crop(task);
    const cv::Rect area =
        (part.region + cv::Size(2 * reach_, 2 * reach_) - cv::Point(reach_, reach_)) &
        cv::Rect({}, part.previous.size());
    cv::matchTemplate(part.current(area), part.previous(part.region), scores_, measure_);
    cv::Point best;
    double score = 0;
    if (measure_ == cv::TM_SQDIFF)
      cv::minMaxLoc(scores_, nullptr, nullptr, &best);
    else
      cv::minMaxLoc(scores_, nullptr, &score, nullptr, &best);
    const auto at = [&](int x, int y) { return static_cast<double>(scores_.at<float>(y, x)); };
    const auto vertex = [](double before, double here, double after) {
      const double curvature = before - 2 * here + after;
      return curvature == 0 ? 0 : std::clamp((before - after) / (2 * curvature), -0.5, 0.5);
    };
    double x = best.x + area.x - part.region.x;
    double y = best.y + area.y - part.region.y;
    if (best.x > 0 && best.x + 1 < scores_.cols)
      x += vertex(at(best.x - 1, best.y), at(best.x, best.y), at(best.x + 1, best.y));
    if (best.y > 0 && best.y + 1 < scores_.rows)
      y += vertex(at(best.x, best.y - 1), at(best.x, best.y), at(best.x, best.y + 1));
    return measured(x, y, measure_ == cv::TM_SQDIFF ? 1 : std::clamp(score, 0.0, 1.0));
  }

private:
  int reach_;
  int measure_;
  cv::Mat scores_;
};

class Zero final : public Method {
public:
  Reading measure(const Task &) override { return {.confidence = 1}; }
};

class List {
public:
  template <typename M, typename... Arguments>
  void add(std::string method, std::string parameters, bool is_default, Arguments... arguments) {
    if (quick_ && !is_default)
      return;
    configurations.push_back({std::move(method), std::move(parameters), true, is_default,
                              [=] { return std::make_unique<M>(arguments...); }});
  }

  explicit List(bool quick) : quick_(quick) {}
  std::vector<Configuration> configurations;

private:
  bool quick_;
};

std::string knob(const char *name, int value) {
  return std::string(name) + "=" + std::to_string(value);
}

void add_lucas_kanade(List &list, bool full_frame) {
  const std::vector<int> all_corners =
      full_frame ? std::vector{kGrid, 20} : std::vector{kGrid, 8, 20, 32};
  for (const int window : {7, 9, 11, 15, 21})
    for (int levels = full_frame ? 3 : 1; levels <= 4; ++levels)
      for (const int corners : all_corners)
        for (const bool back_check : {false, true}) {
          const std::string where = corners == kGrid ? "grid" : knob("corners", corners);
          list.add<PyrLk>(
              std::string(full_frame ? "PyrLK frame" : "PyrLK crop") + (back_check ? " back" : ""),
              knob("window", window) + " " + knob("levels", levels) + " " + where,
              window == kShipped.window && levels == kShipped.levels && corners == kShipped.corners,
              LucasKanade{full_frame, window, levels, corners, back_check});
        }
}

void add_dense(List &list) {
  const struct {
    const char *name;
    int preset;
  } presets[] = {{"DIS ultrafast", cv::DISOpticalFlow::PRESET_ULTRAFAST},
                 {"DIS fast", cv::DISOpticalFlow::PRESET_FAST},
                 {"DIS medium", cv::DISOpticalFlow::PRESET_MEDIUM}};
  for (const auto &[name, preset] : presets)
    for (const int finest : {-1, 0, 1, 2})
      for (const bool means : {true, false})
        list.add<Dis>(name,
                      (finest < 0 ? "scale of the preset" : knob("finest-scale", finest)) +
                          (means ? "" : " without means"),
                      finest < 0 && means, preset, finest, means);
  for (const int window : {7, 9, 11, 15, 21})
    for (const int levels : {1, 3})
      for (const int neighbourhood : {5, 7})
        list.add<Farneback>("Farneback",
                            knob("window", window) + " " + knob("levels", levels) + " " +
                                knob("poly", neighbourhood),
                            window == 15 && levels == 3 && neighbourhood == 5,
                            FarnebackKnobs{window, levels, neighbourhood});
}

} // namespace

Configuration lucas_kanade_of(int points) {
  LucasKanade knobs = kShipped;
  knobs.corners = points;
  return {"PyrLK crop", knob("corners", points), true, false,
          [knobs] { return std::make_unique<PyrLk>(knobs); }};
}

std::vector<Configuration> peer_configurations(bool quick) {
  List list(quick);
  add_lucas_kanade(list, false);
  add_lucas_kanade(list, true);
#ifdef HAVE_OPTFLOW
  for (const int window : {9, 15, 21})
    for (const int levels : {1, 2, 3, 4})
      for (const bool illumination : {true, false})
        list.add<Rlof>("RLOF",
                       knob("window", window) + " " + knob("levels", levels) +
                           (illumination ? "" : " without illumination"),
                       window == 21 && levels == 4 && illumination,
                       RlofKnobs{window, levels - 1, illumination});
#endif
  add_dense(list);
  for (const int margin : {0, 8, 16})
    for (const bool hann : {true, false})
      list.add<Phase>("phase correlation", knob("margin", margin) + (hann ? " Hann" : ""),
                      margin == 8 && hann, hann, margin);
  for (const int iterations : {10, 50, 200})
    for (const int blur : {1, 3, 5})
      list.add<Ecc>("ECC", knob("iterations", iterations) + " " + knob("blur", blur),
                    iterations == 50 && blur == 5, iterations, blur);
  for (const int reach : {4, 8, 18})
    for (const int measure :
         {static_cast<int>(cv::TM_SQDIFF), static_cast<int>(cv::TM_CCOEFF_NORMED)})
      list.add<BlockSearch>("block search",
                            knob("reach", reach) + (measure == cv::TM_SQDIFF ? " SSD" : " ZNCC"),
                            reach == 18 && measure == cv::TM_SQDIFF, reach, measure);
  list.add<Zero>("always zero", "", true);
  return std::move(list.configurations);
}

} // namespace lab
