// SPDX-License-Identifier: LGPL-2.1-or-later
// The weight of patch i for pixel p is
//   w_i(p) = c_i s(p - x_i) (E0 / (E0 + E_i(p)))^3
//   E_i(p) = mean over the 5x5 pixels q around p of min((I(q + d_i) - T(q) - b_i)^2, limit)
// with its place x_i, displacement d_i and the mean difference b_i of the grey levels of the frames
// T and I over the middle of its window, c_i its precision between 0 and 1, s a window, and E0 the
// energy that noise leaves. share_i = mean over p of w_i(p) / sum of all w_j(p).
// The densification of Kroeger et al., Fast optical flow using dense inverse search, ECCV 2016,
// weighs by the residual in a similar way; boxes and their own offset are needed at borders.
#include "patches/pixel-votes.hpp"

#include "patches/patch-trust.hpp"
#include "patches/start-set.hpp"

#include <algorithm>
#include <cmath>

// Windows are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patches/pixel-votes.cpp"
#include <hwy/foreach_target.h>

#include "patches/pixel-differences-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSide = PixelVotes::kSide;
constexpr int kStride = PixelVotes::kStride;
constexpr int kBox = 5;
using VoteSheets = PixelVotes::Sheets;

// first, first + 1, ...
HWY_INLINE Lanes count_from(int first) {
  alignas(64) static constexpr float kCount[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  return hn::Add(hn::Load(kTag, kCount), hn::Set(kTag, static_cast<float>(first)));
}

// Fills whole vectors.
HWY_INLINE void fill(float *to, int count, float value) {
  const Lanes lanes_of_it = hn::Set(kTag, value);
  for (int i = 0; i < count; i += lanes())
    hn::StoreU(lanes_of_it, kTag, to + i);
}

// The mean difference over the middle of the window of a patch.
float MeanDifference(const Plane &earlier, const Plane &later, int left, int top, Displacement d) {
  constexpr int kMiddle = 8;
  Lanes sum = hn::Zero(kTag);
  for_differences(earlier, later, left, top, kMiddle, kMiddle, d,
                  [&](int, int, Lanes difference) HWY_ATTR { sum = hn::Add(sum, difference); });
  return hn::GetLane(hn::SumOfLanes(kTag, sum)) / (kMiddle * kMiddle);
}

// 1 - (distance / 10 px)^2 along one axis, within the window: 0 beyond.
HWY_INLINE Lanes window_at(int first, int last, int x, float centre) {
  constexpr float kOfWidth2 = 0.0125F; // per px squared: the window would end at 9 px
  const Lanes at = count_from(x);
  const Lanes away = hn::Sub(at, hn::Set(kTag, centre - 0.5F));
  const Lanes value =
      hn::NegMulAdd(hn::Mul(away, away), hn::Set(kTag, kOfWidth2), hn::Set(kTag, 1));
  const auto inside = hn::And(hn::Ge(at, hn::Set(kTag, static_cast<float>(first))),
                              hn::Lt(at, hn::Set(kTag, static_cast<float>(last))));
  return hn::IfThenElseZero(inside, value);
}

// Calls body(x, across, down) for the vectors of columns of a window: the weights of the columns
// from x on, and those of the rows of the window.
template <class Body>
HWY_INLINE void for_columns(const PixelVotes::Ballot &ballot, Body &&body) {
  const PixelVotes::Box &window = ballot.window;
  HWY_ALIGN float down[kSide];
  for (int y = 0; y < kSide; y += lanes())
    hn::Store(hn::Mul(hn::Set(kTag, ballot.weight),
                      window_at(window.y, window.y + window.height, window.y + y, ballot.centre.y)),
              kTag, down + y);
  for (int x = window.x; x < window.x + window.width; x += lanes())
    body(x, window_at(window.x, window.x + window.width, x, ballot.centre.x), down);
}

// The sum of the windows of the patches of a layer, rows of layer.box.padded_width() pixels.
void AddWindows(VoteSheets &sheets, std::size_t index) {
  const PixelVotes::Layer &layer = sheets.layers[index];
  const int stride = layer.box.padded_width();
  fill(sheets.windows.data(), stride * layer.box.height + 8, 0);
  for (std::size_t i = 0; i < sheets.patches; ++i) {
    const PixelVotes::Ballot &ballot = sheets.ballots[i];
    if (ballot.layer != index)
      continue;
    for_columns(ballot, [&](int x, Lanes across, const float *down) HWY_ATTR {
      float *to =
          sheets.windows.data() + (ballot.window.y - layer.box.y) * stride + x - layer.box.x;
      for (int y = 0; y < ballot.window.height; ++y, to += stride)
        hn::StoreU(hn::MulAdd(across, hn::Set(kTag, down[y]), hn::LoadU(kTag, to)), kTag, to);
    });
  }
}

// Fills in the energies of five pixels one below the other, rows of kStride pixels.
void AddEnergies(const Plane &earlier, const Plane &later, const PixelVotes::Box &region,
                 float limit, VoteSheets &sheets, const PixelVotes::Layer &layer) {
  const Lanes offset = hn::Set(kTag, layer.offset);
  const Lanes most = hn::Set(kTag, limit);
  Lanes last = hn::Zero(kTag);         // of the row before
  Lanes pairs[3] = {last, last, last}; // of the last rows, two each
  for_differences(earlier, later, region.x + layer.box.x - kBox / 2,
                  region.y + layer.box.y - kBox / 2, layer.box.width + kBox - 1,
                  layer.box.height + kBox - 1, layer.displacement,
                  [&](int x, int y, Lanes difference) HWY_ATTR {
                    const Lanes d = hn::Sub(difference, offset);
                    const Lanes energy = hn::Min(hn::Mul(d, d), most);
                    // Rows y-4 and y-3, y-2 and y-1, y.
                    const Lanes five = hn::Add(hn::Add(pairs[2], pairs[0]), energy);
                    pairs[2] = pairs[1];
                    pairs[1] = pairs[0];
                    pairs[0] = hn::Add(last, energy);
                    last = energy;
                    if (y >= kBox - 1)
                      hn::StoreU(five, kTag, sheets.energies.data() + (y - kBox + 1) * kStride + x);
                  });
}

// Adds the weights of the patches of a layer to the totals of its pixels, and lowers the least
// energies of these.
void VoteTogether(float limit, float noise, VoteSheets &sheets, const PixelVotes::Layer &layer) {
  const Lanes most = hn::Set(kTag, limit);
  const Lanes expected = hn::Set(kTag, noise);
  const Lanes scale = hn::Set(kTag, 1.0F / (kBox * kBox));
  const int stride = layer.box.padded_width();
  // To the end of the rows of ratios, also with vectors of four: ShareOut reads them whole.
  for (int x = 0; x < stride; x += lanes())
    for (int y = 0; y < layer.box.height; ++y) {
      const float *column = sheets.energies.data() + y * kStride + x;
      Lanes energy = hn::LoadU(kTag, column);
      for (int i = 1; i < kBox; ++i)
        energy = hn::Add(energy, hn::LoadU(kTag, column + i));
      energy = hn::Mul(energy, scale);
      const Lanes ratio = hn::Div(expected, hn::Add(expected, energy));
      const Lanes window = hn::LoadU(kTag, sheets.windows.data() + y * stride + x);
      const auto counts = hn::Gt(window, hn::Zero(kTag));
      // Right of the box lie energies that nobody computed.
      const Lanes cube = hn::IfThenElseZero(counts, hn::Mul(ratio, hn::Mul(ratio, ratio)));
      hn::StoreU(cube, kTag, sheets.ratios.data() + layer.first + y * stride + x);
      const int at = (layer.box.y + y) * kStride + layer.box.x + x;
      float *total = sheets.totals.data() + at;
      hn::StoreU(hn::MulAdd(window, cube, hn::LoadU(kTag, total)), kTag, total);
      float *lowest = sheets.least.data() + at;
      const Lanes seen = hn::IfThenElse(counts, energy, most);
      hn::StoreU(hn::Min(hn::LoadU(kTag, lowest), seen), kTag, lowest);
    }
}

void Vote(const Plane &earlier, const Plane &later, const PixelVotes::Box &region, float limit,
          float noise, VoteSheets &sheets) {
  const int used = kStride * region.height;
  fill(sheets.totals.data(), used, 0);
  fill(sheets.least.data(), used, limit);
  for (std::size_t i = 0; i < sheets.used_layers; ++i) {
    AddWindows(sheets, i);
    AddEnergies(earlier, later, region, limit, sheets, sheets.layers[i]);
    VoteTogether(limit, noise, sheets, sheets.layers[i]);
  }
}

// Counts the pixels, and makes the totals inverse; those outside the region become 0.
PixelVotes::Counts Judge(const PixelVotes::Box &region, float limit, VoteSheets &sheets) {
  const Lanes zero = hn::Zero(kTag);
  const Lanes one = hn::Set(kTag, 1);
  Lanes pixels = zero, unclear = zero, unexplained = zero;
  for (int y = 0; y < region.height; ++y)
    for (int x = 0; x < region.width; x += lanes()) {
      float *total = sheets.totals.data() + y * kStride + x;
      const Lanes sum = hn::LoadU(kTag, total);
      const auto counts =
          hn::And(hn::Gt(sum, zero),
                  hn::Lt(count_from(x), hn::Set(kTag, static_cast<float>(region.width))));
      const Lanes least =
          hn::IfThenElseZero(counts, hn::LoadU(kTag, sheets.least.data() + y * kStride + x));
      pixels = hn::Add(pixels, hn::IfThenElseZero(counts, one));
      unclear = hn::Add(unclear, hn::IfThenElseZero(hn::Gt(least, hn::Set(kTag, limit / 3)), one));
      unexplained =
          hn::Add(unexplained, hn::IfThenElseZero(hn::Gt(least, hn::Set(kTag, limit / 2)), one));
      hn::StoreU(hn::IfThenElseZero(counts, hn::Div(one, sum)), kTag, total);
    }
  const auto number = [](Lanes sums) HWY_ATTR {
    return static_cast<int>(hn::GetLane(hn::SumOfLanes(kTag, sums)));
  };
  return {number(pixels), number(unclear), number(unexplained)};
}

// Sum of the weights of each patch times the inverse totals of its pixels.
void ShareOut(const VoteSheets &sheets, std::span<Patch> patches) {
  for (std::size_t i = 0; i < sheets.patches; ++i) {
    const PixelVotes::Ballot &ballot = sheets.ballots[i];
    const PixelVotes::Layer &layer = sheets.layers[ballot.layer];
    const int stride = layer.box.padded_width();
    Lanes sum = hn::Zero(kTag);
    for_columns(ballot, [&](int x, Lanes across, const float *down) HWY_ATTR {
      const float *ratios = sheets.ratios.data() + layer.first +
                            (ballot.window.y - layer.box.y) * stride + x - layer.box.x;
      const float *inverses = sheets.totals.data() + ballot.window.y * kStride + x;
      Lanes column = hn::Zero(kTag);
      for (int y = 0; y < ballot.window.height; ++y) {
        const Lanes of_pixel =
            hn::Mul(hn::LoadU(kTag, ratios + y * stride), hn::LoadU(kTag, inverses + y * kStride));
        column = hn::MulAdd(of_pixel, hn::Set(kTag, down[y]), column);
      }
      sum = hn::MulAdd(column, across, sum);
    });
    patches[i].share = hn::GetLane(hn::SumOfLanes(kTag, sum));
  }
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(MeanDifference);
HWY_EXPORT(Vote);
HWY_EXPORT(Judge);
HWY_EXPORT(ShareOut);

using Box = PixelVotes::Box;

// 1 for a patch whose displacement is known, towards 0 for one without texture: it would agree with
// any displacement. `scale`: px of the plane per px of the precision.
float certainty(const Patch &patch, float scale) {
  constexpr float kUnsure2 = 0.3F * 0.3F; // px squared
  constexpr float kLeast = 1e-4F;
  const float trace = patch.precision_xx + patch.precision_yy;
  const float determinant =
      patch.precision_xx * patch.precision_yy - patch.precision_xy * patch.precision_xy;
  if (!(determinant > 1e-6F * trace * trace))
    return kLeast;
  return kLeast + kUnsure2 / (kUnsure2 + scale * scale * trace / determinant);
}

// The window of a patch relative to the region. `scale`: px of the plane per px of the patch.
PixelVotes::Ballot ballot_of(const Patch &patch, float scale, const Box &region) {
  PixelVotes::Ballot ballot;
  ballot.centre = {scale * patch.x - static_cast<float>(region.x),
                   scale * patch.y - static_cast<float>(region.y)};
  ballot.displacement = scale * Displacement{patch.dx, patch.dy};
  ballot.weight = certainty(patch, scale);
  const auto cut = [](float centre, int length, int &from, int &extent) {
    const int first = static_cast<int>(std::lround(centre)) - PixelVotes::kSide / 2;
    from = std::clamp(first, 0, length);
    extent = std::clamp(first + PixelVotes::kSide, 0, length) - from;
  };
  cut(ballot.centre.x, region.width, ballot.window.x, ballot.window.width);
  cut(ballot.centre.y, region.height, ballot.window.y, ballot.window.height);
  if (ballot.window.width == 0 || ballot.window.height == 0)
    ballot.window = {};
  return ballot;
}

// The smallest box around both.
Box around(const Box &a, const Box &b) {
  const int x = std::min(a.x, b.x);
  const int y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
          std::max(a.y + a.height, b.y + b.height) - y};
}

// Pixels of whole vectors.
int area_of(const Box &box) {
  return box.padded_width() * box.height;
}

// The patches of the commonest displacement share the whole region.
void leave_commonest(std::span<Patch> patches) {
  const auto are_alike = [](const Patch &a, const Patch &b) {
    return are_close({a.dx, a.dy}, {b.dx, b.dy});
  };
  const auto share_like = [&](const Patch &patch) {
    float sum = 0;
    for (const Patch &other : patches)
      sum += are_alike(patch, other) ? other.share : 0;
    return sum;
  };
  const Patch commonest =
      *std::ranges::max_element(patches, {}, [&](const Patch &patch) { return share_like(patch); });
  const float all = share_like(commonest);
  for (Patch &patch : patches)
    patch.share = are_alike(patch, commonest) ? patch.share / all : 0;
}

} // namespace

// Patches of nearly one displacement and offset see the same residuals, which are then computed
// once. Together they hold no more pixels than apart.
void PixelVotes::join(std::size_t patch) {
  constexpr float kSame2 = 0.25F * 0.25F; // px squared
  constexpr float kSameGrey = 1.5F;       // grey levels
  Ballot &ballot = sheets_.ballots[patch];
  for (std::size_t i = 0; i < sheets_.used_layers; ++i) {
    Layer &layer = sheets_.layers[i];
    const Box box = around(layer.box, ballot.window);
    if (norm2(layer.displacement - ballot.displacement) > kSame2 ||
        std::abs(layer.offset - ballot.offset) > kSameGrey ||
        static_cast<float>(area_of(box)) > (layer.members + 1) * kSide * kSide)
      continue;
    ballot.layer = i;
    layer.box = box;
    layer.members += 1;
    layer.weight += ballot.weight;
    const float part = ballot.weight / layer.weight;
    layer.displacement += part * (ballot.displacement - layer.displacement);
    layer.offset += part * (ballot.offset - layer.offset);
    return;
  }
  ballot.layer = sheets_.used_layers;
  sheets_.layers[sheets_.used_layers++] = {ballot.window, ballot.displacement, ballot.offset,
                                           ballot.weight, 1};
}

void PixelVotes::fill_in(const Plane &earlier, const Plane &later, float scale, const Box &box,
                         std::span<const Patch> patches) {
  sheets_.patches = patches.size();
  sheets_.used_layers = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    Ballot &ballot = sheets_.ballots[i];
    ballot = ballot_of(patches[i], scale, box);
    const auto first = [](float centre) { return static_cast<int>(std::lround(centre)) - 4; };
    ballot.offset =
        HWY_DYNAMIC_DISPATCH(MeanDifference)(earlier, later, box.x + first(ballot.centre.x),
                                             box.y + first(ballot.centre.y), ballot.displacement);
    join(i);
  }
  std::size_t first = 0;
  for (std::size_t i = 0; i < sheets_.used_layers; ++i) {
    sheets_.layers[i].first = first;
    first += static_cast<std::size_t>(area_of(sheets_.layers[i].box));
  }
}

float PixelVotes::count(const Plane &earlier, const Plane &later, int level, const Area &region,
                        float noise, std::span<Patch> patches) {
  const Area area = region.at_level(level);
  const auto first = [](float from) { return static_cast<int>(std::floor(from)); };
  const auto length = [&](float from, float extent) {
    return std::clamp(static_cast<int>(std::ceil(from + extent)) - first(from), 1, kLargestSide);
  };
  const Box box{first(area.x), first(area.y), length(area.x, area.width),
                length(area.y, area.height)};
  const float limit = largest_residual2(noise);
  fill_in(earlier, later, 1 / static_cast<float>(1 << level), box, patches);
  HWY_DYNAMIC_DISPATCH(Vote)(earlier, later, box, limit, 2 * kSmoothedNoise * noise, sheets_);
  const Counts counts = HWY_DYNAMIC_DISPATCH(Judge)(box, limit, sheets_);
  // Where no displacement explains most of the pixels, layers lie over one another.
  const float unexplained =
      static_cast<float>(counts.unexplained) / static_cast<float>(std::max(1, counts.pixels));
  const bool are_layers = 2 * counts.unexplained > counts.pixels;
  if (2 * counts.pixels < box.width * box.height ||
      (!are_layers && 2 * counts.unclear > counts.pixels))
    return unexplained;
  HWY_DYNAMIC_DISPATCH(ShareOut)(sheets_, patches);
  float sum = 0;
  for (const Patch &patch : patches)
    sum += patch.share;
  for (Patch &patch : patches)
    patch.share /= sum;
  if (are_layers)
    leave_commonest(patches);
  return unexplained;
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
