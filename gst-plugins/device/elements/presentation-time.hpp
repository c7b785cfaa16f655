// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "elements/sink-properties.hpp"

#include <atomic>
#include <gst/base/gstbasesink.h>

namespace haptic {

/// When the force of a frame is due. Streaming threads.
class PresentationTime {
public:
  /// All outlive it. `settings`: under the lock of `sink`.
  PresentationTime(GstBaseSink *sink, const SinkSettings &settings, const HapticSession &session)
      : sink_(sink), settings_(settings), session_(session) {}

  /// Before the streaming threads run.
  void begin_run() noexcept { liveness_ = Liveness::unknown; }
  /// Any thread. After a flush the clocks are related as before it, until every sink of the
  /// pipeline has a frame.
  void set_known(bool known) noexcept { known_ = known; }
  bool is_known() const noexcept { return known_; }
  /// Whether samples are felt as soon as they come.
  bool is_immediate();
  /// Presentation running time of `pts` in ns, or kAtOnce.
  std::int64_t of(const GstSegment &segment, GstClockTime pts);
  /// Makes the times of a buffer earlier by the look-ahead of the samples.
  void look_ahead(GstClockTime &start, GstClockTime &end) const;

private:
  enum class Liveness { unknown, live, not_live };

  bool is_live();

  GstBaseSink *sink_;
  const SinkSettings &settings_;
  const HapticSession &session_;
  std::atomic<Liveness> liveness_ = Liveness::unknown; // of the source, asked once a run
  std::atomic<bool> known_ = true;
};

} // namespace haptic
