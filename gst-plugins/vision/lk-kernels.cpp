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
#include "lk-kernels.hpp"

#include <algorithm>
#include <cmath>

// Planes and patches are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lk-kernels.cpp"
#include <hwy/foreach_target.h>

#include "for-row-inl.hpp"

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
  return {total(d, s),
          {total(d, sx), total(d, sy)},
          total(d, ss),
          {total(d, stx), total(d, sty)},
          {total(d, sxx), total(d, sxy), total(d, syy)},
          total(d, sl),
          total(d, stl),
          total(d, sll)};
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
//   structure tensor     J = sum g' g'^T
//                          = sum g g^T - n mean(g) mean(g)^T - a b^T - b a^T + E a a^T
// The ridge r keeps a patch without contrast from losing its gradients to noise. Inverse
// compositional Lucas-Kanade (Baker and Matthews 2004); the projection follows Hager and Belhumeur
// 1998 with the illumination of Gennert and Negahdaripour 1987.
template <int kSide>
void PrepareTemplate(const float *first, std::ptrdiff_t stride, Template &patch) {
  constexpr float kPixels = kSide * kSide;
  constexpr float kRidge = 0.8F * kPixels;
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
  const float inverse_energy = 1.0F / (patch.energy + kRidge);
  const float ax = bx * inverse_energy;
  const float ay = by * inverse_energy;
  patch.structure.xx =
      sums.gradient2.xx - kPixels * mean_x * mean_x - ax * (2 * bx - ax * patch.energy);
  patch.structure.xy =
      sums.gradient2.xy - kPixels * mean_x * mean_y - ax * by - ay * bx + ax * ay * patch.energy;
  patch.structure.yy =
      sums.gradient2.yy - kPixels * mean_y * mean_y - ay * (2 * by - ay * patch.energy);
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

// With the samples I(x + d) and E, t, g' of the template:
//   gradient     b(d) = sum g' I(x + d), the right side of J step = b
//   correlation  c(d) = sum t I / sqrt(E sum (I - mean(I))^2), zero-mean normalised (Lewis 1995)
//   residual     what the best gain and offset leave: the least (over gain and offset) of
//                sum (I - gain t - offset)^2 = sum (I - mean(I))^2 - (sum t I)^2 / E,
//                as root of the mean; a negative gain explains nothing
// One pass over the pixels suffices, because sum t = 0. kSome: only the pixels with a weight.
template <int kSide, bool kSome = false>
Fit FitTemplate(const Plane &plane, const Template &patch, Displacement moved) {
  if constexpr (!kSome)
    if (patch.seen > 0)
      return FitTemplate<kSide, true>(plane, patch, moved);
  const Position position = locate(plane, patch, moved);
  if (!position.inside)
    return {};
  const RowTag<kSide> d;
  auto bx = hn::Zero(d), by = hn::Zero(d), s = hn::Zero(d), ss = hn::Zero(d), st = hn::Zero(d);
  for_pixels<kSide>(plane, position, [&](int at, auto grey) HWY_ATTR {
    const auto t = hn::Load(d, patch.grey.data() + at);
    if constexpr (kSome)
      grey = hn::IfThenElseZero(hn::Ne(t, hn::Zero(d)), grey);
    bx = hn::MulAdd(hn::Load(d, patch.gradient_x.data() + at), grey, bx);
    by = hn::MulAdd(hn::Load(d, patch.gradient_y.data() + at), grey, by);
    s = hn::Add(s, grey);
    ss = hn::MulAdd(grey, grey, ss);
    st = hn::MulAdd(t, grey, st);
  });
  const float pixels = kSome ? patch.seen : kSide * kSide;
  const float mean = total(d, s) / pixels;
  const float energy = std::max(0.0F, total(d, ss) - pixels * mean * mean);
  const float cross = total(d, st);
  Fit fit;
  fit.inside = true;
  fit.gradient = {total(d, bx), total(d, by)};
  fit.correlation = cross / std::sqrt(std::max(1e-6F, energy * patch.energy));
  const float explained = cross > 0 ? cross * cross / std::max(1e-6F, patch.energy) : 0.0F;
  fit.residual = std::sqrt(std::max(0.0F, energy - explained) / pixels);
  return fit;
}

// Gauss-Newton (Lucas and Kanade 1981; inverse compositional after Baker and Matthews 2004):
//   d <- d - (J + r I)^-1 b(d)
// with the structure tensor J, the gradient b(d) of FitTemplate and r of regulariser(). Starts from
// the displacement of least residual, and returns that of least residual on the way.
template <int kSide>
Alignment AlignTemplate(const Plane &plane, const Template &patch,
                        std::span<const Displacement> starts, int iterations) {
  constexpr float kFurthest = 4;      // px from the start
  constexpr float kConverged = 3e-4F; // px squared
  constexpr float kLongest = 1;       // px
  Alignment best{starts[0], FitTemplate<kSide>(plane, patch, starts[0])};
  for (const Displacement start : starts.subspan(1))
    if (const Fit fit = FitTemplate<kSide>(plane, patch, start); fit.residual < best.fit.residual)
      best = {start, fit};
  const Displacement start = best.displacement;
  const float ridge = regulariser(patch.structure, kSide * kSide);
  const float xx = patch.structure.xx + ridge, yy = patch.structure.yy + ridge,
              xy = patch.structure.xy;
  const float inverse_determinant = 1.0F / (xx * yy - xy * xy);
  Alignment at = best;
  for (int i = 0; i < iterations; ++i) {
    const auto [gx, gy] = at.fit.gradient;
    const Displacement step{(yy * gx - xy * gy) * inverse_determinant,
                            (xx * gy - xy * gx) * inverse_determinant};
    const float length2 = norm2(step);
    const float scale = length2 > kLongest * kLongest ? kLongest / std::sqrt(length2) : 1.0F;
    at.displacement -= scale * step;
    if (norm2(at.displacement - start) > kFurthest * kFurthest)
      break;
    // So short a step does not change the fit.
    if (length2 < kConverged) {
      if (at.fit.residual == best.fit.residual)
        best.displacement = at.displacement;
      break;
    }
    at.fit = FitTemplate<kSide>(plane, patch, at.displacement);
    if (at.fit.residual < best.fit.residual)
      best = at;
  }
  return best;
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

// Samples the plane at p + B o for the offsets o of the pixels from the middle p of the template,
// and prepares the template from these samples. B (`back`) is the inverse of the strain.
template <int kSide>
void PrepareStrainedTemplateOf(const Plane &plane, const Strain &back, Template &patch) {
  constexpr int kTile = kSide + 2;
  constexpr float kMiddle = 0.5F * (kSide - 1);
  HWY_ALIGN float tile[kTile * kTile];
  const RowTag<kSide> d;
  const hn::RebindToSigned<RowTag<kSide>> di;
  const auto within = [&](auto at, int length) HWY_ATTR {
    return hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, static_cast<float>(length) - 1.001F));
  };
  const auto stride = hn::Set(di, plane.stride());
  // Iota() would go through memory for each vector.
  const auto count = hn::Iota(d, -1.0F - kMiddle);
  for (int j = 0; j < kTile; ++j)
    for_row(d, kTile, [&](int i) HWY_ATTR {
      const auto right = hn::Add(count, hn::Set(d, static_cast<float>(i)));
      const float down = static_cast<float>(j - 1) - kMiddle;
      const auto x = within(
          hn::MulAdd(hn::Set(d, back.xx), right, hn::Set(d, patch.x + kMiddle + back.xy * down)),
          plane.width());
      const auto y = within(
          hn::MulAdd(hn::Set(d, back.yx), right, hn::Set(d, patch.y + kMiddle + back.yy * down)),
          plane.height());
      const auto column = hn::ConvertTo(di, x);
      const auto row = hn::ConvertTo(di, y);
      const auto u = hn::Sub(x, hn::ConvertTo(d, column));
      const auto v = hn::Sub(y, hn::ConvertTo(d, row));
      const auto at = hn::Add(hn::Mul(row, stride), column);
      const auto across = [&](const float *from) HWY_ATTR {
        const auto left = hn::GatherIndex(d, from, at);
        return hn::MulAdd(u, hn::Sub(hn::GatherIndex(d, from + 1, at), left), left);
      };
      const auto upper = across(plane.row(0));
      const auto lower = across(plane.row(1));
      hn::StoreU(hn::MulAdd(v, hn::Sub(lower, upper), upper), d, tile + j * kTile + i);
    });
  PrepareTemplate<kSide>(tile + kTile + 1, kTile, patch);
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
void PrepareStrainedTemplate(const Plane &plane, const Strain &back, Template &patch) {
  patch.side == 16 ? PrepareStrainedTemplateOf<16>(plane, back, patch)
                   : PrepareStrainedTemplateOf<8>(plane, back, patch);
}
Alignment AlignTemplateAny(const Plane &plane, const Template &patch,
                           std::span<const Displacement> starts, int iterations) {
  return patch.side == 16 ? AlignTemplate<16>(plane, patch, starts, iterations)
                          : AlignTemplate<8>(plane, patch, starts, iterations);
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
HWY_EXPORT(PrepareStrainedTemplate);
HWY_EXPORT(FitTemplates);
HWY_EXPORT(AlignTemplateAny);
HWY_EXPORT(SearchTemplateAny);

void prepare_templates(const Plane &plane, std::span<Template> patches) {
  HWY_DYNAMIC_DISPATCH(PrepareTemplates)(plane, patches);
}

void prepare_strained_template(const Plane &plane, const Strain &strain, Template &patch) {
  // A pixel of the template shows what was at its place before: (I + strain)^-1 of its offset.
  const float xx = 1 + strain.xx;
  const float yy = 1 + strain.yy;
  const float inverse = 1 / (xx * yy - strain.xy * strain.yx);
  const Strain back{yy * inverse, -strain.xy * inverse, -strain.yx * inverse, xx * inverse};
  HWY_DYNAMIC_DISPATCH(PrepareStrainedTemplate)(plane, back, patch);
}

void fit_templates(const Plane &plane, std::span<const Template> patches, Displacement displacement,
                   std::span<Fit> fits) {
  HWY_DYNAMIC_DISPATCH(FitTemplates)(plane, patches, displacement, fits);
}

Alignment align_template(const Plane &plane, const Template &patch,
                         std::span<const Displacement> starts, int iterations) {
  return HWY_DYNAMIC_DISPATCH(AlignTemplateAny)(plane, patch, starts, iterations);
}

float regulariser(const Tensor &structure, float pixels) {
  constexpr float kNoise = 0.16F;
  constexpr float kOfTrace = 0.03F;
  return kNoise * pixels + kOfTrace * (structure.xx + structure.yy);
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
