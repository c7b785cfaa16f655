// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "loop/haptic-loop.hpp"
#include "session/session-client.hpp"
#include "system/system-services.hpp"

#include <array>
#include <string>
#include <utility>

namespace haptic {

/// Tells the client what happened in a run. Pointer thread; `now` in ns of the monotonic clock.
class SessionReports {
public:
  /// What stopped the force is recorded in `fault_location` (write_fault_record()). `device`: whose
  /// limits they were.
  explicit SessionReports(std::string fault_location = {}, const spidar::DeviceLimits &device = {})
      : fault_location_(std::move(fault_location)), device_(device) {}

  /// Once a round, and after the last one. `services` and `log` may be null.
  void report(SessionClient &client, HapticLoop &loop, SystemServices *services, const TickLog *log,
              std::int64_t now);
  /// After report() and the pointer event of this round, which a tracker has `handled` or not.
  void report_tracker(SessionClient &client, bool handled, std::int64_t now);

private:
  void report_faults(SessionClient &client, const LoopStatistics &statistics);
  void report_priority(SessionClient &client, const RealTimeThread &thread,
                       SystemServices *services);
  void report_timing(SessionClient &client, const HapticLoop &loop, std::int64_t now);
  void report_record(SessionClient &client, FlightRecorder &recorder);
  void report_log(SessionClient &client, const TickLog *log);

  std::string fault_location_;
  spidar::DeviceLimits device_;
  std::optional<std::int64_t> began_at_;    // ns, monotonic, of the first round
  std::array<std::uint64_t, 6> reported_{}; // of each fault, so far
  bool tracker_found_ = false;
  bool tracker_reported_ = false;
  bool priority_requested_ = false;
  bool priority_reported_ = false;
  bool has_priority_ = false;
  bool timing_reported_ = false;
  std::optional<std::int64_t> playing_since_; // ns, monotonic
  DurationHistogram::Counts settled_{};       // of the lateness
  bool log_reported_ = false;
};

} // namespace haptic
