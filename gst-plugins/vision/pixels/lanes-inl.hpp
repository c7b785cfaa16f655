// SPDX-License-Identifier: LGPL-2.1-or-later
// Vectors of up to eight floats, for every instruction set.

// Once for each instruction set.
#if defined(HAPTIC_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTIC_LANES_INL_HPP
#undef HAPTIC_LANES_INL_HPP
#else
#define HAPTIC_LANES_INL_HPP
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, 8>;
using Lanes = hn::Vec<Tag>;
constexpr Tag kTag;

HWY_INLINE int lanes() {
  return static_cast<int>(hn::Lanes(kTag));
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
