// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/nearby-luma.hpp"

#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr int kSmoothing = 1;  // pixels that smoothing takes from each side
constexpr int kLeastSide = 10; // pixels that smoothing needs

// The view with its outermost pixels repeated on all sides.
LumaView repeat_border(const LumaView &view, int left, int top, int width, int height,
                       ByteImage &padded) {
  padded.width = width;
  padded.height = height;
  padded.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const std::uint8_t *from = view.pixels + std::clamp(y - top, 0, view.height - 1) * view.stride;
    std::uint8_t *to = padded.pixels.data() + static_cast<std::ptrdiff_t>(y) * width;
    const int right = std::min(left + view.width, width);
    std::fill_n(to, left, from[0]);
    std::copy_n(from, right - left, to + left);
    std::fill_n(to + right, width - right, from[view.width - 1]);
  }
  return padded.view();
}

} // namespace

bool LumaLayer::sample(const PatchPose &pose, PatchSamples &samples) const {
  const PatchPose in_plane{pose.a, pose.b, pose.c, pose.d, column(pose.x), row(pose.y)};
  const float across = kPatchRadius * (std::abs(pose.a) + std::abs(pose.b));
  const float down = kPatchRadius * (std::abs(pose.c) + std::abs(pose.d));
  if (!(in_plane.x - across >= 0 && in_plane.y - down >= 0 &&
        in_plane.x + across < static_cast<float>(plane.width() - 1) &&
        in_plane.y + down < static_cast<float>(plane.height() - 1)))
    return false;
  sample_plane(plane, in_plane, samples);
  return true;
}

int NearbyLuma::halvings(int frame_width, int frame_height) {
  constexpr int kEnough = 960; // px
  int times = 0;
  while ((frame_width >> times) > kEnough && (frame_height >> times) > 1)
    ++times;
  return times;
}

void NearbyLuma::read(const LumaSource &frame, int frame_width, int frame_height, int halvings,
                      float x, float y, int reach) {
  const int scale = 1 << halvings;
  const int width = std::max(frame_width / scale, 1);
  const int height = std::max(frame_height / scale, 1);
  // A place outside the frame sees its border.
  const int middle_x = std::clamp(static_cast<int>(std::floor(x)), 0, width - 1);
  const int middle_y = std::clamp(static_cast<int>(std::floor(y)), 0, height - 1);
  left_ = middle_x - reach;
  top_ = middle_y - reach;
  const int first_x = std::max(left_, 0);
  const int first_y = std::max(top_, 0);
  const int part_width = std::min(middle_x + reach + 1, width) - first_x;
  const int part_height = std::min(middle_y + reach + 1, height) - first_y;
  for (LumaLayer &layer : layers_)
    layer.plane.resize(0, 0);
  frame_luma_.forget();
  view_ = reduction_.reduce(frame_luma_.read(frame, {first_x * scale, first_y * scale,
                                                     part_width * scale, part_height * scale}),
                            halvings);
  const int side = 2 * reach + 1;
  if (part_width < side || part_height < side)
    view_ = repeat_border(view_, first_x - left_, first_y - top_, side, side, padded_);
}

bool LumaLayer::reaches(float at_x, float at_y, int radius) const {
  const auto wanted = static_cast<float>(radius);
  return column(at_x) >= wanted && row(at_y) >= wanted &&
         column(at_x) + wanted < static_cast<float>(plane.width() - 1) &&
         row(at_y) + wanted < static_cast<float>(plane.height() - 1);
}

const LumaLayer &NearbyLuma::layer(int index, float x, float y, int radius, int least) {
  LumaLayer &layer = layers_[static_cast<std::size_t>(index)];
  if (layer.reaches(x, y, least))
    return layer;
  const int unit = 1 << index;
  const int reach = (radius + kSmoothing) * unit;
  const int from_x = std::clamp(static_cast<int>(std::floor(x)) - reach - left_, 0, view_.width);
  const int from_y = std::clamp(static_cast<int>(std::floor(y)) - reach - top_, 0, view_.height);
  const int to_x = std::clamp(static_cast<int>(std::ceil(x)) + reach - left_, from_x, view_.width);
  const int to_y = std::clamp(static_cast<int>(std::ceil(y)) + reach - top_, from_y, view_.height);
  const int smallest = kLeastSide * unit;
  layer.unit = static_cast<float>(unit);
  if (to_x - from_x < smallest || to_y - from_y < smallest) {
    layer.plane.resize(0, 0);
    return layer;
  }
  const LumaView part = part_of(view_, {from_x, from_y, to_x - from_x, to_y - from_y});
  smooth(layer_reduction_.reduce(part, index), layer.plane);
  layer.x = static_cast<float>(left_ + from_x + kSmoothing * unit);
  layer.y = static_cast<float>(top_ + from_y + kSmoothing * unit);
  return layer;
}

} // namespace haptic
