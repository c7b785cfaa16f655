// SPDX-License-Identifier: LGPL-2.1-or-later
// From a relief per frame to a surface at any time: straight lines between the reliefs.
#pragma once

#include "motion/timed-motion.hpp"
#include "non-blocking.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

struct TimedRelief {
  ReliefPool::Field field = {}; ///< null: there is no surface
  std::int64_t time = kAtOnce;  ///< ns, when its frame is seen
};

/// The surface at one time.
struct ReliefAt {
  const ReliefField *from = nullptr; ///< null: there is no surface
  const ReliefField *to = nullptr;   ///< null with `from`
  double weight = 1;                 ///< 0..1, of `to`
  bool cut = false;                  ///< another scene began since the call before
  double age = 0;                    ///< s since the newest relief was due, or came, if later
  double interval = 0;               ///< s between the frames of the newest relief
};

/// A line begins when its first relief is due and ends when its second one is; a relief that comes
/// too late is reached over an interval from its arrival. No line leads into another scene. One
/// thread; real-time safe; times in ns of one steady clock.
class ReliefTimeline {
public:
  static constexpr std::size_t kCapacity = 32;
  static_assert(kCapacity < ReliefPool::kSlots);

  void add(TimedRelief relief, std::int64_t now) noexcept HAPTIC_NONBLOCKING;
  const ReliefAt &at(std::int64_t now) noexcept HAPTIC_NONBLOCKING;
  /// Discards everything that was added.
  void clear() noexcept;

private:
  struct Pending {
    TimedRelief relief;
    std::int64_t arrival = 0; // ns
  };

  static std::int64_t due_at(const Pending &pending) noexcept;
  bool begin_next(std::int64_t now) noexcept;

  std::array<Pending, kCapacity> pending_; // ring, in order
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  ReliefPool::Field from_; // null: no line, `to_` stands
  ReliefPool::Field to_;
  std::int64_t begin_ = 0; // ns, of the line
  std::int64_t end_ = 0;
  std::int64_t newest_ = 0; // when it was due, or came
  ReliefAt now_;
};

} // namespace haptic
