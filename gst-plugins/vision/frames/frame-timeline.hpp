// SPDX-License-Identifier: LGPL-2.1-or-later
// Time between frames, from their time stamps alone: the frame rate of the caps need not be true.
#pragma once

#include <cstdint>
#include <optional>

namespace haptic {

/// How a frame follows in time on the reference, the earlier frame that it is compared with.
struct TimeStep {
  enum class Kind {
    follows,  ///< `interval` after the reference
    repeats,  ///< same time as the frame before: its velocity is unknown
    restarts, ///< there is no reference that it can be compared with
  };
  Kind kind = Kind::restarts;
  std::uint64_t interval = 0;  ///< ns, only when it follows
  const char *fault = nullptr; ///< fault of the time stamp, as text; or null
};

/// Not thread-safe.
class FrameTimeline {
public:
  /// Adds the next frame of the stream, with its time stamp in ns. `descending`: the stream is
  /// played backwards, so that its time stamps fall.
  TimeStep advance(std::optional<std::uint64_t> pts, bool descending);

  /// The frame given last becomes the reference.
  void adopt() { reference_ = last_; }

  /// The next frame restarts.
  void forget() {
    reference_.reset();
    last_.reset();
  }

private:
  std::optional<std::uint64_t> reference_;
  std::optional<std::uint64_t> last_;
  std::uint64_t usual_interval_ = 0; ///< ns; forget() keeps it
};

} // namespace haptic
