// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/touch-picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace haptic {
namespace {

constexpr double kMillimetres = 1000;
constexpr double kProfile = 3.4938562; // 1 / max of t (1 - t²)²
constexpr float kOneGain = 256;

// The samples of one component: of packed formats they do not lie side by side.
struct Samples {
  Samples(const GstVideoFrame &frame, guint component)
      : data(static_cast<std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(&frame, component))),
        width(GST_VIDEO_FRAME_COMP_WIDTH(&frame, component)),
        height(GST_VIDEO_FRAME_COMP_HEIGHT(&frame, component)),
        stride(GST_VIDEO_FRAME_COMP_STRIDE(&frame, component)),
        step(GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, component)) {}
  std::uint8_t *at(int x, int y) const {
    return data + static_cast<std::ptrdiff_t>(y) * stride + static_cast<std::ptrdiff_t>(x) * step;
  }

  std::uint8_t *data;
  int width, height, stride, step;
};

// The samples whose centres a span covers, and one more to each side.
struct Span {
  Span(double centre, double reach, int size)
      : first(static_cast<int>(std::clamp(std::floor(centre - reach), 0.0, size - 1.0))),
        last(static_cast<int>(std::clamp(std::ceil(centre + reach), 0.0, size - 1.0))) {}
  int count() const { return last - first + 1; }
  int first, last;
};

// Samples side by side.
struct PlanePatch {
  // Bilinear; beyond the border as on it.
  std::uint8_t at(float x, float y) const {
    const float u = std::clamp(x, 0.0F, static_cast<float>(width - 1));
    const float v = std::clamp(y, 0.0F, static_cast<float>(height - 1));
    const int column = static_cast<int>(u);
    const int row = static_cast<int>(v);
    const std::uint8_t *p = data + static_cast<std::ptrdiff_t>(row) * width + column;
    const int right = column + 1 < width ? 1 : 0;
    const std::ptrdiff_t below = row + 1 < height ? width : 0;
    const float wu = u - static_cast<float>(column);
    const float wv = v - static_cast<float>(row);
    const auto mix = [](float a, float b, float weight) { return a + weight * (b - a); };
    const float upper = mix(p[0], p[right], wu);
    const float lower = mix(p[below], p[below + right], wu);
    constexpr float kToNearest = 0.5F; // of what is not negative; std::lround takes longer
    return static_cast<std::uint8_t>(mix(upper, lower, wv) + kToNearest);
  }

  const std::uint8_t *data;
  int width, height;
};

// Of as many bytes as gains. By pointers of its own: bytes might alias the vector's.
void brighten(std::uint8_t *bytes, std::span<const std::int16_t> gains, int black) {
  const std::int16_t *gain = gains.data();
  const std::size_t count = gains.size();
  for (std::size_t i = 0; i < count; ++i) {
    const int value = bytes[i];
    bytes[i] =
        static_cast<std::uint8_t>(std::clamp(value + (((value - black) * gain[i]) >> 8), 0, 255));
  }
}

double pixel_aspect(const GstVideoFrame &frame) {
  return static_cast<double>(GST_VIDEO_INFO_PAR_N(&frame.info)) / GST_VIDEO_INFO_PAR_D(&frame.info);
}

} // namespace

Dent dent_at(double x, double y, double depth, double deform, int frame_height) {
  const double pull = depth * kMillimetres * deform;
  const double radius = frame_height * kDentRadius;
  if (!(pull > 0) || !std::isfinite(x) || !std::isfinite(y)) // also for NaN
    return {};
  return {x, y, std::min(pull, kDeepestDent * radius), radius};
}

void DentPainter::paint(const Dent &dent, GstVideoFrame &frame) {
  if (!(dent.pull > 0) || !(dent.radius > 0))
    return;
  for (guint component = 0; component < GST_VIDEO_FRAME_N_COMPONENTS(&frame); ++component)
    paint_component(dent, frame, component);
}

void DentPainter::paint_component(const Dent &dent, GstVideoFrame &frame, guint component) {
  const Samples samples(frame, component);
  // Samples per unit of the dent, whose units are square on the screen.
  const double sx = static_cast<double>(samples.width) / GST_VIDEO_FRAME_WIDTH(&frame);
  const double sy = static_cast<double>(samples.height) / GST_VIDEO_FRAME_HEIGHT(&frame);
  const double wide = sx / pixel_aspect(frame);
  const double cx = dent.x * sx - 0.5;
  const double cy = dent.y * sy - 0.5;
  const Span across(cx, dent.radius * wide + 1, samples.width);
  const Span down(cy, dent.radius * sy + 1, samples.height);
  // For a dent in the middle of the frame, so that a moving hand allocates once.
  const auto most_wide = static_cast<std::size_t>(2 * dent.radius * wide + 5);
  const auto most_high = static_cast<std::size_t>(2 * dent.radius * sy + 5);
  before_.resize(std::max(before_.size(), most_wide * most_high));
  std::uint8_t *to = before_.data();
  for (int y = down.first; y <= down.last; ++y)
    for (int x = across.first; x <= across.last; ++x)
      *to++ = *samples.at(x, y);

  const auto ux = static_cast<float>(1 / (dent.radius * wide));
  const auto uy = static_cast<float>(1 / (dent.radius * sy));
  const auto most = static_cast<float>(kProfile * dent.pull / dent.radius);
  const PlanePatch before{before_.data(), across.count(), down.count()};
  const auto left = static_cast<float>(cx - across.first);
  const auto top = static_cast<float>(cy - down.first);
  for (int y = down.first; y <= down.last; ++y) {
    const auto dy = static_cast<float>(y - cy);
    for (int x = across.first; x <= across.last; ++x) {
      const auto dx = static_cast<float>(x - cx);
      const float inside = 1 - dx * ux * dx * ux - dy * uy * dy * uy; // 1 - t²
      if (!(inside > 0))
        continue;
      const float away = 1 + most * inside * inside;
      *samples.at(x, y) = before.at(left + dx * away, top + dy * away);
    }
  }
}

void ReliefShading::read(const ReliefField &relief, double strength) {
  columns_ = relief.columns;
  rows_ = relief.rows;
  light_.assign(relief.cells.size(), 0);
  holes_.assign(relief.cells.size(), 1);
  row_.resize(relief.columns);
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  };
  const auto exists = [&](int x, int y) {
    return x >= 0 && x < columns_ && y >= 0 && y < rows_ &&
           relief.cells[index(x, y)].validity >= 0.5F;
  };
  const double tall = kFrameHeight / rows_; // m, of a cell
  const double wide = kFrameHeight * relief.frame_width * relief.pixel_aspect_n /
                      (static_cast<double>(relief.pixel_aspect_d) * relief.frame_height * columns_);
  // Between the neighbours that exist, so that a plane has one slope up to its border.
  const auto slope = [&](int x, int y, int dx, int dy, double size) {
    const int before = exists(x - dx, y - dy) ? 1 : 0;
    const int after = exists(x + dx, y + dy) ? 1 : 0;
    if (before + after == 0)
      return 0.0;
    const double rise =
        static_cast<double>(relief.cells[index(x + after * dx, y + after * dy)].height) -
        static_cast<double>(relief.cells[index(x - before * dx, y - before * dy)].height);
    return rise / (size * (before + after));
  };
  constexpr double kLightZ = 2; // over those to the left and to the top
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < columns_; ++x) {
      if (!exists(x, y))
        continue;
      const double right = slope(x, y, 1, 0, wide);
      const double down = slope(x, y, 0, 1, tall);
      const double lit = (right + down + kLightZ) / std::sqrt(1 + right * right + down * down);
      holes_[index(x, y)] = 0;
      light_[index(x, y)] = static_cast<float>(strength * std::clamp(lit / kLightZ - 1, -1.0, 1.0));
    }
}

// Bilinear between the centres of the cells; a hole lends nothing and gets nothing. Returns false
// if the whole row stays as it is.
bool ReliefShading::find_gains(int row, int width, int height) {
  const float v = std::clamp((static_cast<float>(row) + 0.5F) * static_cast<float>(rows_) /
                                     static_cast<float>(height) -
                                 0.5F,
                             0.0F, static_cast<float>(rows_ - 1));
  const int top = static_cast<int>(v);
  const int bottom = std::min(top + 1, rows_ - 1);
  const float lower = v - static_cast<float>(top);
  const auto cells = [&](int y) { return static_cast<std::size_t>(y) * row_.size(); };
  float most = 0;
  for (std::size_t x = 0; x < row_.size(); ++x) {
    const float above = light_[cells(top) + x];
    row_[x] = (above + lower * (light_[cells(bottom) + x] - above)) * kOneGain;
    most = std::max(most, std::abs(row_[x]));
  }
  if (most < 1)
    return false;
  // From each centre to the next.
  const double cell = static_cast<double>(width) / columns_;
  const auto first_at = [&](double x) {
    return static_cast<int>(std::clamp(std::ceil(x - 0.5), 0.0, static_cast<double>(width)));
  };
  for (int next = 0; next <= columns_; ++next) {
    const float from = row_[static_cast<std::size_t>(std::max(next - 1, 0))];
    const float to = row_[static_cast<std::size_t>(std::min(next, columns_ - 1))];
    const auto step = static_cast<float>((to - from) / cell);
    const int begin = first_at((next - 0.5) * cell);
    const int end = first_at((next + 0.5) * cell);
    const float at = from + step * static_cast<float>(begin + 0.5 - (next - 0.5) * cell);
    for (int x = begin; x < end; ++x)
      gains_[static_cast<std::size_t>(x)] =
          static_cast<std::int16_t>(at + step * static_cast<float>(x - begin));
  }
  const std::uint8_t *holes = &holes_[cells(std::min(rows_ - 1, row * rows_ / height))];
  for (int x = 0; x < columns_; ++x)
    if (holes[x])
      std::fill(gains_.begin() + first_at(x * cell), gains_.begin() + first_at((x + 1) * cell),
                std::int16_t{0});
  return true;
}

void ReliefShading::paint(GstVideoFrame &frame) {
  if (columns_ == 0 || rows_ == 0)
    return;
  const int width = GST_VIDEO_FRAME_WIDTH(&frame);
  const int height = GST_VIDEO_FRAME_HEIGHT(&frame);
  const GstVideoInfo &info = frame.info;
  const bool is_rgb = GST_VIDEO_INFO_IS_RGB(&info);
  const guint components = is_rgb ? 3 : 1; // of brightness, all in plane 0
  const int black = is_rgb || info.colorimetry.range == GST_VIDEO_COLOR_RANGE_0_255 ? 0 : 16;
  const int step = Samples(frame, 0).step;
  auto *plane = static_cast<std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
  gains_.resize(static_cast<std::size_t>(width));
  // The gain of each byte, zero for those that are no brightness.
  spread_.assign(step > 1 ? static_cast<std::size_t>(width) * static_cast<std::size_t>(step) : 0,
                 0);
  for (int y = 0; y < height; ++y) {
    if (!find_gains(y, width, height))
      continue;
    if (step == 1) {
      brighten(Samples(frame, 0).at(0, y), gains_, black);
      continue;
    }
    for (guint component = 0; component < components; ++component) {
      auto at = static_cast<std::size_t>(Samples(frame, component).data - plane);
      for (const std::int16_t gain : gains_) {
        spread_[at] = gain;
        at += static_cast<std::size_t>(step);
      }
    }
    brighten(plane + static_cast<std::ptrdiff_t>(y) * GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0),
             spread_, black);
  }
}

} // namespace haptic
