// SPDX-License-Identifier: LGPL-2.1-or-later
// A loop over the pixels of a row in whole vectors, for every instruction set.

// Included once for each instruction set.
#if defined(HAPTIC_FOR_ROW_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTIC_FOR_ROW_INL_HPP
#undef HAPTIC_FOR_ROW_INL_HPP
#else
#define HAPTIC_FOR_ROW_INL_HPP
#endif

#include <algorithm>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {

// Runs `body(at)` over [0, width) in whole vectors. The last vector is moved back to end at
// `width`, so that no pixel needs code of its own.
template <class D, class Body>
HWY_INLINE void for_row(D d, int width, Body &&body) {
  const int lanes = static_cast<int>(hwy::HWY_NAMESPACE::Lanes(d));
  int at = 0;
  for (; at + lanes <= width; at += lanes)
    body(at);
  if (at < width)
    body(std::max(0, width - lanes));
}

} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
