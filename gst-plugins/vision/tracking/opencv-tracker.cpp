// SPDX-License-Identifier: LGPL-2.1-or-later
// The method of the paper on the crop (section 3.2.1): corners after Shi and Tomasi (1994),
// displacements after Lucas and Kanade on image pyramids (Bouguet 2000), both from OpenCV.
#include "pixels/tensor.hpp"
#include "tracking/noise-estimate.hpp"
#include "tracking/patch-tracker.hpp"
#include "tracking/region.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

namespace haptic {
namespace {

// Window, levels and margin were chosen together: a small window stays on one object and costs
// little, a fourth level reaches 16 px and more per frame, and the margin keeps the windows of the
// coarse levels inside the crop after so large a displacement.
constexpr int kWindow = 11;        // px
constexpr int kSmallMargin = 36;   // px, for a region of kPaperSide
constexpr int kLargestMargin = 96; // px
constexpr int kSmallTopLevel = 3;
constexpr int kLargestTopLevel = 5;

constexpr double kCornerQuality = 0.01; // of the best corner's eigenvalue
constexpr int kIterations = 10;
constexpr double kStep = 0.01;         // px
constexpr float kBackCheck = 0.5F;     // px
constexpr float kTextureOverNoise = 3; // least eigenvalue over what noise alone gives

// Sum of the kernel (3 10 3) x (-1 0 1) on a slope of 1 per px.
constexpr float kScharrGain = 32;
// Variance of the normalised gradient from white noise of variance 1.
constexpr float kScharrNoise = 2.0F * (3 * 3 + 10 * 10 + 3 * 3) / (kScharrGain * kScharrGain);

cv::Mat as_mat(const LumaView &view) {
  // OpenCV has no type for pixels that are only read.
  return {view.height, view.width, CV_8UC1, const_cast<std::uint8_t *>(view.pixels),
          static_cast<std::size_t>(view.stride)};
}

bool is_inside(const cv::Point2f &place, const cv::Mat &image) {
  return place.x >= 0 && place.y >= 0 && place.x <= static_cast<float>(image.cols - 1) &&
         place.y <= static_cast<float>(image.rows - 1);
}

// Bilinear interpolation; `place` is inside the image.
float bilinear(const cv::Mat &image, const cv::Point2f &place) {
  const int left = std::min(static_cast<int>(place.x), image.cols - 2);
  const int top = std::min(static_cast<int>(place.y), image.rows - 2);
  const float a = place.x - static_cast<float>(left);
  const float b = place.y - static_cast<float>(top);
  const auto *upper = image.ptr<std::uint8_t>(top) + left;
  const auto *lower = image.ptr<std::uint8_t>(top + 1) + left;
  return (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
}

// Gradient after Scharr; the pixel is not on the border.
Displacement gradient(const cv::Mat &image, int x, int y) {
  const auto *above = image.ptr<std::uint8_t>(y - 1);
  const auto *row = image.ptr<std::uint8_t>(y);
  const auto *below = image.ptr<std::uint8_t>(y + 1);
  const float gx =
      static_cast<float>(3 * (above[x + 1] - above[x - 1]) + 10 * (row[x + 1] - row[x - 1]) +
                         3 * (below[x + 1] - below[x - 1])) /
      kScharrGain;
  const float gy =
      static_cast<float>(3 * (below[x - 1] - above[x - 1]) + 10 * (below[x] - above[x]) +
                         3 * (below[x + 1] - above[x + 1])) /
      kScharrGain;
  return {gx, gy};
}

// Sums over a window of the earlier frame.
struct WindowSums {
  Tensor structure;
  float squares = 0; // of the differences to the displaced pixels of the later frame
  int compared = 0;  // pixels that are inside the later frame after the displacement
};

WindowSums sums_over(const cv::Rect &window, const cv::Mat &previous, const cv::Mat &current,
                     const cv::Point2f &shift) {
  WindowSums sums;
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x) {
      const auto [gx, gy] = gradient(previous, x, y);
      sums.structure += {gx * gx, gx * gy, gy * gy};
      const cv::Point2f there = cv::Point2f(static_cast<float>(x), static_cast<float>(y)) + shift;
      if (is_inside(there, current)) {
        const float difference = bilinear(current, there) - previous.ptr<std::uint8_t>(y)[x];
        sums.squares += difference * difference;
        ++sums.compared;
      }
    }
  return sums;
}

class OpencvTracker final : public PatchTracker {
public:
  int margin(int region_side) const override {
    return std::clamp(kSmallMargin * region_side / kPaperSide, kSmallMargin, kLargestMargin);
  }

  void set_max_points(int max_points) override {
    max_points_ = std::clamp(max_points, 1, kMaxPatches);
  }

  void measure(const CropPair &pair, Measurement &measurement) override {
    measurement.clear();
    // OpenCV spreads even this little work over a pool of threads, and the switch against it holds
    // for the whole application. But a parallel section does not start another one, and a section
    // of one part runs in the thread of its caller.
    cv::parallel_for_(cv::Range(0, 1),
                      [&](const cv::Range &) { measure_in_this_thread(pair, measurement); });
  }

  void reset() override {}

private:
  void measure_in_this_thread(const CropPair &pair, Measurement &measurement) {
    const cv::Mat previous = as_mat(pair.previous);
    const cv::Mat current = as_mat(pair.current);
    find_corners(previous, {pair.region.x - pair.crop.x, pair.region.y - pair.crop.y,
                            pair.region.width, pair.region.height});
    measurement.candidates = static_cast<int>(corners_.size());
    if (corners_.empty())
      return;

    const int top_level =
        std::min(kSmallTopLevel + doublings(std::max(pair.region.width, pair.region.height)),
                 kLargestTopLevel);
    const cv::Size window(kWindow, kWindow);
    const cv::TermCriteria enough(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations,
                                  kStep);
    cv::buildOpticalFlowPyramid(previous, previous_pyramid_, window, top_level);
    cv::buildOpticalFlowPyramid(current, current_pyramid_, window, top_level);
    cv::calcOpticalFlowPyrLK(previous_pyramid_, current_pyramid_, corners_, forward_, found_,
                             cv::noArray(), window, top_level, enough);
    cv::calcOpticalFlowPyrLK(current_pyramid_, previous_pyramid_, forward_, backward_, found_back_,
                             cv::noArray(), window, top_level, enough);
    for (std::size_t i = 0; i < corners_.size(); ++i)
      if (came_back(i) && is_inside(forward_[i], current))
        add_patch(i, previous, current, pair.crop, measurement);
  }

  void find_corners(const cv::Mat &previous, const cv::Rect &region) {
    // The region is a part of a larger image: OpenCV reads the pixels around it, so that its border
    // makes no corners.
    const double spacing = std::max(3.0, 0.1 * std::max(region.width, region.height));
    cv::goodFeaturesToTrack(previous(region), corners_, max_points_, kCornerQuality, spacing);
    // Interpolation draws a displacement towards whole pixels, by some hundredths of a pixel. With
    // starts a quarter of a pixel off the grid, on either side in turn, these errors cancel in the
    // mean.
    float offset = 0.25F;
    for (auto &corner : corners_) {
      corner +=
          cv::Point2f(static_cast<float>(region.x) + offset, static_cast<float>(region.y) + offset);
      offset = -offset;
    }
  }

  bool came_back(std::size_t i) const {
    const cv::Point2f miss = backward_[i] - corners_[i];
    return found_[i] && found_back_[i] && std::hypot(miss.x, miss.y) <= kBackCheck;
  }

  // Adds the patch around corner i unless its texture may be noise.
  void add_patch(std::size_t i, const cv::Mat &previous, const cv::Mat &current,
                 const Rectangle &crop, Measurement &measurement) const {
    const cv::Point2f start = corners_[i];
    const cv::Point2f shift = forward_[i] - start;
    const cv::Rect window =
        cv::Rect(cvRound(start.x) - kWindow / 2, cvRound(start.y) - kWindow / 2, kWindow, kWindow) &
        cv::Rect(1, 1, previous.cols - 2, previous.rows - 2);
    if (window.empty())
      return;

    const WindowSums sums = sums_over(window, previous, current, shift);
    if (sums.compared == 0)
      return;
    const float residual = std::sqrt(sums.squares / static_cast<float>(sums.compared));
    // The residual holds the noise of both frames.
    const float noise = std::max(kAssumedNoise * kAssumedNoise, residual * residual / 2);
    if (eigenvalues(sums.structure).least <
        kTextureOverNoise * kScharrNoise * noise * static_cast<float>(window.area()))
      return;

    // Least squares between two noisy windows: the displacement's covariance is 2 sigma^2 H^-1.
    const Tensor precision = 1 / (2 * kAssumedNoise * kAssumedNoise) * sums.structure;
    Patch patch{};
    patch.x = static_cast<float>(crop.x) + start.x + 0.5F; // OpenCV counts from a pixel's centre
    patch.y = static_cast<float>(crop.y) + start.y + 0.5F;
    patch.width = kWindow;
    patch.height = kWindow;
    patch.dx = shift.x;
    patch.dy = shift.y;
    patch.precision_xx = precision.xx;
    patch.precision_xy = precision.xy;
    patch.precision_yy = precision.yy;
    patch.residual = residual;
    measurement.add(patch);
  }

  int max_points_ = kUsualPatches;

  // Members only to keep their memory from frame to frame.
  std::vector<cv::Mat> previous_pyramid_;
  std::vector<cv::Mat> current_pyramid_;
  std::vector<cv::Point2f> corners_;
  std::vector<cv::Point2f> forward_;
  std::vector<cv::Point2f> backward_;
  std::vector<std::uint8_t> found_;
  std::vector<std::uint8_t> found_back_;
};

} // namespace

std::unique_ptr<PatchTracker> make_opencv_tracker() {
  return std::make_unique<OpencvTracker>();
}

} // namespace haptic
