// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pixels/image-kernels.hpp"

#include <algorithm>
#include <cstring>
#include <hwy/cache_control.h>

// Planes and frames are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pixels/image-kernels.cpp"
#include <hwy/foreach_target.h>

#include "pixels/for-row-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Calls convert(d, in, out) for vectors d of pixels, which overlap at the end of a row, or
// convert_one(in, out) for the pixels of rows that are too short for a vector. kSize: bytes of a
// pixel.
template <int kSize, class Convert, class ConvertOne>
HWY_INLINE void ConvertPixels(const PackedView &from, std::uint8_t *to, std::ptrdiff_t stride,
                              [[maybe_unused]] Convert &&convert, ConvertOne &&convert_one) {
  // The rows of a crop lie on pages of their own, where no processor reads ahead by itself.
  constexpr int kRowsAhead = 4;
  constexpr int kCacheLine = 64; // bytes
  for (int y = 0; y < from.height; ++y) {
    const std::uint8_t *in = from.pixels + y * from.stride;
    const std::uint8_t *ahead =
        from.pixels + std::min(y + kRowsAhead, from.height - 1) * from.stride;
    std::uint8_t *out = to + y * stride;
    const auto fetch_ahead = [&](int x, int pixels) {
      for (int i = 0; i < kSize * pixels; i += kCacheLine)
        hwy::Prefetch(ahead + kSize * x + i);
    };
#if HWY_TARGET != HWY_SCALAR
    const auto in_vectors = [&](auto d) HWY_ATTR {
      for_row(d, from.width, [&](int x) HWY_ATTR {
        fetch_ahead(x, static_cast<int>(hn::Lanes(d)));
        convert(d, in + kSize * x, out + x);
      });
    };
    const hn::ScalableTag<std::uint8_t> widest;
    const hn::CappedTag<std::uint8_t, 16> least;
    if (from.width >= static_cast<int>(hn::Lanes(widest))) {
      in_vectors(widest);
      continue;
    }
    if (from.width >= static_cast<int>(hn::Lanes(least))) {
      in_vectors(least);
      continue;
    }
#endif
    fetch_ahead(0, from.width);
    for (int x = 0; x < from.width; ++x)
      convert_one(in + kSize * x, out + x);
  }
}

// The place is a constant, so that the bytes stay in registers.
template <int kSize, int kAt>
void PickBytesAt(const PackedView &from, std::uint8_t *to, std::ptrdiff_t stride) {
  ConvertPixels<kSize>(
      from, to, stride,
      [](auto d, const std::uint8_t *in, std::uint8_t *out) HWY_ATTR {
        hn::Vec<decltype(d)> bytes[4];
        if constexpr (kSize == 2)
          hn::LoadInterleaved2(d, in, bytes[0], bytes[1]);
        else
          hn::LoadInterleaved4(d, in, bytes[0], bytes[1], bytes[2], bytes[3]);
        hn::StoreU(bytes[kAt], d, out);
      },
      [](const std::uint8_t *in, std::uint8_t *out) { *out = in[kAt]; });
}

void PickBytes(const PackedView &from, int at, std::uint8_t *to, std::ptrdiff_t stride) {
  if (from.pixel_size == 4)
    PickBytesAt<4, 1>(from, to, stride);
  else if (at == 0)
    PickBytesAt<2, 0>(from, to, stride);
  else
    PickBytesAt<2, 1>(from, to, stride);
}

void CutTenBits(const PackedView &from, std::uint8_t *to, std::ptrdiff_t stride) {
  ConvertPixels<2>(
      from, to, stride,
      [](auto d, const std::uint8_t *in, std::uint8_t *out) HWY_ATTR {
        hn::Vec<decltype(d)> low, high;
        hn::LoadInterleaved2(d, in, low, high);
        hn::StoreU(hn::Or(hn::ShiftRight<2>(low), hn::ShiftLeft<6>(high)), d, out);
      },
      [](const std::uint8_t *in, std::uint8_t *out) {
        *out = static_cast<std::uint8_t>(in[0] >> 2 | in[1] << 6);
      });
}

constexpr int kV210Pixels = 6; // of a group
constexpr int kV210Bytes = 16;

std::uint8_t LumaOfV210(const std::uint8_t *row, int x) {
  const int sample = 2 * x + 1;
  std::uint32_t word;
  std::memcpy(&word, row + sample / 3 * 4, sizeof word);
  return static_cast<std::uint8_t>(word >> (10 * (sample % 3) + 2));
}

// Converts as many groups as vectors hold, and returns their number.
int UnpackV210Groups([[maybe_unused]] const std::uint8_t *in, [[maybe_unused]] int groups,
                     [[maybe_unused]] std::uint8_t *out) {
  int done = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::ScalableTag<std::uint32_t> d;
  const hn::Rebind<std::uint16_t, decltype(d)> dh;
  const auto byte = hn::Set(d, std::uint32_t{255});
  // Two neighbours in 16 bits.
  const auto pair = [&](auto first, auto second) HWY_ATTR {
    return hn::TruncateTo(dh,
                          hn::Or(hn::And(first, byte), hn::ShiftLeft<8>(hn::And(second, byte))));
  };
  const int step = static_cast<int>(hn::Lanes(d));
  std::uint16_t pairs[3 * hn::MaxLanes(dh)]; // `out` may be odd
  for (; done + step <= groups; done += step) {
    hn::Vec<decltype(d)> w0, w1, w2, w3;
    hn::LoadInterleaved4(d, reinterpret_cast<const std::uint32_t *>(in + done * kV210Bytes), w0, w1,
                         w2, w3);
    hn::StoreInterleaved3(pair(hn::ShiftRight<12>(w0), hn::ShiftRight<2>(w1)),
                          pair(hn::ShiftRight<22>(w1), hn::ShiftRight<12>(w2)),
                          pair(hn::ShiftRight<2>(w3), hn::ShiftRight<22>(w3)), dh, pairs);
    std::memcpy(out + done * kV210Pixels, pairs,
                std::size_t{kV210Pixels} * static_cast<std::size_t>(step));
  }
#endif
  return done;
}

void UnpackV210(const PackedView &from, int x, std::uint8_t *to, std::ptrdiff_t stride) {
  for (int row = 0; row < from.height; ++row) {
    const std::uint8_t *in = from.pixels + row * from.stride;
    std::uint8_t *out = to + row * stride - x;
    const int end = x + from.width;
    int i = x;
    for (; i < end && i % kV210Pixels != 0; ++i)
      out[i] = LumaOfV210(in, i);
    i += kV210Pixels *
         UnpackV210Groups(in + i / kV210Pixels * kV210Bytes, (end - i) / kV210Pixels, out + i);
    for (; i < end; ++i)
      out[i] = LumaOfV210(in, i);
  }
}

// The weights of ITU-R BT.601, section 2.5.1, in 256ths.
constexpr int kRed = 77;
constexpr int kGreen = 150;
constexpr int kBlue = 29;

// Y = (77 R + 150 G + 29 B + 128) / 256, which fits into 16 bits. Two pixels share a lane of 16
// bits, so their colours are weighed one after the other.
#if HWY_TARGET != HWY_SCALAR
template <class D, class V>
HWY_INLINE V Weigh(D d, V red, V green, V blue) {
  const hn::Repartition<std::uint16_t, D> dw;
  const auto low = hn::Set(dw, std::uint16_t{255});
  const auto weigh = [&](auto r, auto g, auto b) HWY_ATTR {
    const auto sum = hn::Add(hn::Mul(r, hn::Set(dw, std::uint16_t{kRed})),
                             hn::Mul(g, hn::Set(dw, std::uint16_t{kGreen})));
    const auto rest =
        hn::Add(hn::Mul(b, hn::Set(dw, std::uint16_t{kBlue})), hn::Set(dw, std::uint16_t{128}));
    return hn::Add(sum, rest);
  };
  const auto r = hn::BitCast(dw, red);
  const auto g = hn::BitCast(dw, green);
  const auto b = hn::BitCast(dw, blue);
  const auto first = weigh(hn::And(r, low), hn::And(g, low), hn::And(b, low));
  const auto second = weigh(hn::ShiftRight<8>(r), hn::ShiftRight<8>(g), hn::ShiftRight<8>(b));
  return hn::BitCast(d, hn::Or(hn::ShiftRight<8>(first), hn::AndNot(low, second)));
}
#endif

// The places are constants, so that the colours stay in registers.
template <int kSize, int kRedAt, int kGreenAt, int kBlueAt>
void WeighPixels(const PackedView &from, std::uint8_t *to, std::ptrdiff_t stride) {
  ConvertPixels<kSize>(
      from, to, stride,
      [](auto d, const std::uint8_t *in, std::uint8_t *out) HWY_ATTR {
        hn::Vec<decltype(d)> c[4];
        if constexpr (kSize == 3)
          hn::LoadInterleaved3(d, in, c[0], c[1], c[2]);
        else
          hn::LoadInterleaved4(d, in, c[0], c[1], c[2], c[3]);
        hn::StoreU(Weigh(d, c[kRedAt], c[kGreenAt], c[kBlueAt]), d, out);
      },
      [](const std::uint8_t *in, std::uint8_t *out) {
        const int sum = kRed * in[kRedAt] + kGreen * in[kGreenAt] + kBlue * in[kBlueAt];
        *out = static_cast<std::uint8_t>((sum + 128) >> 8);
      });
}

void WeighColours(const PackedView &from, const ColourOrder &order, std::uint8_t *to,
                  std::ptrdiff_t stride) {
  const bool red_is_first = order.red < order.blue;
  if (from.pixel_size == 3)
    return red_is_first ? WeighPixels<3, 0, 1, 2>(from, to, stride)
                        : WeighPixels<3, 2, 1, 0>(from, to, stride);
  if (order.green == 1)
    return red_is_first ? WeighPixels<4, 0, 1, 2>(from, to, stride)
                        : WeighPixels<4, 2, 1, 0>(from, to, stride);
  return red_is_first ? WeighPixels<4, 1, 2, 3>(from, to, stride)
                      : WeighPixels<4, 3, 2, 1>(from, to, stride);
}

// coarse(x, y) = avg(avg(f(2x, 2y), f(2x+1, 2y)), avg(f(2x, 2y+1), f(2x+1, 2y+1)))
// with avg(a, b) = floor((a + b + 1) / 2), the rounding average that processors have.
template <class D>
void AveragePairsBy(D d, const LumaView &fine, ByteImage &coarse) {
  for (int y = 0; y < coarse.height; ++y) {
    const std::uint8_t *top = fine.pixels + 2 * y * fine.stride;
    const std::uint8_t *bottom = top + fine.stride;
    std::uint8_t *out = coarse.pixels.data() + static_cast<std::ptrdiff_t>(y) * coarse.width;
    for_row(d, coarse.width, [&](int x) HWY_ATTR {
      hn::Vec<D> a, b, e, f;
      hn::LoadInterleaved2(d, top + 2 * x, a, b);
      hn::LoadInterleaved2(d, bottom + 2 * x, e, f);
      hn::StoreU(hn::AverageRound(hn::AverageRound(a, b), hn::AverageRound(e, f)), d, out + x);
    });
  }
}

void AveragePairs(const LumaView &fine, ByteImage &coarse) {
  const hn::ScalableTag<std::uint8_t> widest;
  const hn::CappedTag<std::uint8_t, 16> narrow;
  const hn::CappedTag<std::uint8_t, 1> single;
  if (coarse.width >= static_cast<int>(hn::Lanes(widest)))
    AveragePairsBy(widest, fine, coarse);
  else if (coarse.width >= static_cast<int>(hn::Lanes(narrow)))
    AveragePairsBy(narrow, fine, coarse);
  else
    AveragePairsBy(single, fine, coarse);
}

// plane(x, y) = sum over i, j in 0..2 of w_i w_j view(x+i, y+j) with w = (1 2 1) / 4.
// The sums are exact in integers. Works down one column of vectors after another: each row is read
// once and stays in registers until it has contributed to three rows of the result.
template <class D>
HWY_INLINE void SmoothColumns(D d, const LumaView &view, Plane &plane) {
  const hn::Rebind<std::uint16_t, D> dh;
  const hn::Rebind<std::uint8_t, D> db;
  const hn::RebindToSigned<D> di;
  const auto sixteenth = hn::Set(d, 1.0F / 16);
  for_row(d, plane.width(), [&](int x) HWY_ATTR {
    const auto load = [&](const std::uint8_t *from)
                          HWY_ATTR { return hn::PromoteTo(dh, hn::LoadU(db, from)); };
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
      hn::StoreU(hn::Mul(hn::ConvertTo(d, hn::PromoteTo(di, sum)), sixteenth), d, plane.row(y) + x);
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
template <std::size_t kLanes>
ChangeSums MeasureChangeBy(const LumaView &previous, const LumaView &current) {
  const hn::CappedTag<std::int16_t, kLanes> d;
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

// A region of 30 px fills two vectors of 16; a cell of 15 px two of 8. A row that is shorter than
// its vector has to be copied.
ChangeSums MeasureChange(const LumaView &previous, const LumaView &current) {
  constexpr int kWide = 16;
  return previous.width - 2 < kWide ? MeasureChangeBy<kWide / 2>(previous, current)
                                    : MeasureChangeBy<kWide>(previous, current);
}

// The sums over x and y of (f(x, y) - f(x, y+1))^2 and (f(x, y) - f(x, y+2))^2, over the number of
// pixels. Vectors overlap at the end of a row. Exact in integers of 32 bits down a column of
// vectors of up to 16 000 px.
RowDifferences CompareRows(const LumaView &view) {
  const hn::CappedTag<std::int16_t, 8> d;
  const hn::Rebind<std::uint8_t, decltype(d)> du;
  const hn::RepartitionToWide<decltype(d)> dw;
  const hn::Rebind<float, decltype(dw)> df;
  auto all_next = hn::Zero(df), all_second = all_next;
  int vectors = 0;
  for_row(d, view.width, [&](int x) HWY_ATTR {
    const auto load = [&](int y) HWY_ATTR {
      return hn::PromoteTo(d, hn::LoadU(du, view.pixels + y * view.stride + x));
    };
    auto next = hn::Zero(dw), next1 = next, second = next, second1 = next;
    auto upper = load(0);
    auto middle = load(1);
    for (int y = 0; y + 2 < view.height; ++y) {
      const auto lower = load(y + 2);
      const auto by_one = hn::Sub(upper, middle);
      const auto by_two = hn::Sub(upper, lower);
      next = hn::ReorderWidenMulAccumulate(dw, by_one, by_one, next, next1);
      second = hn::ReorderWidenMulAccumulate(dw, by_two, by_two, second, second1);
      upper = middle;
      middle = lower;
    }
    all_next = hn::Add(all_next, hn::ConvertTo(df, hn::Add(next, next1)));
    all_second = hn::Add(all_second, hn::ConvertTo(df, hn::Add(second, second1)));
    ++vectors;
  });
  const auto mean = [&](auto sums) HWY_ATTR {
    return hn::GetLane(hn::SumOfLanes(df, sums)) /
           static_cast<float>(vectors * static_cast<int>(hn::Lanes(d)) * (view.height - 2));
  };
  return {mean(all_next), mean(all_second)};
}

} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {

HWY_EXPORT(PickBytes);
HWY_EXPORT(CutTenBits);
HWY_EXPORT(UnpackV210);
HWY_EXPORT(WeighColours);
HWY_EXPORT(AveragePairs);
HWY_EXPORT(Smooth);
HWY_EXPORT(Halve);
HWY_EXPORT(MeasureChange);
HWY_EXPORT(CompareRows);

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

void pick_bytes(const PackedView &from, int at, std::uint8_t *to, std::ptrdiff_t stride) {
  HWY_DYNAMIC_DISPATCH(PickBytes)(from, at, to, stride);
}

void cut_ten_bits(const PackedView &from, std::uint8_t *to, std::ptrdiff_t stride) {
  HWY_DYNAMIC_DISPATCH(CutTenBits)(from, to, stride);
}

void unpack_v210(const PackedView &from, int x, std::uint8_t *to, std::ptrdiff_t stride) {
  HWY_DYNAMIC_DISPATCH(UnpackV210)(from, x, to, stride);
}

void weigh_colours(const PackedView &from, const ColourOrder &order, std::uint8_t *to,
                   std::ptrdiff_t stride) {
  HWY_DYNAMIC_DISPATCH(WeighColours)(from, order, to, stride);
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

RowDifferences compare_rows(const LumaView &view) {
  return HWY_DYNAMIC_DISPATCH(CompareRows)(view);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
