// SPDX-License-Identifier: LGPL-2.1-or-later
// Sources of the formulas:
//   Lucas and Kanade, An iterative image registration technique, IJCAI 1981
//   Baker and Matthews, Lucas-Kanade 20 years on: a unifying framework, IJCV 56, 2004: inverse
//     compositional, with the gradients and the Hessian of the earlier frame
//   Hager and Belhumeur, Efficient region tracking with parametric models of geometry and
//     illumination, PAMI 20, 1998: gradients made orthogonal to what illumination may change
//   Gennert and Negahdaripour, Relaxing the brightness constancy assumption in computing optical
//     flow, MIT AI memo 975, 1987: illumination as a gain and an offset
//   Shi and Tomasi, Good features to track, CVPR 1994: structure tensor and texture
//   Lewis, Fast normalized cross-correlation, 1995: zero-mean normalised correlation
// Notation: T(x) are the grey levels of a patch in the earlier frame, I those of the later frame, n
// the pixels of the patch; sums run over its pixels, a bar is a mean over them.
#include "patches/lk-kernels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

// Planes and patches are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patches/lk-kernels.cpp"
#include <hwy/foreach_target.h>

#include "pixels/for-row-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A patch row is 8 or 16 floats; narrower vectors take several steps per row.
template <int kSide>
using RowTag = hn::CappedTag<float, kSide>;

template <class D>
float total(D d, hn::Vec<D> v) {
  return hn::GetLane(hn::SumOfLanes(d, v));
}

// The totals of four vectors at once.
#if HWY_TARGET == HWY_SCALAR
template <class D>
HWY_INLINE void four_totals(D d, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> c, hn::Vec<D> e,
                            float *totals) {
  for (const auto v : {a, b, c, e})
    *totals++ = total(d, v);
}
#else
template <class D>
HWY_INLINE auto to_four_lanes(D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(d) <= 4) {
    return v;
  } else {
    const hn::Half<D> half;
    return to_four_lanes(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}
template <class D>
HWY_INLINE void four_totals(D d, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> c, hn::Vec<D> e,
                            float *totals) {
  const hn::CappedTag<float, 4> four;
  const auto pairs = [&](auto first, auto second) HWY_ATTR {
    return hn::Add(hn::InterleaveLower(four, first, second),
                   hn::InterleaveUpper(four, first, second));
  };
  const auto ab = pairs(to_four_lanes(d, a), to_four_lanes(d, b));
  const auto ce = pairs(to_four_lanes(d, c), to_four_lanes(d, e));
  hn::Store(hn::Add(hn::ConcatLowerLower(four, ce, ab), hn::ConcatUpperUpper(four, ce, ab)), four,
            totals);
}
#endif

// Bilinear samples of a patch and of one more pixel on every side:
//   tile = (1-v) ((1-u) f(x, y) + u f(x+1, y)) + v ((1-u) f(x, y+1) + u f(x+1, y+1))
// at the fraction (u, v) of a pixel.
template <int kSide>
HWY_INLINE void SampleTile(const float *first, std::ptrdiff_t stride, float u, float v,
                           float *tile) {
  constexpr int kTile = kSide + 2;
  const RowTag<kSide> d;
  const auto wu = hn::Set(d, u), wv = hn::Set(d, v);
  for_row(d, kTile, [&](int x) HWY_ATTR {
    const float *from = first - stride - 1 + x;
    const auto across = [&] HWY_ATTR {
      const auto left = hn::LoadU(d, from);
      const auto sampled = hn::MulAdd(wu, hn::Sub(hn::LoadU(d, from + 1), left), left);
      from += stride;
      return sampled;
    };
    auto upper = across();
    for (int y = 0; y < kTile; ++y) {
      const auto lower = across();
      hn::StoreU(hn::MulAdd(wv, hn::Sub(lower, upper), upper), d, tile + y * kTile + x);
      upper = lower;
    }
  });
}

// Sums over the pixels of a template.
struct TemplateSums {
  float grey;                 // T
  Displacement gradient;      // g
  float grey2;                // T^2
  Displacement grey_gradient; // T g
  Tensor gradient2;           // g g^T
  float laplacian;            // L
  float grey_laplacian;       // T L
  float laplacian2;           // L^2
};

// Copies the pixels, and computes central differences and the Laplacian:
//   g = (T(x+1, y) - T(x-1, y), T(x, y+1) - T(x, y-1)) / 2
//   L = T(x-1, y) + T(x+1, y) + T(x, y-1) + T(x, y+1) - 4 T(x, y)
template <int kSide>
HWY_INLINE TemplateSums SumTemplate(const float *first, std::ptrdiff_t stride, Template &patch) {
  const RowTag<kSide> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  using V = hn::Vec<RowTag<kSide>>;
  const auto half = hn::Set(d, 0.5F), four = hn::Set(d, 4.0F);
  V s = hn::Zero(d), sx = hn::Zero(d), sy = hn::Zero(d), ss = hn::Zero(d), stx = hn::Zero(d),
    sty = hn::Zero(d);
  V sxx = hn::Zero(d), sxy = hn::Zero(d), syy = hn::Zero(d);
  V sl = hn::Zero(d), stl = hn::Zero(d), sll = hn::Zero(d);
  for (int y = 0; y < kSide; ++y) {
    const float *mid = first + y * stride;
    const float *up = mid - stride;
    const float *low = mid + stride;
    for (int x = 0; x < kSide; x += lanes) {
      const V t = hn::LoadU(d, mid + x);
      const V left = hn::LoadU(d, mid + x - 1), right = hn::LoadU(d, mid + x + 1);
      const V above = hn::LoadU(d, up + x), below = hn::LoadU(d, low + x);
      const V gx = hn::Mul(half, hn::Sub(right, left));
      const V gy = hn::Mul(half, hn::Sub(below, above));
      const V laplacian =
          hn::NegMulAdd(four, t, hn::Add(hn::Add(left, right), hn::Add(above, below)));
      hn::Store(t, d, patch.grey.data() + y * kSide + x);
      hn::Store(gx, d, patch.gradient_x.data() + y * kSide + x);
      hn::Store(gy, d, patch.gradient_y.data() + y * kSide + x);
      s = hn::Add(s, t);
      sx = hn::Add(sx, gx);
      sy = hn::Add(sy, gy);
      ss = hn::MulAdd(t, t, ss);
      stx = hn::MulAdd(t, gx, stx);
      sty = hn::MulAdd(t, gy, sty);
      sxx = hn::MulAdd(gx, gx, sxx);
      sxy = hn::MulAdd(gx, gy, sxy);
      syy = hn::MulAdd(gy, gy, syy);
      sl = hn::Add(sl, laplacian);
      stl = hn::MulAdd(t, laplacian, stl);
      sll = hn::MulAdd(laplacian, laplacian, sll);
    }
  }
  HWY_ALIGN float first_sums[4], second_sums[4], third_sums[4];
  four_totals(d, s, sx, sy, ss, first_sums);
  four_totals(d, stx, sty, sxx, sxy, second_sums);
  four_totals(d, syy, sl, stl, sll, third_sums);
  return {first_sums[0],
          {first_sums[1], first_sums[2]},
          first_sums[3],
          {second_sums[0], second_sums[1]},
          {second_sums[2], second_sums[3], third_sums[0]},
          third_sums[1],
          third_sums[2],
          third_sums[3]};
}

// T <- T - mean, g <- g - mean_gradient - a (T - mean)
template <int kSide>
HWY_INLINE void ProjectOut(float mean, Displacement mean_gradient, Displacement a,
                           Template &patch) {
  const RowTag<kSide> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto vm = hn::Set(d, mean), vax = hn::Set(d, a.x), vay = hn::Set(d, a.y),
             vmx = hn::Set(d, mean_gradient.x), vmy = hn::Set(d, mean_gradient.y);
  for (int i = 0; i < kSide * kSide; i += lanes) {
    const auto t = hn::Sub(hn::Load(d, patch.grey.data() + i), vm);
    hn::Store(t, d, patch.grey.data() + i);
    hn::Store(hn::NegMulAdd(vax, t, hn::Sub(hn::Load(d, patch.gradient_x.data() + i), vmx)), d,
              patch.gradient_x.data() + i);
    hn::Store(hn::NegMulAdd(vay, t, hn::Sub(hn::Load(d, patch.gradient_y.data() + i), vmy)), d,
              patch.gradient_y.data() + i);
  }
}

// With the zero-mean grey levels t = T - mean(T):
//   energy     E = sum t^2
//   slope      -sum t L, which is the sum of |grad T|^2 but for the pixels at the rim (summation by
//              parts)
//   curvature  sum L^2
//   b = sum t g,  a = b / (E + r)
//   projected gradient   g' = g - mean(g) - a t, which a change of offset or gain leaves alone
//   bias                 sum t g' = b - a E = r a, 0 but for the ridge
//   structure tensor     J = sum g' g'^T
//                          = sum g g^T - n mean(g) mean(g)^T - a b^T - b a^T + E a a^T
// with r = kEnergyRidge n. Inverse compositional Lucas-Kanade (Baker and Matthews 2004); the
// projection follows Hager and Belhumeur 1998 with the illumination of Gennert and Negahdaripour
// 1987.
template <int kSide>
void PrepareTemplate(const float *first, std::ptrdiff_t stride, Template &patch) {
  constexpr float kPixels = kSide * kSide;
  patch.seen = 0;
  const TemplateSums sums = SumTemplate<kSide>(first, stride, patch);
  const float mean = sums.grey / kPixels;
  const float mean_x = sums.gradient.x / kPixels;
  const float mean_y = sums.gradient.y / kPixels;
  patch.energy = std::max(0.0F, sums.grey2 - kPixels * mean * mean);
  patch.slope = mean * sums.laplacian - sums.grey_laplacian;
  patch.curvature = sums.laplacian2;
  const float bx = sums.grey_gradient.x - kPixels * mean * mean_x;
  const float by = sums.grey_gradient.y - kPixels * mean * mean_y;
  const float inverse_energy = 1.0F / (patch.energy + kEnergyRidge * kPixels);
  const float ax = bx * inverse_energy;
  const float ay = by * inverse_energy;
  patch.structure.xx =
      sums.gradient2.xx - kPixels * mean_x * mean_x - ax * (2 * bx - ax * patch.energy);
  patch.structure.xy =
      sums.gradient2.xy - kPixels * mean_x * mean_y - ax * by - ay * bx + ax * ay * patch.energy;
  patch.structure.yy =
      sums.gradient2.yy - kPixels * mean_y * mean_y - ay * (2 * by - ay * patch.energy);
  patch.bias = kEnergyRidge * kPixels * Displacement{ax, ay};
  ProjectOut<kSide>(mean, {mean_x, mean_y}, {ax, ay}, patch);
}

// Place of a displaced patch: a pointer for the whole pixels, weights for the fraction.
struct Position {
  const float *first;
  float u;
  float v;
  bool inside; // or outside by a fraction of a pixel, and moved to the border
};

HWY_INLINE Position locate(const Plane &plane, const Template &patch, Displacement moved) {
  constexpr float kTolerance = 0.25F;
  const auto kept = [&](float at, int length) {
    return std::clamp(at, 0.0F, static_cast<float>(length - patch.side) - 1.001F);
  };
  const float wanted_x = patch.x + moved.x;
  const float wanted_y = patch.y + moved.y;
  const float x = kept(wanted_x, plane.width());
  const float y = kept(wanted_y, plane.height());
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  return {plane.row(row) + column, x - static_cast<float>(column), y - static_cast<float>(row),
          std::abs(x - wanted_x) <= kTolerance && std::abs(y - wanted_y) <= kTolerance};
}

// Calls body(at, grey levels of the later frame at the displaced pixels from patch index `at`).
// The samples are bilinear, as in SampleTile.
template <int kSide, class Body>
HWY_INLINE void for_pixels(const Plane &plane, Position position, Body &&body) {
  const RowTag<kSide> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto u = hn::Set(d, position.u), v = hn::Set(d, position.v);
  for (int x = 0; x < kSide; x += lanes) {
    const float *from = position.first + x;
    auto left = hn::LoadU(d, from);
    auto upper = hn::MulAdd(u, hn::Sub(hn::LoadU(d, from + 1), left), left);
    for (int y = 0; y < kSide; ++y) {
      from += plane.stride();
      left = hn::LoadU(d, from);
      const auto lower = hn::MulAdd(u, hn::Sub(hn::LoadU(d, from + 1), left), left);
      body(y * kSide + x, hn::MulAdd(v, hn::Sub(lower, upper), upper));
      upper = lower;
    }
  }
}

// Calls body(at, grey levels of the later frame at x + d + S o), with the strain S and the offset o
// of a pixel x from the middle of the patch. All pixels of a row are sampled from the cell of its
// middle: what the strain moves them along the row is a fraction of a pixel, over which bilinear
// weights extrapolate.
template <int kSide, class Body>
HWY_INLINE void for_strained_pixels(const Plane &plane, const Template &patch, Displacement moved,
                                    const Strain &strain, Body &&body) {
  const RowTag<kSide> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr float kMiddle = 0.5F * (kSide - 1);
  const auto cell_of = [](float at, int length) {
    return std::clamp(static_cast<int>(at), 0, length);
  };
  for (int y = 0; y < kSide; ++y) {
    const float down = static_cast<float>(y) - kMiddle;
    const float to_x = patch.x + moved.x + strain.xy * down;
    const float to_y = patch.y + moved.y + strain.yy * down + static_cast<float>(y);
    const int column = cell_of(to_x, plane.width() - kSide - 1);
    const int row = cell_of(to_y, plane.height() - 2);
    const auto u = hn::Set(d, to_x - static_cast<float>(column));
    const auto v = hn::Set(d, to_y - static_cast<float>(row));
    for (int x = 0; x < kSide; x += lanes) {
      const auto right = hn::Iota(d, static_cast<float>(x) - kMiddle);
      const auto wu = hn::MulAdd(hn::Set(d, strain.xx), right, u);
      const auto wv = hn::MulAdd(hn::Set(d, strain.yx), right, v);
      const auto across = [&](const float *from) HWY_ATTR {
        const auto left = hn::LoadU(d, from);
        return hn::MulAdd(wu, hn::Sub(hn::LoadU(d, from + 1), left), left);
      };
      const float *from = plane.row(row) + column + x;
      const auto upper = across(from);
      const auto lower = across(from + plane.stride());
      body(y * kSide + x, hn::MulAdd(wv, hn::Sub(lower, upper), upper));
    }
  }
}

// With the samples I(x + d) and E, t, g' of the template:
//   gradient     b(d) = sum g' I(x + d) - sum g' t, the right side of J step = b. The second sum is
//                the bias, which would draw every displacement towards rest
//   correlation  c(d) = sum t I / sqrt(E sum (I - mean(I))^2), zero-mean normalised (Lewis 1995)
//   residual     what the best gain and offset leave: the least (over gain and offset) of
//                sum (I - gain t - offset)^2 = sum (I - mean(I))^2 - (sum t I)^2 / E,
//                as root of the mean; a negative gain explains nothing
// One pass over the pixels suffices, because sum t = 0.
struct FitSums {
  Displacement gradient; // sum g' (I - t)
  float cross = 0;       // sum t I
  float energy = 0;      // sum (I - mean(I))^2

  // n times the squared residual.
  float left(float inverse_energy) const {
    return std::max(0.0F, energy - (cross > 0 ? cross * cross * inverse_energy : 0.0F));
  }
};

HWY_INLINE float inverse_energy_of(const Template &patch) {
  return 1 / std::max(1e-6F, patch.energy);
}

// Number of pixels that have a weight.
template <int kSide>
HWY_INLINE float pixels_of(const Template &patch) {
  return patch.seen > 0 ? patch.seen : kSide * kSide;
}

// `sample` calls a body for all pixels. kSome: only the pixels that have a weight.
template <int kSide, bool kSome, class Sample>
HWY_INLINE FitSums SumPixels(const Template &patch, Sample &&sample) {
  const RowTag<kSide> d;
  auto bx = hn::Zero(d), by = hn::Zero(d), s = hn::Zero(d), ss = hn::Zero(d), st = hn::Zero(d);
  sample([&](int at, auto grey) HWY_ATTR {
    const auto t = hn::Load(d, patch.grey.data() + at);
    if constexpr (kSome)
      grey = hn::IfThenElseZero(hn::Ne(t, hn::Zero(d)), grey);
    bx = hn::MulAdd(hn::Load(d, patch.gradient_x.data() + at), grey, bx);
    by = hn::MulAdd(hn::Load(d, patch.gradient_y.data() + at), grey, by);
    s = hn::Add(s, grey);
    ss = hn::MulAdd(grey, grey, ss);
    st = hn::MulAdd(t, grey, st);
  });
  HWY_ALIGN float totals[4];
  four_totals(d, bx, by, s, st, totals);
  const float pixels = kSome ? patch.seen : kSide * kSide;
  const float mean = totals[2] / pixels;
  return {Displacement{totals[0], totals[1]} - patch.bias, totals[3],
          total(d, ss) - pixels * mean * mean};
}

template <int kSide, bool kSome>
HWY_INLINE FitSums SumShifted(const Plane &plane, const Template &patch, Position position) {
  return SumPixels<kSide, kSome>(patch, [&](auto &&body)
                                            HWY_ATTR { for_pixels<kSide>(plane, position, body); });
}

template <int kSide>
HWY_NOINLINE FitSums SumSomePixels(const Plane &plane, const Template &patch, Position position) {
  return SumShifted<kSide, true>(plane, patch, position);
}

template <int kSide>
HWY_INLINE FitSums SumFit(const Plane &plane, const Template &patch, Position position) {
  return patch.seen > 0 ? SumSomePixels<kSide>(plane, patch, position)
                        : SumShifted<kSide, false>(plane, patch, position);
}

template <int kSide>
HWY_NOINLINE FitSums SumStrained(const Plane &plane, const Template &patch, Displacement moved,
                                 const Strain &strain) {
  const auto sample = [&](auto &&body) HWY_ATTR {
    for_strained_pixels<kSide>(plane, patch, moved, strain, body);
  };
  return patch.seen > 0 ? SumPixels<kSide, true>(patch, sample)
                        : SumPixels<kSide, false>(patch, sample);
}

template <int kSide>
HWY_INLINE Fit fit_of(const Template &patch, const FitSums &sums) {
  Fit fit;
  fit.inside = true;
  fit.gradient = sums.gradient;
  fit.correlation = sums.cross / std::sqrt(std::max(1e-6F, sums.energy * patch.energy));
  fit.residual = std::sqrt(sums.left(inverse_energy_of(patch)) / pixels_of<kSide>(patch));
  return fit;
}

template <int kSide>
HWY_INLINE Fit FitTemplate(const Plane &plane, const Template &patch, Displacement moved) {
  const Position position = locate(plane, patch, moved);
  return position.inside ? fit_of<kSide>(patch, SumFit<kSide>(plane, patch, position)) : Fit{};
}

// Gauss-Newton (Lucas and Kanade 1981; inverse compositional after Baker and Matthews 2004):
//   d <- d - (J + r I)^-1 b(d)
// with the structure tensor J, the gradient b(d) of FitTemplate and r of regulariser(). Starts from
// the displacement of least residual, and returns that of least residual on the way.
template <int kSide>
class Descent {
public:
  Descent() = default;
  Descent(const Plane &plane, const Template &patch, const Strain *strain = nullptr)
      : plane_(&plane), patch_(&patch), strain_(strain), inverse_energy_(inverse_energy_of(patch)) {
  }

  void try_start(Displacement start) {
    if (fit(start) && residual_ < least_)
      keep_best();
  }
  // Whether a start has a smaller residual than `residual`.
  bool starts_below(float residual) const {
    return least_ < pixels_of<kSide>(*patch_) * residual * residual;
  }

  void prepare() {
    const float ridge = regulariser(patch_->structure, kSide * kSide);
    inverse_ = patch_->structure;
    const float xx = inverse_.xx + ridge;
    const float yy = inverse_.yy + ridge;
    const float scale = 1 / (xx * yy - inverse_.xy * inverse_.xy);
    inverse_ = {yy * scale, -inverse_.xy * scale, xx * scale};
    start_ = at_ = best_;
    sums_ = best_sums_;
    residual_ = least_;
  }

  // Returns whether another step may improve the fit.
  bool step() {
    constexpr float kFurthest = 4;      // px from the start
    constexpr float kConverged = 3e-4F; // px squared
    constexpr float kLongest = 1;       // px
    const Displacement g = sums_.gradient;
    const Displacement step{inverse_.xx * g.x + inverse_.xy * g.y,
                            inverse_.xy * g.x + inverse_.yy * g.y};
    const float length2 = norm2(step);
    const float scale = length2 > kLongest * kLongest ? kLongest / std::sqrt(length2) : 1.0F;
    const Displacement next = at_ - scale * step;
    if (norm2(next - start_) > kFurthest * kFurthest)
      return false;
    // So short a step does not change the fit.
    if (length2 < kConverged) {
      if (residual_ == least_)
        best_ = next;
      return false;
    }
    if (!fit(next))
      return false;
    if (residual_ < least_)
      keep_best();
    return true;
  }

  Alignment result() const { return {best_, fit_of<kSide>(*patch_, best_sums_)}; }

private:
  // Returns false outside the plane.
  bool fit(Displacement at) {
    const Position position = locate(*plane_, *patch_, at);
    if (!position.inside)
      return false;
    at_ = at;
    sums_ = strain_ ? SumStrained<kSide>(*plane_, *patch_, at, *strain_)
                    : SumFit<kSide>(*plane_, *patch_, position);
    residual_ = sums_.left(inverse_energy_);
    return true;
  }
  void keep_best() {
    best_ = at_;
    best_sums_ = sums_;
    least_ = residual_;
  }

  const Plane *plane_ = nullptr;
  const Template *patch_ = nullptr;
  const Strain *strain_ = nullptr; // nullptr: it only shifts
  float inverse_energy_ = 0;
  Tensor inverse_; // (J + r I)^-1
  Displacement start_;
  Displacement at_;
  FitSums sums_; // there
  float residual_ = 0;
  Displacement best_;
  FitSums best_sums_;
  float least_ = std::numeric_limits<float>::infinity();
};

// The steps of several patches take turns: they do not depend on one another, and the processor
// works on more than one at a time.
inline constexpr std::size_t kTogether = 8;

template <int kSide>
void AlignSome(const Plane &plane, std::span<const Template> patches,
               std::span<const std::span<const Displacement>> starts, int iterations,
               std::span<Alignment> found, const Strain *strain) {
  std::array<Descent<kSide>, kTogether> descents;
  std::array<std::size_t, kTogether> moving, started;
  std::size_t count = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (starts[i].empty())
      continue;
    Descent<kSide> &descent = descents[count];
    descent = Descent<kSide>(plane, patches[i], strain);
    for (const Displacement start : starts[i])
      descent.try_start(start);
    if (descent.starts_below(found[i].fit.residual)) {
      descent.prepare();
      moving[count] = count;
      started[count++] = i;
    } else if (!found[i].fit.inside) {
      found[i] = {starts[i][0], {}};
    }
  }
  std::size_t still_moving = count;
  for (int step = 0; step < iterations && still_moving > 0; ++step) {
    const std::size_t before = std::exchange(still_moving, 0);
    for (std::size_t k = 0; k < before; ++k)
      if (descents[moving[k]].step())
        moving[still_moving++] = moving[k];
  }
  for (std::size_t k = 0; k < count; ++k)
    found[started[k]] = descents[k].result();
}

template <int kSide>
void AlignTemplatesOf(const Plane &plane, std::span<const Template> patches,
                      std::span<const std::span<const Displacement>> starts, int iterations,
                      std::span<Alignment> found, const Strain *strain) {
  for (std::size_t i = 0; i < patches.size(); i += kTogether) {
    const std::size_t count = std::min(kTogether, patches.size() - i);
    AlignSome<kSide>(plane, patches.subspan(i, count), starts.subspan(i, count), iterations,
                     found.subspan(i, count), strain);
  }
}

template <int kSide>
Alignment AlignStrainedOf(const Plane &plane, const Template &patch, const Strain &strain,
                          Displacement start, int iterations) {
  Descent<kSide> descent(plane, patch, &strain);
  descent.try_start(start);
  if (!descent.starts_below(Fit{}.residual))
    return {start, {}};
  descent.prepare();
  for (int step = 0; step < iterations && descent.step(); ++step) {
  }
  return descent.result();
}

// Zero-mean normalised correlation with the pixels at a whole-pixel place (Lewis 1995):
//   c = sum t I / sqrt(E sum (I - mean(I))^2)
template <int kSide>
HWY_INLINE float Correlation(const float *first, std::ptrdiff_t stride, const Template &patch) {
  const RowTag<kSide> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr float kPixels = kSide * kSide;
  auto s = hn::Zero(d), ss = hn::Zero(d), st = hn::Zero(d);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; x += lanes) {
      const auto grey = hn::LoadU(d, first + y * stride + x);
      s = hn::Add(s, grey);
      ss = hn::MulAdd(grey, grey, ss);
      st = hn::MulAdd(hn::Load(d, patch.grey.data() + y * kSide + x), grey, st);
    }
  const float mean = total(d, s) / kPixels;
  const float energy = std::max(1e-6F, total(d, ss) - kPixels * mean * mean);
  return total(d, st) / std::sqrt(energy * std::max(1e-6F, patch.energy));
}

// Full search of the maximum of the correlation over whole pixels.
template <int kSide>
SearchResult SearchTemplate(const Plane &plane, const Template &patch, Displacement centre,
                            int radius) {
  const int cx = static_cast<int>(std::lround(patch.x + centre.x)),
            cy = static_cast<int>(std::lround(patch.y + centre.y));
  const int left = std::max(0, cx - radius), right = std::min(plane.width() - kSide, cx + radius);
  const int top = std::max(0, cy - radius), bottom = std::min(plane.height() - kSide, cy + radius);
  SearchResult result;
  int best_x = 0, best_y = 0;
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const float correlation = Correlation<kSide>(plane.row(y) + x, plane.stride(), patch);
      if (correlation > result.correlation) {
        result.correlation = correlation;
        best_x = x;
        best_y = y;
      }
    }
  result.best = {static_cast<float>(best_x) - patch.x, static_cast<float>(best_y) - patch.y};
  return result;
}

template <int kSide>
void PrepareTemplatesOf(const Plane &plane, std::span<Template> patches) {
  for (Template &patch : patches) {
    const int column = static_cast<int>(patch.x);
    const int row = static_cast<int>(patch.y);
    const float u = patch.x - static_cast<float>(column);
    const float v = patch.y - static_cast<float>(row);
    const float *first = plane.row(row) + column;
    if (u == 0 && v == 0) {
      PrepareTemplate<kSide>(first, plane.stride(), patch);
      continue;
    }
    constexpr int kTile = kSide + 2;
    HWY_ALIGN float tile[kTile * kTile];
    SampleTile<kSide>(first, plane.stride(), u, v, tile);
    PrepareTemplate<kSide>(tile + kTile + 1, kTile, patch);
  }
}

template <int kSide>
void FitTemplatesOf(const Plane &plane, std::span<const Template> patches, Displacement moved,
                    std::span<Fit> fits) {
  for (std::size_t i = 0; i < patches.size(); ++i)
    fits[i] = FitTemplate<kSide>(plane, patches[i], moved);
}

void PrepareTemplates(const Plane &plane, std::span<Template> patches) {
  patches.front().side == 16 ? PrepareTemplatesOf<16>(plane, patches)
                             : PrepareTemplatesOf<8>(plane, patches);
}
void FitTemplates(const Plane &plane, std::span<const Template> patches, Displacement moved,
                  std::span<Fit> fits) {
  patches.front().side == 16 ? FitTemplatesOf<16>(plane, patches, moved, fits)
                             : FitTemplatesOf<8>(plane, patches, moved, fits);
}
void AlignTemplates(const Plane &plane, std::span<const Template> patches,
                    std::span<const std::span<const Displacement>> starts, int iterations,
                    std::span<Alignment> found, const Strain *strain) {
  patches.front().side == 16
      ? AlignTemplatesOf<16>(plane, patches, starts, iterations, found, strain)
      : AlignTemplatesOf<8>(plane, patches, starts, iterations, found, strain);
}
Alignment AlignStrained(const Plane &plane, const Template &patch, const Strain &strain,
                        Displacement start, int iterations) {
  return patch.side == 16 ? AlignStrainedOf<16>(plane, patch, strain, start, iterations)
                          : AlignStrainedOf<8>(plane, patch, strain, start, iterations);
}
SearchResult SearchTemplateAny(const Plane &plane, const Template &patch, Displacement centre,
                               int radius) {
  return patch.side == 16 ? SearchTemplate<16>(plane, patch, centre, radius)
                          : SearchTemplate<8>(plane, patch, centre, radius);
}

} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {

HWY_EXPORT(PrepareTemplates);
HWY_EXPORT(FitTemplates);
HWY_EXPORT(AlignTemplates);
HWY_EXPORT(AlignStrained);
HWY_EXPORT(SearchTemplateAny);

void prepare_templates(const Plane &plane, std::span<Template> patches) {
  HWY_DYNAMIC_DISPATCH(PrepareTemplates)(plane, patches);
}

void fit_templates(const Plane &plane, std::span<const Template> patches, Displacement displacement,
                   std::span<Fit> fits) {
  HWY_DYNAMIC_DISPATCH(FitTemplates)(plane, patches, displacement, fits);
}

void align_templates(const Plane &plane, std::span<const Template> patches,
                     std::span<const std::span<const Displacement>> starts, int iterations,
                     std::span<Alignment> found, const Strain *strain) {
  HWY_DYNAMIC_DISPATCH(AlignTemplates)(plane, patches, starts, iterations, found, strain);
}

Alignment align_template(const Plane &plane, const Template &patch,
                         std::span<const Displacement> starts, int iterations) {
  Alignment found;
  align_templates(plane, {&patch, 1}, {&starts, 1}, iterations, {&found, 1});
  return found;
}

Alignment align_strained(const Plane &plane, const Template &patch, const Strain &strain,
                         Displacement start, int iterations) {
  return HWY_DYNAMIC_DISPATCH(AlignStrained)(plane, patch, strain, start, iterations);
}

float regulariser(const Tensor &structure, float pixels) {
  constexpr float kNoise = 0.16F;
  constexpr float kOfTrace = 0.03F;
  return kNoise * pixels + kOfTrace * trace(structure);
}

SearchResult search_template(const Plane &plane, const Template &patch, Displacement centre,
                             int radius) {
  constexpr int kMaxRadius = 12;
  return HWY_DYNAMIC_DISPATCH(SearchTemplateAny)(plane, patch, centre,
                                                 std::min(radius, kMaxRadius));
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
