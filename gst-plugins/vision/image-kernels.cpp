// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image-kernels.hpp"

#include <algorithm>

// Planes and frames are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "image-kernels.cpp"
#include <hwy/foreach_target.h>

#include "for-row-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// coarse(x, y) = avg(avg(f(2x, 2y), f(2x+1, 2y)), avg(f(2x, 2y+1), f(2x+1, 2y+1)))
// with avg(a, b) = floor((a + b + 1) / 2), the rounding average that processors have.
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

// plane(x, y) = sum over i, j in 0..2 of w_i w_j view(x+i, y+j) with w = (1 2 1) / 4.
// The sums are exact in integers. Works down one column of vectors after another: each row is read
// once and stays in registers until it has contributed to three rows of the result.
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

// coarse(x, y) = (f(2x, 2y) + f(2x+1, 2y) + f(2x, 2y+1) + f(2x+1, 2y+1)) / 4
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

// With the difference D = later - earlier and the gradient of the earlier frame P,
//   g = (P(x+1, y) - P(x-1, y), P(x, y+1) - P(x, y-1)) / 2,
// the sums of D, D^2, g D and g g^T. A displacement d makes D = -g^T d (brightness constancy,
// Lucas and Kanade 1981), so that (sum g g^T)^-1 sum g D estimates -d.
// Exact in integers of 32 bits for views of up to 33 000 px.
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

} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {

HWY_EXPORT(AveragePairs);
HWY_EXPORT(Smooth);
HWY_EXPORT(Halve);
HWY_EXPORT(MeasureChange);

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

void average_pairs(const LumaView &fine, ByteImage &coarse) {
  coarse.width = fine.width / 2;
  coarse.height = fine.height / 2;
  const std::size_t needed =
      static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height);
  if (coarse.pixels.size() < needed)
    coarse.pixels.resize(needed);
  HWY_DYNAMIC_DISPATCH(AveragePairs)(fine, coarse);
}

void smooth(const LumaView &view, Plane &plane) {
  plane.resize(view.width - 2, view.height - 2);
  HWY_DYNAMIC_DISPATCH(Smooth)(view, plane);
}

void halve(const Plane &fine, Plane &coarse) {
  coarse.resize(fine.width() / 2, fine.height() / 2);
  HWY_DYNAMIC_DISPATCH(Halve)(fine, coarse);
}

ChangeSums measure_change(const LumaView &previous, const LumaView &current) {
  return HWY_DYNAMIC_DISPATCH(MeasureChange)(previous, current);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
