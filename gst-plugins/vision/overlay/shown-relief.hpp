// SPDX-License-Identifier: LGPL-2.1-or-later
// The reliefs that come to the pad `relief` of hapticoverlay, beside the frames.
#pragma once

#include "samples/relief-field.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <gst/gst.h>
#include <mutex>
#include <span>

namespace haptic {

/// The newest reliefs, and which one belongs to a frame. Any thread. Never waits: a picture without
/// its relief is better than a late one.
class ShownRelief {
public:
  /// A relief older than this is not shown, ns.
  static constexpr std::uint64_t kLongest = 1'000'000'000;

  /// `time`: running time, or GST_CLOCK_TIME_NONE. Returns false, and takes nothing, if the bytes
  /// are no relief.
  bool add(std::span<const std::uint8_t> bytes, std::uint64_t time);
  /// There is none.
  void clear();
  /// Calls `use` with the newest relief that is not later than this running time, or, if all are,
  /// with the first; without time stamps with the newest. Returns false if there is none.
  bool read_at(std::uint64_t time, const std::function<void(const ReliefField &)> &use);

private:
  struct Dated {
    ReliefField relief;
    std::uint64_t time = GST_CLOCK_TIME_NONE;
  };
  const Dated *find(std::uint64_t time) const;

  ReliefField arriving_; // streaming thread of the pad
  std::mutex mutex_;
  // mutex_. A ring: room for the frames that queues hold.
  std::array<Dated, 8> ring_;
  std::size_t count_ = 0; // ever added
};

/// Adds the pad, of which there is one at most. `relief` outlives it.
GstPad *add_shown_relief_pad(GstElement *element, GstPadTemplate *of, ShownRelief &relief);

} // namespace haptic
