// SPDX-License-Identifier: LGPL-2.1-or-later
// The memory of motion fields and reliefs between the streaming thread and the loop, which may not
// allocate or free any.
#pragma once

#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>

namespace haptic {

/// Must outlive every field acquired from it. One thread at a time acquires, any thread gives back.
template <typename Content, std::size_t slots>
class PoolOf {
  struct Slot {
    Content field;
    std::atomic<bool> taken = false; // from acquire() until given back
  };
  struct GiveBack {
    Slot *slot = nullptr;
    void operator()(const Content * /*field*/) const noexcept {
      slot->taken.store(false, std::memory_order_release);
    }
  };

public:
  /// Destroying it gives the field back. Real-time safe: the memory stays in the pool.
  using Field = std::unique_ptr<Content, GiveBack>;

  /// Returns a free field, or null if none is free. Its cells keep their memory.
  Field acquire() noexcept {
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

  static constexpr std::size_t kSlots = slots;

private:
  std::array<Slot, kSlots> slots_;
  std::size_t next_ = 0; // of the thread that acquires
};

/// As many as MotionInterpolator keeps, and some in the ring before it.
using FieldPool = PoolOf<MotionField, 160>;
/// As many as ReliefTimeline keeps, and some in the ring before it.
using ReliefPool = PoolOf<ReliefField, 48>;

} // namespace haptic
