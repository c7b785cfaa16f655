// SPDX-License-Identifier: LGPL-2.1-or-later
// A motion minimises sum over the pixels p of rho(r(p)), r(p) = I(p + d) - T(p) - b, over the
// displacement d and a difference b of the grey levels of the frames T and I, by iteratively
// re-weighted Gauss-Newton steps:
//   (dd, db) = (sum w a a^T)^-1 sum w r a,  a = (g, 1),  w = (1 + r^2 / s^2)^-2
// with the weights of Geman and McClure (Bull. Int. Stat. Inst. 52, 1987), and g the mean of the
// gradients of both frames (Malis, Improving vision-based control using efficient second-order
// minimization techniques, ICRA 2004). For layers, the scale s falls from that of the residuals to
// that of the noise (graduated non-convexity, Blake and Zisserman, Visual Reconstruction, 1987):
// where the other layer is flat, the residual is noise alone.
// Of two motions, a pixel follows the one with the smaller energy E_i(p), the mean over a box about
// p of min(r_i^2, limit). share = mean over p of w_2(p) / (w_1(p) + w_2(p)) with
// w_i = (E0 / (E0 + E_i))^3 as for the votes of patches, and E0 the energy that noise leaves.
#include "patches/pixel-motions.hpp"

#include "patches/patch-trust.hpp"

#include <algorithm>
#include <cmath>

// Windows are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patches/pixel-motions.cpp"
#include <hwy/foreach_target.h>

#include "patches/pixel-differences-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Box = MotionLabels::Box;
using LabelSheets = MotionLabels::Sheets;

HWY_INLINE float sum(Lanes lanes) {
  return hn::GetLane(hn::SumOfLanes(kTag, lanes));
}

// The pixels of which both places have neighbours on every side. Whole numbers, since 1 - d rounds
// to 1 for a tiny negative d, whose place is a pixel further.
Box seen_of(const Plane &plane, const Box &box, Displacement d) {
  const auto first = [](int from, float by) {
    return std::max({from, 1, 1 - static_cast<int>(std::floor(by))});
  };
  const auto last = [](int to, float by, int length) {
    return std::min({to, length - 1, length - 2 - static_cast<int>(std::ceil(by))});
  };
  return {first(box.left, d.x), first(box.top, d.y), last(box.right, d.x, plane.width()),
          last(box.bottom, d.y, plane.height())};
}

int pixels_in(const Box &box) {
  return std::max(0, box.width()) * std::max(0, box.height());
}

struct Sums {
  Tensor structure;      // w g g^T
  Displacement gradient; // w g
  float weight = 0;      // w
  Displacement cross;    // w g r
  float residual = 0;    // w r
  float absolute = 0;    // |r|
  float explained = 0;   // pixels
};

// The same in vectors.
struct LaneSums {
  Lanes xx, xy, yy, x, y, weight, rx, ry, residual, absolute, explained;

  void add(Lanes gx, Lanes gy, Lanes r, Lanes w) {
    const Lanes wx = hn::Mul(w, gx), wy = hn::Mul(w, gy);
    xx = hn::MulAdd(wx, gx, xx);
    xy = hn::MulAdd(wx, gy, xy);
    yy = hn::MulAdd(wy, gy, yy);
    x = hn::Add(x, wx);
    y = hn::Add(y, wy);
    weight = hn::Add(weight, w);
    rx = hn::MulAdd(wx, r, rx);
    ry = hn::MulAdd(wy, r, ry);
    residual = hn::MulAdd(w, r, residual);
    absolute = hn::Add(absolute, hn::Abs(r));
  }
  Sums totals() const {
    return {{sum(xx), sum(xy), sum(yy)},
            {sum(x), sum(y)},
            sum(weight),
            {sum(rx), sum(ry)},
            sum(residual),
            sum(absolute),
            sum(explained)};
  }
};

// A motion on its way to the one that its pixels follow.
struct Follower {
  Displacement displacement;
  float offset = 0; // grey levels
};

// The energies of a motion less those of another one, in rows of box.stride() pixels; their sign
// counts. None: all pixels count.
struct Rivals {
  const float *difference = nullptr;
  float sign = 1; // -1: of the other motion less this one's
  Box box;
};

// Of two motions, every third row of the box suffices, and the gradients of the earlier frame.
constexpr int kRows = 3;

// kBoth: the gradients of both frames. `inverse`: 1 / s^2. A pixel is explained if r^2 is below
// `limit`.
template <bool kBoth>
Sums sum_pixels(const Plane &earlier, const Plane &later, const Box &box, const Follower &follower,
                float inverse, float limit, const Rivals &rivals) {
  const Displacement d = follower.displacement;
  const auto whole_x = static_cast<int>(std::floor(d.x));
  const auto whole_y = static_cast<int>(std::floor(d.y));
  const Lanes u = hn::Set(kTag, d.x - static_cast<float>(whole_x));
  const Lanes v = hn::Set(kTag, d.y - static_cast<float>(whole_y));
  const Lanes quarter = hn::Set(kTag, 0.25F), one = hn::Set(kTag, 1),
              b = hn::Set(kTag, follower.offset);
  const Lanes narrowness = hn::Set(kTag, inverse), most = hn::Set(kTag, limit);
  const Lanes zero = hn::Zero(kTag);
  LaneSums sums{zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
  const int above = kBoth ? 0 : (box.top - rivals.box.top + kRows - 1) / kRows * kRows;
  const int first_row = kBoth ? box.top : rivals.box.top + above;
  const Lanes sign = hn::Set(kTag, rivals.sign);
  for (int row = first_row; row < box.bottom; row += kBoth ? 1 : kRows)
    for (int column = box.left; column < box.right; column += static_cast<int>(hn::Lanes(kTag))) {
      const float *before = earlier.row(row) + column;
      const std::ptrdiff_t stride = later.stride();
      const float *after = later.row(row + whole_y) + column + whole_x;
      const auto sample = [&](std::ptrdiff_t at) HWY_ATTR {
        const auto across = [&](const float *from) HWY_ATTR {
          const Lanes left = hn::LoadU(kTag, from);
          return hn::MulAdd(u, hn::Sub(hn::LoadU(kTag, from + 1), left), left);
        };
        const Lanes upper = across(after + at);
        return hn::MulAdd(v, hn::Sub(across(after + at + stride), upper), upper);
      };
      const auto gradient = [&](std::ptrdiff_t next_before, std::ptrdiff_t next_after) HWY_ATTR {
        const Lanes of_earlier =
            hn::Sub(hn::LoadU(kTag, before + next_before), hn::LoadU(kTag, before - next_before));
        if constexpr (!kBoth)
          return hn::Mul(hn::Set(kTag, 0.5F), of_earlier);
        const Lanes of_later = hn::Sub(sample(next_after), sample(-next_after));
        return hn::Mul(quarter, hn::Add(of_earlier, of_later));
      };
      auto inside = hn::FirstN(kTag, static_cast<std::size_t>(box.right - column));
      if (rivals.difference) {
        const int at = (row - rivals.box.top) * rivals.box.stride() + column - rivals.box.left;
        inside =
            hn::And(inside, hn::Lt(hn::Mul(sign, hn::LoadU(kTag, rivals.difference + at)), zero));
      }
      const auto kept = [&](Lanes value) HWY_ATTR { return hn::IfThenElseZero(inside, value); };
      const Lanes r = kept(hn::Sub(hn::Sub(sample(0), hn::LoadU(kTag, before)), b));
      const Lanes r2 = hn::Mul(r, r);
      const Lanes gx = kept(gradient(1, 1));
      const Lanes gy = kept(gradient(earlier.stride(), stride));
      const Lanes root = hn::Div(one, hn::MulAdd(r2, narrowness, one));
      const Lanes w = kept(hn::Mul(root, root));
      sums.add(gx, gy, r, w);
      sums.explained = hn::Add(sums.explained, kept(hn::IfThenElseZero(hn::Lt(r2, most), one)));
    }
  return sums.totals();
}

// Returns the squared length of the step, px squared.
float advance(const Sums &sums, Follower &follower) {
  constexpr float kRidge = 1; // grey levels squared per px squared: without texture it stays
  // The offset is eliminated.
  const Displacement mean = 1 / sums.weight * sums.gradient;
  const Tensor structure{sums.structure.xx - sums.gradient.x * mean.x,
                         sums.structure.xy - sums.gradient.x * mean.y,
                         sums.structure.yy - sums.gradient.y * mean.y};
  const Displacement step = solve(structure, sums.cross - sums.residual * mean, kRidge);
  follower.displacement -= step;
  follower.offset += sums.residual / sums.weight - dot(mean, step);
  return norm2(step);
}

DominantMotion FindDominant(const Plane &earlier, const Plane &later, const Box &region,
                            Displacement start, float noise) {
  constexpr int kSteps = 20;
  constexpr float kOverNoise = 6;      // of s^2
  constexpr float kOverResiduals2 = 4; // s^2 at first
  constexpr float kNarrowing = 0.7F;   // of s^2, each step
  constexpr float kConverged2 = 1e-5F; // px squared
  constexpr float kFurthest2 = 2 * 2;  // px squared, from the start
  const float least2 = kOverNoise * 2 * kSmoothedNoise * noise;
  Follower follower{start};
  float share = 1;
  float scale2 = 0;
  for (int step = 0; step < kSteps; ++step) {
    const Box box = seen_of(earlier, region, follower.displacement);
    if (2 * pixels_in(box) < pixels_in(region))
      return {start};
    const auto pixels = static_cast<float>(pixels_in(box));
    const Sums sums = sum_pixels<true>(earlier, later, box, follower, scale2 > 0 ? 1 / scale2 : 0,
                                       2 * least2, {});
    share = sums.explained / pixels;
    const float moved2 = advance(sums, follower);
    if (!(norm2(follower.displacement - start) < kFurthest2))
      return {start};
    if (scale2 == least2 && moved2 < kConverged2)
      break;
    const float residual = sums.absolute / pixels;
    scale2 =
        std::max(least2, scale2 > 0 ? kNarrowing * scale2 : kOverResiduals2 * residual * residual);
  }
  return {follower.displacement, share};
}

constexpr int kWide = 9;
constexpr int kNarrow = 5;

// Means of the energies over a box about each pixel of every kStep-th row.
template <int kBox, int kStep = 1>
void average_boxes(const Box &box, LabelSheets &sheets, MotionLabels::Pixels &means) {
  const int stride = box.stride();
  constexpr int kFirst = (kWide - kBox) / 2;
  const float *energies = sheets.energies.data() + kFirst * stride + kFirst;
  float *columns = sheets.columns.data();
  for (int x = 0; x < box.width() + kBox - 1; x += lanes()) {
    Lanes sum = hn::Zero(kTag);
    for (int y = 0; y < kBox - 1; ++y)
      sum = hn::Add(sum, hn::LoadU(kTag, energies + y * stride + x));
    for (int y = 0; y < box.height(); ++y) {
      sum = hn::Add(sum, hn::LoadU(kTag, energies + (y + kBox - 1) * stride + x));
      hn::StoreU(sum, kTag, columns + y * stride + x);
      sum = hn::Sub(sum, hn::LoadU(kTag, energies + y * stride + x));
    }
  }
  const Lanes scale = hn::Set(kTag, 1.0F / (kBox * kBox));
  for (int y = 0; y < box.height(); y += kStep)
    for (int x = 0; x < box.width(); x += lanes()) {
      const float *column = columns + y * stride + x;
      Lanes sum = hn::LoadU(kTag, column);
      for (int i = 1; i < kBox; ++i)
        sum = hn::Add(sum, hn::LoadU(kTag, column + i));
      hn::StoreU(hn::Mul(scale, sum), kTag, means.data() + y * stride + x);
    }
}

// No difference of the grey levels is allowed for: it would be another one for each motion.
// kLess: what the sheet holds less the energies.
template <bool kLess = false>
void fill_energies(const Plane &earlier, const Plane &later, const Box &box, Displacement d,
                   float limit, LabelSheets &sheets) {
  const int stride = box.stride();
  const Lanes most = hn::Set(kTag, limit);
  for_differences(earlier, later, box.left - kWide / 2, box.top - kWide / 2,
                  box.width() + kWide - 1, box.height() + kWide - 1, d,
                  [&](int x, int y, Lanes difference) HWY_ATTR {
                    float *to = sheets.energies.data() + y * stride + x;
                    Lanes energy = hn::Min(hn::Mul(difference, difference), most);
                    if constexpr (kLess)
                      energy = hn::Sub(hn::LoadU(kTag, to), energy);
                    hn::StoreU(energy, kTag, to);
                  });
}

// The shares of the pixels that follow the second motion and neither.
TwoMotions judge(const Box &box, float limit, float noise, const LabelSheets &sheets) {
  const int stride = box.stride();
  const Lanes zero = hn::Zero(kTag), one = hn::Set(kTag, 1), expected = hn::Set(kTag, noise);
  Lanes share = zero, unexplained = zero;
  for (int y = 0; y < box.height(); ++y)
    for (int x = 0; x < box.width(); x += lanes()) {
      const int at = y * stride + x;
      const auto inside = hn::FirstN(kTag, static_cast<std::size_t>(box.width() - x));
      const auto cube = [&](const MotionLabels::Pixels &energies) HWY_ATTR {
        const Lanes sum = hn::Add(expected, hn::LoadU(kTag, energies.data() + at));
        return hn::Mul(sum, hn::Mul(sum, sum));
      };
      // The weights times both sums: w2 / (w1 + w2) = cube1 / (cube1 + cube2).
      const Lanes first = cube(sheets.wide[0]);
      const Lanes second = cube(sheets.wide[1]);
      share = hn::Add(share, hn::IfThenElseZero(inside, hn::Div(first, hn::Add(first, second))));
      const Lanes least = hn::Min(hn::LoadU(kTag, sheets.narrow[0].data() + at),
                                  hn::LoadU(kTag, sheets.narrow[1].data() + at));
      unexplained = hn::Add(
          unexplained,
          hn::IfThenElseZero(hn::And(inside, hn::Gt(least, hn::Set(kTag, limit / 2))), one));
    }
  const auto pixels = static_cast<float>(pixels_in(box));
  return {{}, {}, sum(share) / pixels, sum(unexplained) / pixels};
}

TwoMotions FindTwo(const Plane &earlier, const Plane &later, const Box &box, Displacement first,
                   Displacement second, float noise, LabelSheets &sheets) {
  constexpr int kSteps = 2;
  constexpr float kScale2 = 20;   // s^2, grey levels squared
  constexpr float kFurthest2 = 2; // px squared, from the start
  constexpr float kFewest = 5;    // weight of pixels, that a fit needs
  const float limit = largest_residual2(noise);
  const std::array<Displacement, 2> starts = {first, second};
  std::array<Follower, 2> followers = {Follower{first}, Follower{second}};
  fill_energies(earlier, later, box, first, limit, sheets);
  fill_energies<true>(earlier, later, box, second, limit, sheets);
  average_boxes<kWide, kRows>(box, sheets, sheets.wide[0]);
  for (std::size_t i = 0; i < 2; ++i) {
    const Rivals rivals{sheets.wide[0].data(), i == 0 ? 1.0F : -1.0F, box};
    for (int step = 0; step < kSteps; ++step) {
      const Box seen = seen_of(earlier, box, followers[i].displacement);
      const Sums sums =
          sum_pixels<false>(earlier, later, seen, followers[i], 1 / kScale2, 0, rivals);
      if (sums.weight >= kFewest)
        advance(sums, followers[i]);
      if (sums.weight < kFewest || !(norm2(followers[i].displacement - starts[i]) < kFurthest2)) {
        followers[i] = {starts[i]};
        break;
      }
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    fill_energies(earlier, later, box, followers[i].displacement, limit, sheets);
    average_boxes<kWide>(box, sheets, sheets.wide[i]);
    average_boxes<kNarrow>(box, sheets, sheets.narrow[i]);
  }
  TwoMotions found = judge(box, limit, 2 * kSmoothedNoise * noise, sheets);
  found.first = followers[0].displacement;
  found.second = followers[1].displacement;
  return found;
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(FindDominant);
HWY_EXPORT(FindTwo);

MotionLabels::Box box_of(const Area &region, int largest) {
  const auto first = [](float from) { return static_cast<int>(std::floor(from)); };
  const auto last = [&](float from, float length) {
    return first(from) +
           std::clamp(static_cast<int>(std::ceil(from + length)) - first(from), 1, largest);
  };
  return {first(region.x), first(region.y), last(region.x, region.width),
          last(region.y, region.height)};
}

} // namespace

DominantMotion find_dominant_motion(const Plane &earlier, const Plane &later, const Area &region,
                                    Displacement start, float noise) {
  const int largest = std::max(earlier.width(), earlier.height());
  return HWY_DYNAMIC_DISPATCH(FindDominant)(earlier, later, box_of(region, largest), start, noise);
}

TwoMotions MotionLabels::find(const Plane &earlier, const Plane &later, const Area &region,
                              Displacement first, Displacement second, float noise) {
  box_ = box_of(region, kLargestSide);
  return HWY_DYNAMIC_DISPATCH(FindTwo)(earlier, later, box_, first, second, noise, sheets_);
}

std::size_t MotionLabels::place_of(float x, float y) const {
  const auto place = [](float at, int first, int last) {
    return std::clamp(static_cast<int>(std::floor(at)), first, last - 1) - first;
  };
  return cell(place(y, box_.top, box_.bottom), box_.stride(), place(x, box_.left, box_.right));
}

bool MotionLabels::follows_second(float x, float y) const {
  const std::size_t at = place_of(x, y);
  return sheets_.wide[1][at] < sheets_.wide[0][at];
}

float MotionLabels::energy(float x, float y) const {
  const std::size_t at = place_of(x, y);
  return std::min(sheets_.narrow[0][at], sheets_.narrow[1][at]);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
