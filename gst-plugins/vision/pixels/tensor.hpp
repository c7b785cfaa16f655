// SPDX-License-Identifier: LGPL-2.1-or-later
// Displacements and structure tensors, with their algebra.
#pragma once

#include <cmath>

namespace haptic {

/// px, x to the right, y down.
struct Displacement {
  float x = 0;
  float y = 0;

  Displacement &operator+=(Displacement d) {
    x += d.x;
    y += d.y;
    return *this;
  }
  Displacement &operator-=(Displacement d) {
    x -= d.x;
    y -= d.y;
    return *this;
  }
};

inline Displacement operator+(Displacement a, Displacement b) {
  return a += b;
}
inline Displacement operator-(Displacement a, Displacement b) {
  return a -= b;
}
inline Displacement operator*(float scale, Displacement d) {
  return {scale * d.x, scale * d.y};
}
inline float dot(Displacement a, Displacement b) {
  return a.x * b.x + a.y * b.y;
}
inline float norm2(Displacement d) {
  return dot(d, d);
}
/// Shortened to a length.
inline Displacement at_most(float length, Displacement d) {
  const float has = std::sqrt(norm2(d));
  return has > length ? length / has * d : d;
}

/// Symmetric 2x2 matrix.
struct Tensor {
  float xx = 0;
  float xy = 0;
  float yy = 0;

  Tensor &operator+=(const Tensor &t) {
    xx += t.xx;
    xy += t.xy;
    yy += t.yy;
    return *this;
  }
};

inline Tensor operator*(float scale, const Tensor &t) {
  return {scale * t.xx, scale * t.xy, scale * t.yy};
}

inline float trace(const Tensor &t) {
  return t.xx + t.yy;
}

/// (t + ridge I)^-1 right, by Cramer's rule. The sum must be invertible.
inline Displacement solve(const Tensor &t, Displacement right, float ridge) {
  const float xx = t.xx + ridge;
  const float yy = t.yy + ridge;
  const float inverse = 1 / (xx * yy - t.xy * t.xy);
  return {(yy * right.x - t.xy * right.y) * inverse, (xx * right.y - t.xy * right.x) * inverse};
}

/// d^T t d.
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

/// Unit eigenvector of the larger eigenvalue.
inline Displacement strong_direction(const Tensor &t) {
  const float most = eigenvalues(t).most;
  const Displacement along =
      t.xx > t.yy ? Displacement{most - t.yy, t.xy} : Displacement{t.xy, most - t.xx};
  const float length2 = norm2(along);
  return length2 > 0 ? 1 / std::sqrt(length2) * along : Displacement{1, 0};
}

/// The tensor with its smaller eigenvalue set to zero: that direction counts as unknown.
inline Tensor strong_part(const Tensor &t) {
  const Displacement strong = strong_direction(t);
  const float most = eigenvalues(t).most;
  return {most * strong.x * strong.x, most * strong.x * strong.y, most * strong.y * strong.y};
}

} // namespace haptic
