// SPDX-License-Identifier: LGPL-2.1-or-later
// What a session needs from its owner, and what it tells it.
#pragma once

#include "motion/pointer-mapping.hpp"
#include "session/session-state.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace haptic {

enum class Severity { debug, info, warning, error };

/// What a notice is about, as far as a program may act on it.
enum class NoticeCause {
  not_found, ///< no such device, geometry or file
  busy,      ///< another program holds the device
  settings,  ///< a property cannot be understood
  open,      ///< the device cannot be opened, or was opened again
  open_log,  ///< the log cannot be written
  write,     ///< the device or the log stopped working
  failed,    ///< the force is off for another reason
  format,    ///< a sample is damaged
};

struct Notice {
  Severity severity = Severity::debug;
  std::optional<NoticeCause> cause; ///< nothing: for the debug log, not for the user
  std::string text;                 ///< for the user, with its cure
  std::string detail;               ///< for developers
};

/// Two clocks read at the same time.
struct ClockReading {
  std::int64_t monotonic = 0; ///< ns
  std::int64_t running = 0;   ///< ns
};

/// What a session needs from its owner, and whom it reports to.
class SessionClient {
public:
  virtual ~SessionClient() = default;
  /// Any thread but the loop's.
  virtual void on_notice(const Notice &notice) = 0;
  /// For the debug log.
  void note(Severity severity, std::string text) {
    on_notice({severity, std::nullopt, std::move(text), {}});
  }
  /// Pointer thread. Returns whether a tracker took the point.
  virtual bool on_point(const PointerPosition &point) = 0;
  /// Pointer thread.
  virtual void on_armed_changed() = 0;
  /// Any thread but the loop's, in order. It must not call back into the session.
  virtual void on_session_changed(const SessionStatus & /*status*/) {}
  /// Pointer thread. Returns nothing without a clock.
  virtual std::optional<ClockReading> read_clocks() = 0;
};

} // namespace haptic
