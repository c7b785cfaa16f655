// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lk-kernels.hpp"

#include <algorithm>
#include <cmath>

// Planes and patches are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lk-kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

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

// Runs `body(at)` over [0, width) in whole vectors, the last one moved back to end at width, so
// that no pixel is handled alone.
template <class D, class Body>
HWY_INLINE void for_row(D d, int width, Body &&body) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  int at = 0;
  for (; at + lanes <= width; at += lanes)
    body(at);
  if (at < width)
    body(std::max(0, width - lanes));
}

void AveragePairs(const LumaView &fine, ByteImage &coarse) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int y = 0; y < coarse.height; ++y) {
    const std::uint8_t *top = fine.pixels + 2 * y * fine.stride;
    const std::uint8_t *bottom = top + fine.stride;
    std::uint8_t *out = coarse.pixels.data() + static_cast<std::ptrdiff_t>(y) * coarse.width;
    int x = 0;
    for (; x + lanes <= coarse.width; x += lanes) {
      hn::Vec<decltype(d)> a, b, e, f;
      hn::LoadInterleaved2(d, top + 2 * x, a, b);
      hn::LoadInterleaved2(d, bottom + 2 * x, e, f);
      hn::StoreU(hn::AverageRound(hn::AverageRound(a, b), hn::AverageRound(e, f)), d, out + x);
    }
    const auto average = [](int a, int b) { return (a + b + 1) / 2; };
    for (; x < coarse.width; ++x)
      out[x] = static_cast<std::uint8_t>(
          average(average(top[2 * x], top[2 * x + 1]), average(bottom[2 * x], bottom[2 * x + 1])));
  }
}

// One column of vectors after another, so that each row is read once and stays in registers until
// it has served three rows of the result.
template <class D>
HWY_INLINE void SmoothColumns(D d, const LumaView &view, Plane &plane) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<std::uint8_t, D> du;
  const auto sixteenth = hn::Set(d, 1.0F / 16);
  for_row(d, plane.width(), [&](int x) HWY_ATTR {
    const auto load = [&](const std::uint8_t *from)
                          HWY_ATTR { return hn::PromoteTo(di, hn::LoadU(du, from)); };
    const std::uint8_t *from = view.pixels + x;
    const auto across = [&] HWY_ATTR {
      const auto middle = load(from + 1);
      const auto sum = hn::Add(hn::Add(load(from), load(from + 2)), hn::Add(middle, middle));
      from += view.stride;
      return sum;
    };
    auto upper = across();
    auto middle = across();
    for (int y = 0; y < plane.height(); ++y) {
      const auto lower = across();
      const auto sum = hn::Add(hn::Add(upper, lower), hn::Add(middle, middle));
      hn::StoreU(hn::Mul(hn::ConvertTo(d, sum), sixteenth), d, plane.row(y) + x);
      upper = middle;
      middle = lower;
    }
  });
}

void Smooth(const LumaView &view, Plane &plane) {
  const hn::ScalableTag<float> widest;
  if (plane.width() >= static_cast<int>(hn::Lanes(widest)))
    SmoothColumns(widest, view, plane);
  else
    SmoothColumns(hn::CappedTag<float, 8>(), view, plane);
}

void Halve(const Plane &fine, Plane &coarse) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto quarter = hn::Set(d, 0.25F);
  for (int y = 0; y < coarse.height(); ++y) {
    const float *top = fine.row(2 * y);
    const float *bottom = fine.row(2 * y + 1);
    float *out = coarse.row(y);
    for (int x = 0; x < coarse.width(); x += lanes) {
      const auto column_sums = [&](int at) HWY_ATTR {
        return hn::Add(hn::LoadU(d, top + at), hn::LoadU(d, bottom + at));
      };
      const auto left = column_sums(2 * x);
      const auto right = column_sums(2 * x + lanes);
#if HWY_TARGET == HWY_SCALAR
      const auto sum = hn::Add(left, right);
#else
      const auto sum = hn::Add(hn::ConcatEven(d, right, left), hn::ConcatOdd(d, right, left));
#endif
      hn::StoreU(hn::Mul(sum, quarter), d, out + x);
    }
  }
}

// Pixels of a patch and one more on every side, sampled between the pixels of the plane.
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

template <int kSide>
void PrepareTemplate(const float *first, std::ptrdiff_t stride, Template &patch) {
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
  constexpr float kPixels = kSide * kSide;
  const float mean = total(d, s) / kPixels;
  const float mean_x = total(d, sx) / kPixels;
  const float mean_y = total(d, sy) / kPixels;
  patch.energy = std::max(0.0F, total(d, ss) - kPixels * mean * mean);
  patch.slope = mean * total(d, sl) - total(d, stl);
  patch.curvature = total(d, sll);
  const float tx = total(d, stx) - kPixels * mean * mean_x;
  const float ty = total(d, sty) - kPixels * mean * mean_y;
  // The regulariser keeps a patch without contrast from losing its gradients to noise.
  const float inverse_energy = 1.0F / (patch.energy + 0.8F * kPixels);
  const float ax = tx * inverse_energy;
  const float ay = ty * inverse_energy;
  patch.structure.xx =
      total(d, sxx) - kPixels * mean_x * mean_x - ax * (2 * tx - ax * patch.energy);
  patch.structure.xy =
      total(d, sxy) - kPixels * mean_x * mean_y - ax * ty - ay * tx + ax * ay * patch.energy;
  patch.structure.yy =
      total(d, syy) - kPixels * mean_y * mean_y - ay * (2 * ty - ay * patch.energy);
  const auto vm = hn::Set(d, mean), vax = hn::Set(d, ax), vay = hn::Set(d, ay),
             vmx = hn::Set(d, mean_x), vmy = hn::Set(d, mean_y);
  for (int i = 0; i < kSide * kSide; i += lanes) {
    const V t = hn::Sub(hn::Load(d, patch.grey.data() + i), vm);
    hn::Store(t, d, patch.grey.data() + i);
    hn::Store(hn::NegMulAdd(vax, t, hn::Sub(hn::Load(d, patch.gradient_x.data() + i), vmx)), d,
              patch.gradient_x.data() + i);
    hn::Store(hn::NegMulAdd(vay, t, hn::Sub(hn::Load(d, patch.gradient_y.data() + i), vmy)), d,
              patch.gradient_y.data() + i);
  }
}

// Where a displaced patch lies: whole part as a pointer, fraction as weights.
struct Position {
  const float *first;
  float u;
  float v;
  bool inside; // moved by a fraction of a pixel at most to fit into the plane
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

// body(at, grey levels of the later frame at the displaced pixels from patch index `at`)
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

template <int kSide>
Fit FitTemplate(const Plane &plane, const Template &patch, Displacement moved) {
  const Position position = locate(plane, patch, moved);
  if (!position.inside)
    return {};
  const RowTag<kSide> d;
  auto bx = hn::Zero(d), by = hn::Zero(d), s = hn::Zero(d), ss = hn::Zero(d), st = hn::Zero(d);
  for_pixels<kSide>(plane, position, [&](int at, auto grey) HWY_ATTR {
    bx = hn::MulAdd(hn::Load(d, patch.gradient_x.data() + at), grey, bx);
    by = hn::MulAdd(hn::Load(d, patch.gradient_y.data() + at), grey, by);
    s = hn::Add(s, grey);
    ss = hn::MulAdd(grey, grey, ss);
    st = hn::MulAdd(hn::Load(d, patch.grey.data() + at), grey, st);
  });
  constexpr float kPixels = kSide * kSide;
  const float mean = total(d, s) / kPixels;
  const float energy = std::max(0.0F, total(d, ss) - kPixels * mean * mean);
  const float cross = total(d, st);
  Fit fit;
  fit.inside = true;
  fit.gradient = {total(d, bx), total(d, by)};
  fit.correlation = cross / std::sqrt(std::max(1e-6F, energy * patch.energy));
  const float explained = cross > 0 ? cross * cross / std::max(1e-6F, patch.energy) : 0.0F;
  fit.residual = std::sqrt(std::max(0.0F, energy - explained) / kPixels);
  return fit;
}

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
  const float floor = regulariser(patch.structure, kSide * kSide);
  const float xx = patch.structure.xx + floor, yy = patch.structure.yy + floor,
              xy = patch.structure.xy;
  const float inverse_determinant = 1.0F / (xx * yy - xy * xy);
  Alignment at = best;
  for (int i = 0; i < iterations; ++i) {
    const auto [gx, gy] = at.fit.gradient;
    const float step_x = (yy * gx - xy * gy) * inverse_determinant;
    const float step_y = (xx * gy - xy * gx) * inverse_determinant;
    const float length2 = step_x * step_x + step_y * step_y;
    const float scale = length2 > kLongest * kLongest ? kLongest / std::sqrt(length2) : 1.0F;
    at.displacement.x -= scale * step_x;
    at.displacement.y -= scale * step_y;
    const float away_x = at.displacement.x - start.x, away_y = at.displacement.y - start.y;
    if (away_x * away_x + away_y * away_y > kFurthest * kFurthest)
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

ChangeSums MeasureChange(const LumaView &previous, const LumaView &current) {
  const hn::CappedTag<std::int16_t, 16> d; // a region of 30 px fills two of these
  const hn::Rebind<std::uint8_t, decltype(d)> du;
  const hn::RepartitionToWide<decltype(d)> dw;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto zero = hn::Zero(dw);
  auto s = zero, s1 = zero, ss = zero, mx = zero, my = zero, xx = zero, xy = zero, yy = zero,
       ss1 = zero, mx1 = zero, my1 = zero, xx1 = zero, xy1 = zero, yy1 = zero;
  const int width = previous.width - 2;
  const auto one = hn::Set(d, std::int16_t{1});
  for (int y = 1; y + 1 < previous.height; ++y) {
    const std::uint8_t *p = previous.pixels + y * previous.stride + 1;
    const std::uint8_t *c = current.pixels + y * current.stride + 1;
    for (int x = 0; x < width; x += lanes) {
      // The last vector is moved back to end at the row's end, and what was counted before is
      // masked out.
      const int at = std::max(0, std::min(x, width - lanes));
      const auto load = [&](const std::uint8_t *from) HWY_ATTR {
        if (width >= lanes)
          return hn::PromoteTo(d, hn::LoadU(du, from + at));
        HWY_ALIGN std::uint8_t tail[64] = {};
        std::copy_n(from, width, tail);
        return hn::PromoteTo(d, hn::Load(du, tail));
      };
      auto keep = hn::Gt(hn::Iota(d, 1), hn::Set(d, static_cast<std::int16_t>(x - at)));
      auto diff = hn::Sub(load(c), load(p));
      auto gx = hn::Sub(load(p + 1), load(p - 1));
      auto gy = hn::Sub(load(p + previous.stride), load(p - previous.stride));
      if (at != x) {
        diff = hn::IfThenElseZero(keep, diff);
        gx = hn::IfThenElseZero(keep, gx);
        gy = hn::IfThenElseZero(keep, gy);
      }
      s = hn::ReorderWidenMulAccumulate(dw, diff, one, s, s1);
      ss = hn::ReorderWidenMulAccumulate(dw, diff, diff, ss, ss1);
      mx = hn::ReorderWidenMulAccumulate(dw, gx, diff, mx, mx1);
      my = hn::ReorderWidenMulAccumulate(dw, gy, diff, my, my1);
      xx = hn::ReorderWidenMulAccumulate(dw, gx, gx, xx, xx1);
      xy = hn::ReorderWidenMulAccumulate(dw, gx, gy, xy, xy1);
      yy = hn::ReorderWidenMulAccumulate(dw, gy, gy, yy, yy1);
    }
  }
  const auto reduce = [&](auto a, auto b) HWY_ATTR {
    return static_cast<float>(hn::GetLane(hn::SumOfLanes(dw, hn::Add(a, b))));
  };
  ChangeSums change;
  change.sum = reduce(s, s1);
  change.squares = reduce(ss, ss1);
  change.moment = {0.5F * reduce(mx, mx1), 0.5F * reduce(my, my1)};
  change.structure = {0.25F * reduce(xx, xx1), 0.25F * reduce(xy, xy1), 0.25F * reduce(yy, yy1)};
  return change;
}

template <int kSide>
SearchResult SearchTemplate(const Plane &plane, const Template &patch, Displacement centre,
                            int radius) {
  const RowTag<kSide> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kMaxRadius = 12;
  constexpr float kPixels = kSide * kSide;
  radius = std::min(radius, kMaxRadius);
  const int cx = static_cast<int>(std::lround(patch.x + centre.x)),
            cy = static_cast<int>(std::lround(patch.y + centre.y));
  const int left = std::max(0, cx - radius), right = std::min(plane.width() - kSide, cx + radius);
  const int top = std::max(0, cy - radius), bottom = std::min(plane.height() - kSide, cy + radius);
  float scores[(2 * kMaxRadius + 1) * (2 * kMaxRadius + 1)];
  SearchResult result;
  int best_x = 0, best_y = 0;
  const int columns = right - left + 1;
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      auto s = hn::Zero(d), ss = hn::Zero(d), st = hn::Zero(d);
      for (int j = 0; j < kSide; ++j) {
        const float *row = plane.row(y + j) + x;
        for (int i = 0; i < kSide; i += lanes) {
          const auto grey = hn::LoadU(d, row + i);
          s = hn::Add(s, grey);
          ss = hn::MulAdd(grey, grey, ss);
          st = hn::MulAdd(hn::Load(d, patch.grey.data() + j * kSide + i), grey, st);
        }
      }
      const float mean = total(d, s) / kPixels;
      const float energy = std::max(1e-6F, total(d, ss) - kPixels * mean * mean);
      const float score = total(d, st) / std::sqrt(energy * std::max(1e-6F, patch.energy));
      scores[(y - top) * columns + x - left] = score;
      if (score > result.correlation) {
        result.correlation = score;
        best_x = x;
        best_y = y;
      }
    }
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x)
      if (std::abs(x - best_x) > 1 || std::abs(y - best_y) > 1)
        result.runner_up = std::max(result.runner_up, scores[(y - top) * columns + x - left]);
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

// `back` maps offsets from the template's middle to offsets in the plane.
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
  for (int j = 0; j < kTile; ++j)
    for_row(d, kTile, [&](int i) HWY_ATTR {
      const auto right = hn::Iota(d, static_cast<float>(i - 1) - kMiddle);
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

HWY_EXPORT(AveragePairs);
HWY_EXPORT(MeasureChange);
HWY_EXPORT(Smooth);
HWY_EXPORT(Halve);
HWY_EXPORT(PrepareTemplates);
HWY_EXPORT(PrepareStrainedTemplate);
HWY_EXPORT(FitTemplates);
HWY_EXPORT(AlignTemplateAny);
HWY_EXPORT(SearchTemplateAny);

void Plane::resize(int width, int height) {
  // Two of the widest vectors: one that runs over the row's end, twice as far where pixels are
  // taken in pairs.
  constexpr int kPadding = 2 * 16;
  width_ = width;
  height_ = height;
  stride_ = (width + kPadding + 15) / 16 * 16;
  const std::size_t needed =
      static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 2);
  if (values_.size() < needed)
    values_.resize(needed);
}

ChangeSums measure_change(const LumaView &previous, const LumaView &current) {
  return HWY_DYNAMIC_DISPATCH(MeasureChange)(previous, current);
}

void smooth(const LumaView &view, Plane &plane) {
  plane.resize(view.width - 2, view.height - 2);
  HWY_DYNAMIC_DISPATCH(Smooth)(view, plane);
}

void halve(const Plane &fine, Plane &coarse) {
  coarse.resize(fine.width() / 2, fine.height() / 2);
  HWY_DYNAMIC_DISPATCH(Halve)(fine, coarse);
}

void prepare_templates(const Plane &plane, std::span<Template> patches) {
  HWY_DYNAMIC_DISPATCH(PrepareTemplates)(plane, patches);
}

void prepare_strained_template(const Plane &plane, const Strain &strain, Template &patch) {
  // Each pixel of the template shows what was at its place before: the inverse of the strain.
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

void average_pairs(const LumaView &fine, ByteImage &coarse) {
  coarse.width = fine.width / 2;
  coarse.height = fine.height / 2;
  const std::size_t needed =
      static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height);
  if (coarse.pixels.size() < needed)
    coarse.pixels.resize(needed);
  HWY_DYNAMIC_DISPATCH(AveragePairs)(fine, coarse);
}

SearchResult search_template(const Plane &plane, const Template &patch, Displacement centre,
                             int radius) {
  return HWY_DYNAMIC_DISPATCH(SearchTemplateAny)(plane, patch, centre, radius);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
