// SPDX-License-Identifier: LGPL-2.1-or-later
// The weight of patch i for pixel p is
//   w_i(p) = c_i s(p - x_i) (E0 / (E0 + E_i(p)))^3
//   E_i(p) = mean over the 5x5 pixels q around p of min((I(q + d_i) - T(q) - b_i)^2, limit)
// with its place x_i, displacement d_i and the mean difference b_i of the grey levels of the frames
// T and I over the middle of its window, c_i its precision between 0 and 1, s a window, and E0 the
// energy that noise leaves. share_i = mean over p of w_i(p) / sum of all w_j(p).
// The densification of Kroeger et al., Fast optical flow using dense inverse search, ECCV 2016,
// weighs by the residual in a similar way; boxes and their own offset are needed at borders.
#include "pixel-votes.hpp"

#include "patch-trust.hpp"

#include <algorithm>
#include <cmath>

// Windows are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pixel-votes.cpp"
#include <hwy/foreach_target.h>

#include "for-row-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSide = PixelVotes::kSide;
constexpr int kBox = 5;
constexpr int kTile = kSide + kBox - 1;
constexpr int kTileStride = 32; // floats from row to row
using Tag = hn::CappedTag<float, kSide>;
using Lanes = hn::Vec<Tag>;
constexpr Tag kTag;
struct Tile {
  alignas(64) float rows[kTile + 1][kTileStride];
};

struct Source {
  const float *first;
  std::ptrdiff_t stride;

  const float *row(int y) const { return first + y * stride; }
};

// `side` x `side` pixels from (x, y) on: in the plane, or a copy in which those outside the plane
// are the ones of its border.
Source pixels_of(const Plane &plane, int x, int y, int side, Tile &copy) {
  if (x >= 0 && x + side <= plane.width() && y >= 0 && y + side <= plane.height())
    return {plane.row(y) + x, plane.stride()};
  for (int row = 0; row < side; ++row) {
    const float *from = plane.row(std::clamp(y + row, 0, plane.height() - 1));
    for (int i = 0; i < side; ++i)
      copy.rows[row][i] = from[std::clamp(x + i, 0, plane.width() - 1)];
  }
  return {copy.rows[0], kTileStride};
}

// Fills in the differences of the grey levels, bilinear in the later frame, and returns their mean
// over the middle.
float Subtract(const Plane &earlier, const Plane &later, const PixelVotes::Ballot &ballot,
               Tile &difference) {
  Tile first_copy;
  Tile second_copy;
  const Source before =
      pixels_of(earlier, ballot.x - kBox / 2, ballot.y - kBox / 2, kTile, first_copy);
  const auto whole_x = static_cast<int>(std::floor(ballot.displacement.x));
  const auto whole_y = static_cast<int>(std::floor(ballot.displacement.y));
  const Source after = pixels_of(later, ballot.x - kBox / 2 + whole_x,
                                 ballot.y - kBox / 2 + whole_y, kTile + 1, second_copy);
  const Lanes u = hn::Set(kTag, ballot.displacement.x - static_cast<float>(whole_x));
  const Lanes v = hn::Set(kTag, ballot.displacement.y - static_cast<float>(whole_y));
  for_row(kTag, kTile, [&](int x) HWY_ATTR {
    const auto across = [&](int y) HWY_ATTR {
      const Lanes left = hn::LoadU(kTag, after.row(y) + x);
      return hn::MulAdd(u, hn::Sub(hn::LoadU(kTag, after.row(y) + x + 1), left), left);
    };
    Lanes upper = across(0);
    for (int y = 0; y < kTile; ++y) {
      const Lanes lower = across(y + 1);
      const Lanes sampled = hn::MulAdd(v, hn::Sub(lower, upper), upper);
      hn::StoreU(hn::Sub(sampled, hn::LoadU(kTag, before.row(y) + x)), kTag,
                 difference.rows[y] + x);
      upper = lower;
    }
  });
  constexpr int kMiddle = 8;
  constexpr int kFirst = (kTile - kMiddle) / 2;
  const hn::CappedTag<float, kMiddle> tag;
  auto sum = hn::Zero(tag);
  for (int y = kFirst; y < kFirst + kMiddle; ++y)
    for (int x = kFirst; x < kFirst + kMiddle; x += static_cast<int>(hn::Lanes(tag)))
      sum = hn::Add(sum, hn::LoadU(tag, difference.rows[y] + x));
  return hn::GetLane(hn::SumOfLanes(tag, sum)) / (kMiddle * kMiddle);
}

// Fills in the weights of a patch. Adds them to the totals of its pixels, and lowers the least
// energies of these to its own.
void Vote(const Plane &earlier, const Plane &later, const PixelVotes::Ballot &ballot, float limit,
          float noise, PixelVotes::Weights &weights, float *totals, float *least) {
  Tile tile;
  const Lanes offset = hn::Set(kTag, Subtract(earlier, later, ballot, tile));
  const Lanes most = hn::Set(kTag, limit);
  const Lanes expected = hn::Set(kTag, noise);
  const Lanes scale = hn::Set(kTag, 1.0F / (kBox * kBox));
  for (int x = 0; x < kSide; x += static_cast<int>(hn::Lanes(kTag))) {
    Lanes sums[kTile]; // of five pixels side by side
    for (int y = 0; y < kTile; ++y) {
      sums[y] = hn::Zero(kTag);
      for (int i = 0; i < kBox; ++i) {
        const Lanes d = hn::Sub(hn::LoadU(kTag, tile.rows[y] + x + i), offset);
        sums[y] = hn::Add(sums[y], hn::Min(hn::Mul(d, d), most));
      }
    }
    const Lanes across = hn::LoadU(kTag, ballot.across.data() + x);
    for (int y = 0; y < kSide; ++y) {
      Lanes energy = sums[y];
      for (int i = 1; i < kBox; ++i)
        energy = hn::Add(energy, sums[y + i]);
      energy = hn::Mul(energy, scale);
      const Lanes ratio = hn::Div(expected, hn::Add(expected, energy));
      const Lanes window = hn::Mul(across, hn::Set(kTag, ballot.down[static_cast<std::size_t>(y)]));
      const Lanes weight = hn::Mul(window, hn::Mul(ratio, hn::Mul(ratio, ratio)));
      hn::StoreU(weight, kTag, weights.data() + y * kSide + x);
      float *total = totals + y * PixelVotes::kStride + x;
      hn::StoreU(hn::Add(hn::LoadU(kTag, total), weight), kTag, total);
      float *lowest = least + y * PixelVotes::kStride + x;
      hn::StoreU(hn::Min(hn::LoadU(kTag, lowest), energy), kTag, lowest);
    }
  }
}

// Sum of the weights of a patch times the inverse totals of its pixels.
float Share(const PixelVotes::Weights &weights, const float *inverses) {
  Lanes sum = hn::Zero(kTag);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; x += static_cast<int>(hn::Lanes(kTag)))
      sum = hn::MulAdd(hn::LoadU(kTag, weights.data() + y * kSide + x),
                       hn::LoadU(kTag, inverses + y * PixelVotes::kStride + x), sum);
  return hn::GetLane(hn::SumOfLanes(kTag, sum));
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(Vote);
HWY_EXPORT(Share);

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

PixelVotes::Ballot ballot_of(const Patch &patch, float scale) {
  constexpr float kWidth2 = 100; // px squared: where the window would end
  const auto first = [](float centre) {
    return static_cast<int>(std::lround(centre)) - PixelVotes::kSide / 2;
  };
  const float x = scale * patch.x;
  const float y = scale * patch.y;
  PixelVotes::Ballot ballot{first(x), first(y), scale * Displacement{patch.dx, patch.dy}, {}, {}};
  const float weight = certainty(patch, scale);
  for (int i = 0; i < PixelVotes::kSide; ++i) {
    const float right = static_cast<float>(ballot.x + i) + 0.5F - x;
    const float below = static_cast<float>(ballot.y + i) + 0.5F - y;
    ballot.across[static_cast<std::size_t>(i)] = 1 - right * right / kWidth2;
    ballot.down[static_cast<std::size_t>(i)] = weight * (1 - below * below / kWidth2);
  }
  return ballot;
}

// The patches of the commonest displacement share the whole region.
void leave_commonest(std::span<Patch> patches) {
  const auto are_alike = [](const Patch &a, const Patch &b) {
    return norm2({a.dx - b.dx, a.dy - b.dy}) < 1;
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

// Of a pixel of the box.
std::size_t PixelVotes::pixel(int x, int y) {
  return cell(y + kSide, kStride, x + kSide);
}

// From the first row on.
std::size_t PixelVotes::used_pixels(const Box &box) {
  return cell(box.height + 2 * kSide, kStride, 0);
}

std::size_t PixelVotes::first_pixel(std::size_t patch, const Box &box) const {
  const Ballot &ballot = ballots_[patch];
  return pixel(std::clamp(ballot.x - box.x, -kSide, kLargestSide),
               std::clamp(ballot.y - box.y, -kSide, kLargestSide));
}

void PixelVotes::vote(const Plane &earlier, const Plane &later, float scale, const Box &box,
                      float noise, std::span<const Patch> patches) {
  const float limit = largest_residual2(noise);
  const auto used = used_pixels(box);
  std::fill_n(totals_.begin(), used, 0.0F);
  std::fill_n(least_.begin(), used, limit);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    ballots_[i] = ballot_of(patches[i], scale);
    const std::size_t first = first_pixel(i, box);
    HWY_DYNAMIC_DISPATCH(Vote)
    (earlier, later, ballots_[i], limit, 2 * kSmoothedNoise * noise, weights_[i],
     totals_.data() + first, least_.data() + first);
  }
}

// Where no displacement explains most of the pixels, layers lie over one another. Fills in the
// inverses of the totals.
PixelVotes::Finding PixelVotes::judge(const Box &box, float limit) {
  int pixels = 0;
  int unclear = 0;
  int unexplained = 0;
  std::fill_n(inverses_.begin(), used_pixels(box), 0.0F);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const std::size_t at = pixel(x, y);
      if (totals_[at] <= 0)
        continue;
      inverses_[at] = 1 / totals_[at];
      ++pixels;
      unclear += 3 * least_[at] > limit;
      unexplained += 2 * least_[at] > limit;
    }
  if (2 * pixels < box.width * box.height)
    return Finding::unclear;
  return 2 * unexplained > pixels ? Finding::layers
         : 2 * unclear > pixels   ? Finding::unclear
                                  : Finding::apart;
}

void PixelVotes::share_out(const Box &box, std::span<Patch> patches) const {
  float sum = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    patches[i].share =
        HWY_DYNAMIC_DISPATCH(Share)(weights_[i], inverses_.data() + first_pixel(i, box));
    sum += patches[i].share;
  }
  for (Patch &patch : patches)
    patch.share /= sum;
}

void PixelVotes::count(const Plane &earlier, const Plane &later, int level, const Area &region,
                       float noise, std::span<Patch> patches) {
  const Area area = region.at_level(level);
  const auto first = [](float from) { return static_cast<int>(std::floor(from)); };
  const auto length = [&](float from, float extent) {
    return std::clamp(static_cast<int>(std::ceil(from + extent)) - first(from), 1, kLargestSide);
  };
  const Box box{first(area.x), first(area.y), length(area.x, area.width),
                length(area.y, area.height)};
  vote(earlier, later, 1 / static_cast<float>(1 << level), box, noise, patches);
  const Finding finding = judge(box, largest_residual2(noise));
  if (finding == Finding::unclear)
    return;
  share_out(box, patches);
  if (finding == Finding::layers)
    leave_commonest(patches);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
