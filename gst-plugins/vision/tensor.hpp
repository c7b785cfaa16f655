// SPDX-License-Identifier: LGPL-2.1-or-later
// Algebra of displacements and structure tensors.
#pragma once

#include "lk-kernels.hpp"

#include <cmath>

namespace haptic {

inline Displacement operator+(Displacement a, Displacement b) {
  return {a.x + b.x, a.y + b.y};
}
inline Displacement operator-(Displacement a, Displacement b) {
  return {a.x - b.x, a.y - b.y};
}
inline Displacement operator*(float scale, Displacement d) {
  return {scale * d.x, scale * d.y};
}
inline float norm2(Displacement d) {
  return d.x * d.x + d.y * d.y;
}

inline Tensor &operator+=(Tensor &sum, const Tensor &t) {
  sum.xx += t.xx;
  sum.xy += t.xy;
  sum.yy += t.yy;
  return sum;
}

inline Displacement solve(const Tensor &t, Displacement right, float regularised) {
  const float xx = t.xx + regularised;
  const float yy = t.yy + regularised;
  const float inverse = 1 / (xx * yy - t.xy * t.xy);
  return {(yy * right.x - t.xy * right.y) * inverse, (xx * right.y - t.xy * right.x) * inverse};
}

inline float quadratic(const Tensor &t, Displacement d) {
  return t.xx * d.x * d.x + 2 * t.xy * d.x * d.y + t.yy * d.y * d.y;
}

struct Eigenvalues {
  float least;
  float most;
};

inline Eigenvalues eigenvalues(const Tensor &t) {
  const float mean = (t.xx + t.yy) / 2;
  const float half_difference = (t.xx - t.yy) / 2;
  const float spread = std::sqrt(half_difference * half_difference + t.xy * t.xy);
  return {mean - spread, mean + spread};
}

/// Unit vector of the larger eigenvalue.
inline Displacement strong_direction(const Tensor &t) {
  const float most = eigenvalues(t).most;
  const Displacement along =
      t.xx > t.yy ? Displacement{most - t.yy, t.xy} : Displacement{t.xy, most - t.xx};
  const float length2 = norm2(along);
  return length2 > 0 ? 1 / std::sqrt(length2) * along : Displacement{1, 0};
}

/// What is left of a tensor when the weaker direction counts as unknown.
inline Tensor strong_part(const Tensor &t) {
  const Displacement strong = strong_direction(t);
  const float most = eigenvalues(t).most;
  return {most * strong.x * strong.x, most * strong.x * strong.y, most * strong.y * strong.y};
}

} // namespace haptic
