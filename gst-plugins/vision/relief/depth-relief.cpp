// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief/depth-relief.hpp"

#include "relief/cell-samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace haptic {
namespace {

constexpr int kSamples = kCellSamples * kCellSamples;
constexpr int kFewest = 3; // of them valid; fewer may all be wrong

// Cells that are sorted together, one in each lane of a vector.
// GCC's and Clang's vectors, which every processor has in some form.
constexpr int kLanes = 8;
using Lanes [[gnu::vector_size(kLanes * sizeof(std::int16_t))]] = std::int16_t;
using UnsignedLanes [[gnu::vector_size(kLanes * sizeof(std::uint16_t))]] = std::uint16_t;
using Samples = std::array<Lanes, kSamples>;

// Behind all valid samples.
constexpr std::int16_t kInvalid = std::numeric_limits<std::int16_t>::max();

// The exchanges of Batcher's odd-even merge sort (Knuth, The Art of Computer Programming 3,
// 5.2.2, algorithm M). Those beyond kSamples are left out: nothing comes from there.
template <typename Visit>
constexpr void for_each_exchange(Visit visit) {
  constexpr int kSize = 32;
  for (int p = kSize / 2; p > 0; p /= 2)
    for (int q = kSize / 2, r = 0, d = p; d > 0; d = q - p, q /= 2, r = p)
      for (int i = 0; i + d < kSamples; ++i)
        if ((i & p) == r)
          visit(i, i + d);
}

constexpr int kExchanges = [] {
  int count = 0;
  for_each_exchange([&](int, int) { ++count; });
  return count;
}();

constexpr auto kNetwork = [] {
  std::array<std::pair<int, int>, kExchanges> network{};
  std::size_t at = 0;
  for_each_exchange([&](int low, int high) { network[at++] = {low, high}; });
  return network;
}();

void sort(Samples &samples) {
  for (const auto &[low, high] : kNetwork) {
    const Lanes a = samples[static_cast<std::size_t>(low)];
    const Lanes b = samples[static_cast<std::size_t>(high)];
    samples[static_cast<std::size_t>(low)] = a < b ? a : b;
    samples[static_cast<std::size_t>(high)] = a < b ? b : a;
  }
}

// Pixel values as numbers that rise with the distance from the camera, and these as heights.
class Distances {
public:
  Distances(const DepthScale &scale, int largest) {
    const bool rises = scale.kind == DepthKind::depth;
    const double near = rises ? scale.near / scale.scale : scale.scale / scale.near;
    const double far = rises ? scale.far / scale.scale : scale.scale / scale.far;
    // 0 and the largest number of 16 bits are what cameras give where they do not know.
    const double first = std::max(1.0, std::ceil(std::min(near, far)));
    const double last = std::min(static_cast<double>(largest), std::floor(std::max(near, far)));
    is_empty_ = !(first <= last) || !(scale.near < scale.far);
    if (is_empty_)
      return;
    first_ = static_cast<std::uint16_t>(first);
    span_ = static_cast<std::uint16_t>(last - first);
    // The sign bit makes signed numbers of them, which compare in the same order.
    flip_ = rises ? 0x8000 : 0x7FFF;
    slope_ = scale.range / (near - far);
    offset_ = -scale.range * (far / (near - far) + 0.5);
  }

  bool is_empty() const { return is_empty_; }

  // Cells of the block whose sample at each place is within near and far keep it; others become
  // kInvalid. Returns how many samples of each cell are valid.
  Lanes order(Samples &samples) const {
    Lanes valid{};
    for (Lanes &lanes : samples) {
      const auto value = reinterpret_cast<UnsignedLanes>(lanes);
      const auto inside = reinterpret_cast<Lanes>(value - first_ <= span_);
      const auto ordered = reinterpret_cast<Lanes>(value ^ flip_);
      lanes = inside ? ordered : Lanes{} + kInvalid;
      valid -= inside; // true is -1
    }
    return valid;
  }

  float height(std::int16_t ordered) const {
    const auto value = static_cast<std::uint16_t>(static_cast<std::uint16_t>(ordered) ^ flip_);
    return static_cast<float>(
        std::clamp<double>(slope_ * value + offset_, -kMostReliefHeight, kMostReliefHeight));
  }

private:
  std::uint16_t first_ = 0;
  std::uint16_t span_ = 0; // to the last one
  std::uint16_t flip_ = 0;
  double slope_ = 0;  // m per unit
  double offset_ = 0; // m
  bool is_empty_ = false;
};

template <int kSize>
std::int16_t value_at(const std::uint8_t *pixel) {
  if constexpr (kSize == 1)
    return *pixel;
  return static_cast<std::int16_t>(pixel[0] | pixel[1] << 8);
}

struct Place {
  int row = 0;
  int column = 0; // of the first cell
  int cells = 0;  // at most kLanes
};

template <int kSize>
void gather(const DepthView &depth, const std::vector<int> &offsets, int rows, const Place &place,
            Samples &samples) {
  Lanes *line = samples.data(); // of the samples side by side
  for (int y = 0; y < kCellSamples; ++y, line += kCellSamples) {
    const std::uint8_t *row = depth.pixels + centre_of_part(place.row * kCellSamples + y,
                                                            rows * kCellSamples, depth.height) *
                                                 depth.stride;
    const int *offset = offsets.data() + static_cast<std::ptrdiff_t>(place.column) * kCellSamples;
    for (std::size_t cell = 0; cell < static_cast<std::size_t>(place.cells); ++cell)
      for (int x = 0; x < kCellSamples; ++x)
        line[x][cell] = value_at<kSize>(row + *offset++);
  }
}

} // namespace

bool DepthRelief::make(const DepthView &depth, const DepthScale &scale, ReliefField &relief) {
  const Distances distances(scale, depth.pixel_size == 1 ? 0xFF : 0xFFFE);
  measured_.assign(relief.cells.size(), {});
  bool found = false;
  if (!distances.is_empty()) {
    offsets_.resize(static_cast<std::size_t>(relief.columns) * kCellSamples);
    for (std::size_t i = 0; i < offsets_.size(); ++i)
      offsets_[i] =
          depth.pixel_size *
          centre_of_part(static_cast<int>(i), static_cast<int>(offsets_.size()), depth.width);
    Samples samples{};
    for (Place place; place.row < relief.rows; ++place.row)
      for (place.column = 0; place.column < relief.columns; place.column += kLanes) {
        place.cells = std::min(kLanes, relief.columns - place.column);
        if (depth.pixel_size == 1)
          gather<1>(depth, offsets_, relief.rows, place, samples);
        else
          gather<2>(depth, offsets_, relief.rows, place, samples);
        const Lanes valid = distances.order(samples);
        sort(samples);
        ReliefCell *cell = measured_.data() +
                           static_cast<std::ptrdiff_t>(place.row) * relief.columns + place.column;
        for (std::size_t i = 0; i < static_cast<std::size_t>(place.cells); ++i, ++cell) {
          const int count = valid[static_cast<int>(i)];
          if (count < kFewest)
            continue;
          found = true;
          const int rank = scale.cell_height == CellHeight::median ? (count - 1) / 2 : count / 10;
          *cell = {distances.height(samples[static_cast<std::size_t>(rank)][i]),
                   static_cast<float>(scale.stiffness), static_cast<float>(scale.friction),
                   static_cast<float>(count) / kSamples};
        }
      }
  }
  fill_narrow_holes(measured_, relief.columns, relief.cells);
  return found;
}

void fill_narrow_holes(std::span<const ReliefCell> measured, int columns,
                       std::span<ReliefCell> filled) {
  const auto step = static_cast<std::size_t>(columns);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    filled[i] = measured[i];
    if (measured[i].validity > 0)
      continue;
    float least = std::numeric_limits<float>::infinity(); // difference of a pair
    const auto consider = [&](const ReliefCell &a, const ReliefCell &b) {
      const float difference = std::abs(a.height - b.height);
      if (!(a.validity > 0 && b.validity > 0 && difference < least))
        return;
      least = difference;
      filled[i] = a.height < b.height ? a : b;
      filled[i].validity = kFilledValidity;
    };
    if (i % step > 0 && i % step + 1 < step)
      consider(measured[i - 1], measured[i + 1]);
    if (i >= step && i + step < measured.size())
      consider(measured[i - step], measured[i + step]);
  }
}

} // namespace haptic
