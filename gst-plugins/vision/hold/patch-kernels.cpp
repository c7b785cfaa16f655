// SPDX-License-Identifier: LGPL-2.1-or-later
// Sources of the formulas:
//   Baker and Matthews, Lucas-Kanade 20 years on: a unifying framework, IJCV 56, 2004
//   Black and Anandan, The robust estimation of multiple motions, CVIU 63, 1996: Geman and
//     McClure's function
//   Lewis, Fast normalized cross-correlation, 1995
#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

// Patches and planes are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "hold/patch-kernels.cpp"
#include <hwy/foreach_target.h>

#include "pixels/lanes-inl.hpp"

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
HWY_INLINE float total(Lanes v) {
  return hn::GetLane(hn::SumOfLanes(kTag, v));
}
HWY_INLINE Lanes load(const PatchSamples &samples, int at) {
  return hn::Load(kTag, samples.data() + at);
}

// Columns and rows of the samples, counted from the middle; 0 beyond the patch.
struct Offsets {
  PatchSamples column;
  PatchSamples row;

  Offsets() {
    for (int y = 0; y < kPatchSide; ++y)
      for (int x = 0; x < kPatchSide; ++x) {
        column[y * kPatchSide + x] = static_cast<float>(x - kPatchRadius);
        row[y * kPatchSide + x] = static_cast<float>(y - kPatchRadius);
      }
  }
};
const Offsets &offsets() {
  static const Offsets of_samples;
  return of_samples;
}

void Sample(const Plane &plane, const PatchPose &pose, PatchSamples &samples) {
  const hn::RebindToSigned<Tag> whole_tag;
  const float *first = plane.row(0);
  const auto stride = hn::Set(whole_tag, plane.stride());
  const auto one = hn::Set(whole_tag, 1);
  for (int at = 0; at < kPatchRoom; at += lanes()) {
    const Lanes column = load(offsets().column, at);
    const Lanes row = load(offsets().row, at);
    const Lanes x = hn::MulAdd(hn::Set(kTag, pose.a), column,
                               hn::MulAdd(hn::Set(kTag, pose.b), row, hn::Set(kTag, pose.x)));
    const Lanes y = hn::MulAdd(hn::Set(kTag, pose.c), column,
                               hn::MulAdd(hn::Set(kTag, pose.d), row, hn::Set(kTag, pose.y)));
    const auto left = hn::ConvertTo(whole_tag, x); // positive: it rounds down
    const auto top = hn::ConvertTo(whole_tag, y);
    const Lanes u = hn::Sub(x, hn::ConvertTo(kTag, left));
    const Lanes v = hn::Sub(y, hn::ConvertTo(kTag, top));
    const auto upper = hn::Add(hn::Mul(top, stride), left);
    const auto lower = hn::Add(upper, stride);
    const auto across = [&](auto index) HWY_ATTR {
      const Lanes from = hn::GatherIndex(kTag, first, index);
      const Lanes to = hn::GatherIndex(kTag, first, hn::Add(index, one));
      return hn::MulAdd(u, hn::Sub(to, from), from);
    };
    const Lanes above = across(upper);
    hn::Store(hn::MulAdd(v, hn::Sub(across(lower), above), above), kTag, samples.data() + at);
  }
}

PatchMoments Compare(const PatchSamples &weights, const PatchSamples &a, const PatchSamples &b) {
  const Lanes middle = hn::Set(kTag, 128); // keeps squares small
  Lanes w = hn::Zero(kTag);
  Lanes wa = hn::Zero(kTag);
  Lanes wb = hn::Zero(kTag);
  Lanes waa = hn::Zero(kTag);
  Lanes wbb = hn::Zero(kTag);
  Lanes wab = hn::Zero(kTag);
  for (int at = 0; at < kPatchRoom; at += lanes()) {
    const Lanes weight = load(weights, at);
    const Lanes va = hn::Sub(load(a, at), middle);
    const Lanes vb = hn::Sub(load(b, at), middle);
    const Lanes weighted_a = hn::Mul(weight, va);
    const Lanes weighted_b = hn::Mul(weight, vb);
    w = hn::Add(w, weight);
    wa = hn::Add(wa, weighted_a);
    wb = hn::Add(wb, weighted_b);
    waa = hn::MulAdd(weighted_a, va, waa);
    wbb = hn::MulAdd(weighted_b, vb, wbb);
    wab = hn::MulAdd(weighted_a, vb, wab);
  }
  PatchMoments moments;
  moments.weight = total(w);
  const float share = 1 / moments.weight;
  const float mean_a = total(wa) * share;
  const float mean_b = total(wb) * share;
  moments.variance_a = std::max(total(waa) * share - mean_a * mean_a, 0.0F);
  moments.variance_b = std::max(total(wbb) * share - mean_b * mean_b, 0.0F);
  moments.covariance = total(wab) * share - mean_a * mean_b;
  moments.mean_a = mean_a + 128;
  moments.mean_b = mean_b + 128;
  return moments;
}

float Subtract(const PatchSamples &weights, const PatchSamples &now, const PatchSamples &before,
               float gain, float offset, PatchSamples &errors) {
  Lanes sum = hn::Zero(kTag);
  for (int at = 0; at < kPatchRoom; at += lanes()) {
    const Lanes adapted = hn::MulAdd(hn::Set(kTag, gain), load(now, at), hn::Set(kTag, offset));
    const Lanes error = hn::Sub(adapted, load(before, at));
    hn::Store(error, kTag, errors.data() + at);
    sum = hn::MulAdd(load(weights, at), hn::Abs(error), sum);
  }
  return total(sum);
}

SmallErrors SumSmall(const PatchSamples &weights, const PatchSamples &errors, float limit) {
  const Lanes most = hn::Set(kTag, limit);
  Lanes weight = hn::Zero(kTag);
  Lanes amount = hn::Zero(kTag);
  Lanes limited = hn::Zero(kTag);
  for (int at = 0; at < kPatchRoom; at += lanes()) {
    const Lanes w = load(weights, at);
    const Lanes error = hn::Abs(load(errors, at));
    const Lanes counted = hn::IfThenElseZero(hn::Lt(error, most), w);
    weight = hn::Add(weight, counted);
    amount = hn::MulAdd(counted, error, amount);
    limited = hn::MulAdd(w, hn::Min(error, most), limited);
  }
  return {total(weight), total(amount), total(limited)};
}

template <bool kSimilarity>
NormalEquations SumNormal(const PatchTemplate &patch, const PatchSamples &errors,
                          const PatchSamples &weights, float c) {
  constexpr int kSums = kSimilarity ? 10 : 3;
  constexpr int kParameters = kSimilarity ? 4 : 2;
  Lanes matrix[kSums]; // no std::array: its constructor is not compiled for this instruction set
  Lanes right[kParameters];
  for (Lanes &sum : matrix)
    sum = hn::Zero(kTag);
  for (Lanes &sum : right)
    sum = hn::Zero(kTag);
  Lanes squares = hn::Zero(kTag);
  Lanes weight = hn::Zero(kTag);
  const Lanes one = hn::Set(kTag, 1);
  const Lanes per_c2 = hn::Set(kTag, 1 / (c * c));
  for (int at = 0; at < kPatchRoom; at += lanes()) {
    const Lanes error = load(errors, at);
    const Lanes square = hn::Mul(error, error);
    const Lanes robust = hn::Div(one, hn::MulAdd(square, per_c2, one));
    const Lanes w = hn::Mul(load(weights, at), hn::Mul(robust, robust));
    squares = hn::MulAdd(w, square, squares);
    weight = hn::Add(weight, w);
    Lanes slope[kParameters];
    slope[0] = load(patch.gradient_x, at);
    slope[1] = load(patch.gradient_y, at);
    if constexpr (kSimilarity) {
      const Lanes column = load(offsets().column, at);
      const Lanes row = load(offsets().row, at);
      slope[2] = hn::MulAdd(slope[0], column, hn::Mul(slope[1], row));
      slope[3] = hn::MulSub(slope[1], column, hn::Mul(slope[0], row));
    }
    std::size_t k = 0;
    for (std::size_t i = 0; i < kParameters; ++i) {
      const Lanes weighted = hn::Mul(w, slope[i]);
      right[i] = hn::MulAdd(weighted, error, right[i]);
      for (std::size_t j = 0; j <= i; ++j, ++k)
        matrix[k] = hn::MulAdd(weighted, slope[j], matrix[k]);
    }
  }
  NormalEquations sums;
  for (std::size_t k = 0; k < kSums; ++k)
    sums.matrix[k] = total(matrix[k]);
  for (std::size_t i = 0; i < kParameters; ++i)
    sums.right[i] = total(right[i]);
  sums.squares = total(squares);
  sums.weight = total(weight);
  return sums;
}

NormalEquations SumTranslation(const PatchTemplate &patch, const PatchSamples &errors,
                               const PatchSamples &weights, float c) {
  return SumNormal<false>(patch, errors, weights, c);
}
NormalEquations SumSimilarity(const PatchTemplate &patch, const PatchSamples &errors,
                              const PatchSamples &weights, float c) {
  return SumNormal<true>(patch, errors, weights, c);
}

void Learn(const PatchSamples &now, float gain, float offset, float tolerance, LearningRates rates,
           PatchSamples &appearance, PatchSamples &fits) {
  constexpr float kAnyway = 0.15F; // part of the rate of a sample that does not fit at all
  const Lanes exponent = hn::Set(kTag, -1 / (2 * tolerance * tolerance));
  for (int at = 0; at < kPatchRoom; at += lanes()) {
    const Lanes seen = load(now, at);
    const Lanes known = load(appearance, at);
    const Lanes error =
        hn::Sub(hn::MulAdd(hn::Set(kTag, gain), seen, hn::Set(kTag, offset)), known);
    const Lanes power = hn::Max(hn::Mul(hn::Mul(error, error), exponent), hn::Set(kTag, -30));
    const Lanes k = hn::Exp(kTag, power);
    const Lanes fit = load(fits, at);
    hn::Store(hn::MulAdd(hn::Set(kTag, rates.fits), hn::Sub(k, fit), fit), kTag, fits.data() + at);
    const Lanes rate = hn::Mul(hn::Set(kTag, rates.appearance),
                               hn::MulAdd(hn::Set(kTag, 1 - kAnyway), k, hn::Set(kTag, kAnyway)));
    hn::Store(hn::MulAdd(rate, hn::Sub(seen, known), known), kTag, appearance.data() + at);
  }
}

constexpr int kSparse = 9; // samples along each side, two apart
constexpr int kSparseReach = kSparse - 1;

struct SparseTemplate {
  std::array<float, kSparse * kSparse> weights;
  std::array<float, kSparse * kSparse> weighted; // weight * (grey - mean)
  float weight = 0;
  float squares = 0; // weighted, about the mean
};

SparseTemplate sparse_template(const PatchSamples &weights, const PatchSamples &grey) {
  SparseTemplate sparse;
  float sum = 0;
  const auto place = [](int i) {
    const int y = kPatchRadius - kSparseReach + 2 * (i / kSparse);
    const int x = kPatchRadius - kSparseReach + 2 * (i % kSparse);
    return y * kPatchSide + x;
  };
  for (int i = 0; i < kSparse * kSparse; ++i) {
    sparse.weight += weights[place(i)];
    sum += weights[place(i)] * grey[place(i)];
  }
  for (int i = 0; i < kSparse * kSparse; ++i) {
    const float weight = weights[place(i)];
    const float difference = grey[place(i)] - sum / sparse.weight;
    sparse.weights[static_cast<std::size_t>(i)] = weight;
    sparse.weighted[static_cast<std::size_t>(i)] = weight * difference;
    sparse.squares += weight * difference * difference;
  }
  return sparse;
}

void Correlate(const Plane &plane, int x, int y, int radius, const PatchSamples &weights,
               const PatchSamples &grey, float *scores) {
  const SparseTemplate sparse = sparse_template(weights, grey);
  const int side = 2 * radius + 1;
  std::fill_n(scores, side * side, -1.0F);
  const int first = std::max(-radius, kSparseReach - x);
  const int last = std::min(radius, plane.width() - 1 - kSparseReach - x);
  const Lanes per_weight = hn::Set(kTag, 1 / sparse.weight);
  // A variance of 1 stands for the noise: nothing correlates with a plain area.
  const Lanes noise = hn::Set(kTag, sparse.weight);
  const Lanes squares = hn::Set(kTag, sparse.squares + sparse.weight);
  for (int down = -radius; down <= radius; ++down) {
    const int middle = y + down;
    if (middle < kSparseReach || middle + kSparseReach >= plane.height())
      continue;
    for (int across = first; across <= last; across += lanes()) {
      Lanes sum = hn::Zero(kTag);
      Lanes square_sum = hn::Zero(kTag);
      Lanes product = hn::Zero(kTag);
      std::size_t i = 0;
      for (int row = -kSparseReach; row <= kSparseReach; row += 2) {
        const float *from = plane.row(middle + row) + x + across - kSparseReach;
        for (int column = 0; column < kSparse; ++column, ++i) {
          const Lanes grey_levels = hn::LoadU(kTag, from + 2 * column);
          const Lanes weighted = hn::Mul(hn::Set(kTag, sparse.weights[i]), grey_levels);
          sum = hn::Add(sum, weighted);
          square_sum = hn::MulAdd(weighted, grey_levels, square_sum);
          product = hn::MulAdd(hn::Set(kTag, sparse.weighted[i]), grey_levels, product);
        }
      }
      const Lanes spread =
          hn::Max(hn::NegMulAdd(hn::Mul(sum, per_weight), sum, square_sum), hn::Zero(kTag));
      const Lanes score =
          hn::Div(hn::Add(product, noise), hn::Sqrt(hn::Mul(squares, hn::Add(spread, noise))));
      HWY_ALIGN float some[8];
      hn::Store(score, kTag, some);
      std::copy_n(some, std::min(lanes(), last - across + 1),
                  scores + (down + radius) * side + across + radius);
    }
  }
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {

HWY_EXPORT(Sample);
HWY_EXPORT(Compare);
HWY_EXPORT(Subtract);
HWY_EXPORT(SumSmall);
HWY_EXPORT(SumTranslation);
HWY_EXPORT(SumSimilarity);
HWY_EXPORT(Learn);
HWY_EXPORT(Correlate);

void sample_plane(const Plane &plane, const PatchPose &pose, PatchSamples &samples) {
  HWY_DYNAMIC_DISPATCH(Sample)(plane, pose, samples);
  std::fill(samples.values.begin() + kPatchSamples, samples.values.end(), 0.0F);
}

void differentiate(PatchTemplate &patch) {
  for (int y = 0; y < kPatchSide; ++y)
    for (int x = 0; x < kPatchSide; ++x) {
      const int at = y * kPatchSide + x;
      const bool inside_x = x > 0 && x < kPatchSide - 1;
      const bool inside_y = y > 0 && y < kPatchSide - 1;
      patch.gradient_x[at] = inside_x ? (patch.grey[at + 1] - patch.grey[at - 1]) / 2 : 0;
      patch.gradient_y[at] =
          inside_y ? (patch.grey[at + kPatchSide] - patch.grey[at - kPatchSide]) / 2 : 0;
    }
}

PatchMoments compare_patches(const PatchSamples &weights, const PatchSamples &a,
                             const PatchSamples &b) {
  return HWY_DYNAMIC_DISPATCH(Compare)(weights, a, b);
}

float subtract_patches(const PatchSamples &weights, const PatchSamples &now,
                       const PatchSamples &before, float gain, float offset, PatchSamples &errors) {
  return HWY_DYNAMIC_DISPATCH(Subtract)(weights, now, before, gain, offset, errors);
}

SmallErrors sum_small_errors(const PatchSamples &weights, const PatchSamples &errors, float limit) {
  return HWY_DYNAMIC_DISPATCH(SumSmall)(weights, errors, limit);
}

NormalEquations sum_normal_equations(const PatchTemplate &patch, const PatchSamples &errors,
                                     const PatchSamples &weights, float c, bool has_similarity) {
  return has_similarity ? HWY_DYNAMIC_DISPATCH(SumSimilarity)(patch, errors, weights, c)
                        : HWY_DYNAMIC_DISPATCH(SumTranslation)(patch, errors, weights, c);
}

void learn_samples(const PatchSamples &now, float gain, float offset, float tolerance,
                   LearningRates rates, PatchSamples &appearance, PatchSamples &fits) {
  HWY_DYNAMIC_DISPATCH(Learn)(now, gain, offset, tolerance, rates, appearance, fits);
}

void correlate(const Plane &plane, int x, int y, int radius, const PatchSamples &weights,
               const PatchSamples &grey, float *scores) {
  HWY_DYNAMIC_DISPATCH(Correlate)(plane, x, y, radius, weights, grey, scores);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
