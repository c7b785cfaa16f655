// SPDX-License-Identifier: LGPL-2.1-or-later
// A session with a haptic device: the device, the loop, the log, opening a lost device again, the
// pointer, and the reports of faults. It is compiled without GStreamer: the element hands in
// samples and state changes, and posts the notices and points that come out (SessionClient).
#pragma once

#include "drivers/device-choice.hpp"
#include "loop/haptic-loop.hpp"
#include "motion/pointer-mapping.hpp"
#include "motion/sample-intake.hpp"
#include "session/reopening.hpp"
#include "session/session-client.hpp"
#include "session/session-reports.hpp"
#include "session/session-state.hpp"
#include "share/callback-thread.hpp"
#include "share/loop-clock.hpp"
#include "system/system-services.hpp"
#include "touch/relief-intake.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace haptic {

/// How devices are opened; tests replace it.
struct DeviceOpener {
  std::function<OpenedDevice(const DeviceChoice &)> open = open_device;
  std::function<std::unique_ptr<spidar::HapticDevice>(const DeviceChoice &,
                                                      const std::string &identity)>
      reopen = reopen_device;
};

class HapticSession {
public:
  /// `client` outlives the session.
  explicit HapticSession(SessionClient &client, DeviceOpener opener = {});

  /// Before any other call. `clock` outlives the session; the machine's otherwise.
  void set_clock(LoopClock &clock) noexcept { clock_ = &clock; }
  LoopClock &clock() const noexcept { return *clock_; }

  // The thread that changes the state, in this order.

  /// Opens the device. Returns false after an error notice.
  bool open(const DeviceChoice &choice);

  struct RunSettings {
    DeviceChoice choice;        ///< another one than before: the device is opened anew
    LoopSettings loop;          ///< of set_settings(), to warn of what the device cannot do
    std::string log_location;   ///< empty: no log
    std::string fault_location; ///< folder for write_fault_record(); empty: none
    RealTimeThread::Callbacks callbacks; ///< of the loop's thread
  };
  /// Makes everything ready for a run: device, log, counters. Returns false after an error notice.
  bool prepare(const RunSettings &settings);
  /// After prepare(): starts the loop's thread, silent until play(). Then run_rounds() belongs on a
  /// thread of its own. Throws std::system_error. Tests call loop().tick() and round() instead.
  void start_loop();
  void play() noexcept { loop_.unhold(kHoldPaused); }
  void pause() noexcept { loop_.hold(kHoldPaused); }
  /// Zero force, two exchanges, join. Also from Callbacks::entered.
  void stop_loop() noexcept { loop_.stop(); }
  /// After the loop and the thread of run_rounds() have ended: reports what happened since the last
  /// round and completes the log.
  void end_run();
  void close();

  // Any thread.

  void arm();
  void release();
  void calibrate() noexcept { loop_.calibrate(); }
  bool is_armed() const noexcept { return !(loop_.holds() & (kHoldClosed | kLatches)); }
  SessionState state() const { return state_.state(); }
  bool silent() const noexcept { return loop_.silent(); }
  const LoopStatistics &statistics() const noexcept { return loop_.statistics(); }
  const SampleIntake &intake() const noexcept { return run_.intake; } ///< its counters
  void set_running_time(const ClockReading &reading) noexcept {
    loop_.set_running_time(reading.monotonic, reading.running);
  }
  /// A seek begins: the samples are discarded and the force fades.
  void begin_flush() noexcept;
  void end_flush() noexcept;
  /// Discards the reliefs, and nothing else.
  void drop_reliefs() noexcept { loop_.drop_reliefs(); }

  // One writer at a time.
  void set_settings(const LoopSettings &settings) noexcept { loop_.set_settings(settings); }

  // Streaming thread.

  SampleIntake &intake() noexcept { return run_.intake; }
  /// One sample or field (SampleIntake::accept()). The first damaged one of a run yields a notice.
  void accept(std::span<const std::uint8_t> bytes, bool gap, const Presentation &presentation);
  void accept_gap(std::int64_t time) noexcept;
  void begin_stream() noexcept { loop_.unhold(kHoldEnded); }
  void end_stream();

  // The streaming thread of the reliefs.

  ReliefIntake &reliefs() noexcept { return run_.reliefs; }
  const ReliefIntake &reliefs() const noexcept { return run_.reliefs; } ///< its counters
  /// One relief (ReliefIntake::accept()). The first damaged one of a run yields a notice.
  void accept_relief(std::span<const std::uint8_t> bytes, bool gap, std::int64_t time);
  /// The same, for a stream that comes in the place of samples.
  void accept_relief_alone(std::span<const std::uint8_t> bytes, bool gap, std::int64_t time) {
    accept_relief(bytes, gap, time);
    run_.intake.set_frame_duration(run_.reliefs.interval());
  }
  bool is_paused() const noexcept { return loop_.holds() & kHoldPaused; }
  /// ns, now.
  std::int64_t running_time() const noexcept { return loop_.running_time(clock_->now()); }

  // Pointer thread.

  /// Does what round() does 100 times a second. SessionClient::on_point may end the thread.
  void run_rounds(CallbackThread::Self &self);
  /// Sends the pointer, reports what happened since the round before, and opens a lost device
  /// again. `now` in ns of the monotonic clock.
  void round(std::int64_t now);

  HapticLoop &loop() noexcept { return loop_; }

private:
  // Everything that begins anew with a start, which replaces it as a whole.
  struct Run {
    Run(FieldPool &fields, ReliefPool &pool) noexcept : intake(fields), reliefs(pool) {}

    // Streaming thread; counters of the intake: any thread.
    SampleIntake intake;
    bool damage_reported = false;

    // Streaming thread of the reliefs; their counters: any thread.
    ReliefIntake reliefs;
    bool relief_damage_reported = false;

    // Pointer thread.
    Reopening reopening;
    bool has_hand = false;
    spidar::Vector3 workspace_half = spidar::Vector3::Ones(); // m
    std::string description;
    PointerGate gate;
    Impulse last_sent; // as of the last event
    bool armed = false;
    std::optional<std::int64_t> clock_read_at; // ns, monotonic
    SessionReports reports;
  };

  bool open_log(const std::string &path);
  void warn_of_what_is_beyond(const RunSettings &settings);
  void read_description();
  std::optional<PointerPosition> work(std::int64_t now);
  std::optional<PointerPosition> next_point(std::int64_t now, bool playing);
  void report(std::int64_t now);
  void update_state();
  void on_sleep();
  void reopen_lost_device(std::int64_t now);

  SessionClient &client_;
  DeviceOpener opener_;
  LoopClock *clock_ = &machine_clock();

  // The thread that changes the state; the pointer thread while it runs and the loop has lost the
  // device.
  std::optional<DeviceChoice> opened_as_; // nothing: closed
  double rate_ = 1000;                    // Hz, of the loop
  std::string identity_;                  // of the device opened last
  std::unique_ptr<spidar::HapticDevice> device_;
  std::unique_ptr<TickLog> log_;
  SessionStateMachine state_; // any thread

  FieldPool fields_; // before the run and the loop, which give fields back
  ReliefPool relief_pool_;
  Run run_;
  HapticLoop loop_; // its members have their threads

  std::unique_ptr<SystemServices> services_; // last: its thread ends before what it uses
};

} // namespace haptic
