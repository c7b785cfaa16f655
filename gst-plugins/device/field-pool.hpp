// SPDX-License-Identifier: LGPL-2.1-or-later
// Fields on their way from the streaming thread to the loop, which may not allocate or free one.
#pragma once

#include "motion-field.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>

namespace haptic {

/// Outlives every field taken from it. One thread at a time takes, any gives back.
class FieldPool {
  struct Slot {
    MotionField field;
    std::atomic<bool> taken = false; // by its taker, until given back
  };
  struct GiveBack {
    Slot *slot = nullptr;
    void operator()(const MotionField * /*field*/) const noexcept {
      slot->taken.store(false, std::memory_order_release);
    }
  };

public:
  /// Giving it back is real-time safe: its memory stays in the pool.
  using Field = std::unique_ptr<MotionField, GiveBack>;

  /// One of those that nobody has; null when all are taken. Keeps the memory that its cells had.
  Field take() noexcept {
    for (std::size_t tried = 0; tried < kSlots; ++tried) {
      Slot &slot = slots_[next_];
      next_ = (next_ + 1) % kSlots;
      if (slot.taken.load(std::memory_order_acquire))
        continue;
      slot.taken.store(true, std::memory_order_relaxed);
      return Field(&slot.field, GiveBack{&slot});
    }
    return {};
  }

  /// What MotionInterpolator keeps at most, and some on the way.
  static constexpr std::size_t kSlots = 160;

private:
  std::array<Slot, kSlots> slots_;
  std::size_t next_ = 0; // of the thread that takes
};

} // namespace haptic
