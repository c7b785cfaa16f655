// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/field-sampler.hpp"

#include "samples/region-size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace haptic {
namespace {

constexpr std::size_t kBlock = 64; // cells whose weights are computed together

// The integral of the hat function max(0, 1 - |t|), the weight of a cell around its centre, from -1
// to `t`; in cells.
double hat_integral(double t) noexcept {
  const double within = std::clamp(t, -1.0, 1.0);
  return 0.5 + within - 0.5 * within * std::abs(within);
}

// The weights of the cells along one axis: the integral of each cell's hat over a box. In cells,
// the centre of cell i at i.
class Axis {
public:
  Axis(double place, double region, std::size_t cells) noexcept {
    // The mean over a region n cells wide has the variance n^2 / 12. The measurement of a cell
    // already has 1 / 12 of it, and the line between the centres of two has 2 / 12.
    const double n = region * static_cast<double>(cells);
    const double box = std::sqrt(std::max(n * n - 3, 1e-6));
    const double centre = place * static_cast<double>(cells) - 0.5;
    left_ = centre - box / 2;
    right_ = centre + box / 2;
    const auto last = static_cast<double>(cells - 1);
    first_ = static_cast<std::size_t>(std::clamp(std::ceil(left_ - 1), 0.0, last));
    end_ = static_cast<std::size_t>(std::clamp(std::floor(right_ + 1), 0.0, last)) + 1;
  }

  std::size_t first() const noexcept { return first_; }
  std::size_t end() const noexcept { return end_; }
  double weight(std::size_t cell) const noexcept {
    const auto centre = static_cast<double>(cell);
    return hat_integral(right_ - centre) - hat_integral(left_ - centre);
  }

private:
  double left_, right_;     // of the box
  std::size_t first_, end_; // cells with a weight above 0
};

struct Sums {
  double weight = 0;
  double confidence = 0;
  double x = 0;
  double y = 0;
};

void add_row(std::span<const FieldCell> cells, std::span<const double> weights, double row_weight,
             Sums &sums) noexcept {
  Sums row;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const FieldCell &cell = cells[i];
    const double sure = weights[i] * static_cast<double>(cell.confidence);
    row.weight += weights[i];
    row.confidence += sure;
    row.x += sure * static_cast<double>(cell.velocity_x);
    row.y += sure * static_cast<double>(cell.velocity_y);
  }
  sums.weight += row_weight * row.weight;
  sums.confidence += row_weight * row.confidence;
  sums.x += row_weight * row.x;
  sums.y += row_weight * row.y;
}

} // namespace

MotionSample frame_of(const MotionField &field) noexcept {
  MotionSample sample;
  sample.interval = field.interval;
  sample.frame_width = field.frame_width;
  sample.frame_height = field.frame_height;
  sample.pixel_aspect_n = field.pixel_aspect_n;
  sample.pixel_aspect_d = field.pixel_aspect_d;
  sample.flags = field.flags;
  return sample;
}

MotionSample sample_field(const MotionField &field, const PointerPosition &place) noexcept {
  const double width = field.frame_width;
  const double height = field.frame_height;
  const double side =
      region_side(place.z, default_region_side(static_cast<int>(field.frame_width)), width, height);
  const Axis columns(place.x, side / width, field.columns);
  const Axis rows(place.y, side / height, field.rows);

  Sums sums;
  std::array<double, kBlock> weights;
  for (std::size_t begin = columns.first(); begin < columns.end(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, columns.end() - begin);
    for (std::size_t i = 0; i < count; ++i)
      weights[i] = columns.weight(begin + i);
    for (std::size_t row = rows.first(); row < rows.end(); ++row)
      add_row(std::span(field.cells).subspan(row * field.columns + begin, count),
              std::span(weights).first(count), rows.weight(row), sums);
  }

  MotionSample sample = frame_of(field);
  if (!(sums.confidence > 0))
    return sample;
  sample.velocity_x = static_cast<float>(sums.x / sums.confidence);
  sample.velocity_y = static_cast<float>(sums.y / sums.confidence);
  sample.confidence = static_cast<float>(std::min(sums.confidence / sums.weight, 1.0));
  return sample;
}

} // namespace haptic
