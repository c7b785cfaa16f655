// SPDX-License-Identifier: LGPL-2.1-or-later
// The displacements from which the alignment of a patch may start.
#pragma once

#include "pixels/tensor.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace haptic {

/// Whether an alignment started at either would end at the same displacement: less than 1 px apart.
inline bool are_close(Displacement a, Displacement b) {
  return norm2(a - b) < 1;
}

/// Starts in the order in which they were added, no two of them close. What no longer fits is left
/// out.
class StartSet {
public:
  void clear() { count_ = 0; }
  void add(Displacement start) {
    if (count_ < starts_.size() &&
        std::ranges::none_of(view(), [&](Displacement other) { return are_close(other, start); }))
      starts_[count_++] = start;
  }
  std::span<const Displacement> view() const { return {starts_.data(), count_}; }

private:
  std::array<Displacement, 12> starts_; // own, nine neighbours, last and zero
  std::size_t count_ = 0;
};

} // namespace haptic
