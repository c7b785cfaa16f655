// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes whose motion is known exactly, one for every way in which trackers fail.
#pragma once

#include "scenes/random.hpp"

#include <array>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace lab {

using Vector = cv::Point2d; ///< px, x to the right, y down

/// Side of the square that is rendered unless a scene asks for another, px. The region of interest
/// lies in its middle.
inline constexpr int kWindow = 144;

/// Standard deviation of the noise of a camera, 8-bit grey levels.
inline constexpr double kNoise = 1.5;

/// Where a pixel of the frame looks in the texture, both px from the middle of the window.
struct Warp {
  Vector shift;                         ///< the texture moves by so much
  std::function<Vector(Vector)> bend{}; ///< after the shift is taken back; empty: nothing more
};

/// Opaque discs of random grey that hide one another, radii distributed as in photographs (inverse
/// cube). Kept eight times finer than the frame; a pixel is the mean over its area.
class DeadLeaves {
public:
  explicit DeadLeaves(Random &random, int window = kWindow);

  /// Grey levels 0..255, before noise and rounding.
  cv::Mat1f render(const Warp &warp) const;

private:
  cv::Mat1f render_shifted(Vector shift) const;
  cv::Mat1f render_bent(const Warp &warp) const;

  int window_;
  cv::Mat1b fine_;
};

/// What a camera sees over time. The truth is constant.
struct Movie {
  std::function<cv::Mat1f(double time)> light; ///< grey levels; time in frames
  Vector velocity;                             ///< px per frame, mean over the region
  double noise = kNoise;                       ///< grey levels
  int jpeg_quality = 0;                        ///< 0: not compressed
  int h264_crf = 0;                            ///< 0: not compressed; only of a pair
  bool is_unseen = false; ///< the frames do not show the motion: only silence is right
};

struct Scene {
  std::string name;
  std::function<Movie(Random &)> make;
};

/// Every failure mode that two frames can show, those of H.264 where it is installed. The region
/// is `side` px wide.
std::vector<Scene> hard_scenes(int side);

/// The scene whose frames do not show quite the true motion but look as if they did, since an
/// encoder moved them by quarters of a pixel: that no confidence can know.
inline constexpr const char *kRoundedMotion = "h264 moving";

/// By name; throws std::out_of_range where there is none.
const Scene &scene_named(const std::vector<Scene> &scenes, const std::string &name);

/// A translation with components uniform in ±`reach`, px per frame.
Movie uniform_translation(Random &random, double reach, double noise = kNoise);

/// A translation of a fixed velocity, the contrast scaled about mid-grey.
Movie translation(Random &random, Vector velocity, double contrast = 1, int window = kWindow);

Vector on_circle(Random &random, double radius);

/// What the camera stores: light, noise, 8-bit rounding, compression of each frame on its own.
cv::Mat expose(const Movie &movie, double time, Random &random);

/// The same at the times 0 and 1, after compression that predicts a frame from those before.
std::array<cv::Mat, 2> expose_pair(const Movie &movie, Random &random);

/// The window in the middle of a larger frame, mirrored to fill it.
cv::Mat embed(const cv::Mat &window, cv::Size size);

/// The least mean end-point error that an unbiased estimate of a translation can have, given the
/// pixels of the region alone (Cramer-Rao), px.
double cramer_rao_bound(const cv::Mat1f &light, int side, double noise);

} // namespace lab
