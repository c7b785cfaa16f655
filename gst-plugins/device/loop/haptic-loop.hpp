// SPDX-License-Identifier: LGPL-2.1-or-later
// The real-time loop: device exchange, interpolation, force law, safety chain, command. It is
// compiled without GStreamer.
#pragma once

#include "force/carry-law.hpp"
#include "force/force-law.hpp"
#include "force/shake-watch.hpp"
#include "loop/flight-recorder.hpp"
#include "loop/real-time-thread.hpp"
#include "loop/suspend-detector.hpp"
#include "loop/tick-log.hpp"
#include "motion/motion-conditioning.hpp"
#include "motion/motion-interpolator.hpp"
#include "motion/pointer-mapping.hpp"
#include "non-blocking.hpp"
#include "safety/grip-watch.hpp"
#include "safety/safety-chain.hpp"
#include "samples/field-sampler.hpp"
#include "share/duration-histogram.hpp"
#include "share/loop-clock.hpp"
#include "share/newest-slot.hpp"
#include "share/running-time.hpp"
#include "share/sample-ring.hpp"
#include "share/shared-value.hpp"
#include "touch/touch.hpp"

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <spidar/haptic-device.hpp>
#include <spidar/limited-device.hpp>
#include <utility>
#include <vector>

namespace haptic {

/// The monotonic clock, ns.
inline std::int64_t monotonic_now() noexcept {
  return spidar::monotonic_time();
}

/// The settings that may change while the loop runs. They are handed over whole, so that no tick
/// sees half a change.
struct LoopSettings {
  std::size_t law = 0; ///< index into force_laws()
  LawSettings law_settings;
  unsigned reference_width = static_cast<unsigned>(kReferenceWidth); ///< px, 0: native
  double slew_rate = spidar::ForceLimits().slew_rate;                ///< N/s
  double damping = spidar::ForceLimits().damping;                    ///< N·s/m
  double smooth_hz = 0;                                              ///< Hz, 0: off
  double continuous_force = spidar::ForceLimits().continuous_force;  ///< N rms, 0: no limit
  double wash_out = 0;                                               ///< 1/s, 0: off
  HoldLaw hold_law = HoldLaw::motion;
  TouchMode touch = TouchMode::off;
  double region_z = 0; ///< -1..1, instead of the hand's z while it touches
};

/// What of the settings the device can do: it limits force, torque and push, and damps only if it
/// knows newtons.
LoopSettings within(const LoopSettings &settings, const spidar::DeviceLimits &device) noexcept;

/// Where the hand is, for the pointer.
struct HandPosition {
  spidar::Vector3 position = spidar::Vector3::Zero(); ///< m
  bool valid = false;
  bool pressed = false;           ///< a button of the grip
  FrameShift shift;               ///< of the frame, by the wash-out
  std::optional<double> region_z; ///< LoopSettings, while touch is on
  /// m, while touch is on: of the tick before; the hand, if it touches nothing
  std::optional<spidar::Vector3> proxy;
};

/// The sum of what was commanded since start(). The mean force between two readings is the
/// difference of their impulses divided by the difference of their times.
struct Impulse {
  spidar::Vector3 impulse = spidar::Vector3::Zero(); ///< N·s
  double time = 0;                                   ///< s
};

/// Written by the loop, read by any thread. Since the last start().
struct LoopStatistics {
  SharedValue<std::uint64_t> ticks;
  SharedValue<std::uint64_t> late_ticks;    ///< began more than a period late
  SharedValue<std::uint64_t> missed_ticks;  ///< began more than 10 ms late
  SharedValue<std::uint64_t> device_faults; ///< three failed exchanges in a row, or unplugged
  SharedValue<std::uint64_t> interruptions; ///< times that the guardian took the force off
  SharedValue<std::uint64_t> overspeeds;    ///< grip let go: too fast with a force on it
  SharedValue<std::uint64_t> non_finite;    ///< ticks silenced by a NaN or an infinity
  SharedValue<std::uint64_t> suspends;      ///< times that the machine slept
  SharedValue<std::uint64_t> shakes; ///< times that a law shook the hand until it was stopped
  SharedValue<std::uint64_t> log_rows_lost;
  SharedValue<std::uint64_t> samples_lost; ///< by submit(), which writes this one
  SharedValue<std::uint64_t> samples_used;
  SharedValue<std::int64_t> sample_age_sum; ///< ns from submit() to the first tick with it
  SharedValue<std::int64_t> sample_age_max; ///< ns
  SharedValue<double> force_max;            ///< N
  SharedValue<double> given_up_force;       ///< N, DeviceState::given_up of the last tick
  SharedValue<double> given_up_torque;      ///< N·m
  SharedValue<double> force_rms;            ///< N, over the last minute
  SharedValue<double> carry_stiffness;      ///< N/m, of the spring to the held thing; 0: none
  SharedValue<double> carry_distance;       ///< m, by which the hand is behind it
  /// Ticks in which each of kLimitNames acted
  std::array<SharedValue<std::uint64_t>, kLimitNames.size()> limited;
  DurationHistogram lateness;
  DurationHistogram body;

  std::uint64_t faults() const noexcept {
    return device_faults + overspeeds + suspends + shakes + non_finite + interruptions;
  }
};

class HapticLoop {
public:
  HapticLoop();
  ~HapticLoop();
  HapticLoop(const HapticLoop &) = delete;
  HapticLoop &operator=(const HapticLoop &) = delete;

  struct Environment {
    spidar::HapticDevice *device = nullptr; ///< null: no hand; outlives stop() or device_lost()
    bool lost = false;                      ///< it is null only until replace_device()
    TickLog *log = nullptr;                 ///< null: no log; outlives stop()
    LoopClock *clock = &machine_clock();    ///< outlives the thread
    double rate = 1000;                     ///< Hz
    bool dead_man = false;                  ///< force only while a button of the grip is pressed
    bool records = false;                   ///< keep the last ticks for recorder()
    bool bounds_hand = true;                ///< false: for the tests of ShakeWatch alone
    RealTimeThread::Callbacks callbacks;
  };

  // Life cycle: one thread at a time.

  /// Starts the thread, silent (kHoldPaused). Nothing of the run before is left but the settings,
  /// the holds that the user or a fault set, and what the force has spent of work and continuous
  /// force. Throws std::system_error.
  void start(Environment environment);
  /// Zero wrench, two exchanges, join. Does nothing when not started. A thread that has not come
  /// back from Callbacks::entered is not waited for; it has touched nothing.
  void stop() noexcept;
  /// As start() without the thread: the caller calls tick(). For tests and measurements.
  void prepare(Environment environment);
  /// After prepare(). Throws std::system_error.
  void start_thread();
  /// One period of the loop, begun at `now` though meant for `scheduled` (ns). Real-time safe.
  void tick(std::int64_t scheduled, std::int64_t now) noexcept HAPTIC_NONBLOCKING;

  // Any thread.

  void hold(std::uint32_t holds) noexcept { holds_.fetch_or(holds); }
  void unhold(std::uint32_t holds) noexcept { holds_.fetch_and(~holds); }
  std::uint32_t holds() const noexcept { return holds_.load(); }
  /// The same, with those that only the last tick knew.
  std::uint32_t reasons() const noexcept { return holds_.load() | run_.tick_holds.load(); }
  /// Whether the pose was known since the device was opened, or there is no hand.
  bool homed() const noexcept { return homed_.load(); }
  void set_homed(bool homed) noexcept { homed_.store(homed); }
  /// Discards every sample and relief submitted so far.
  void drop_samples() noexcept {
    drop_reliefs();
    epoch_.fetch_add(1);
  }
  /// The reliefs alone. The motion, and what holds the force, stay.
  void drop_reliefs() noexcept { relief_epoch_.fetch_add(1); }
  void calibrate() noexcept { run_.calibrate.store(true); }
  /// Returns the last command; only for the thread that ticks.
  const spidar::Wrench &wrench() const noexcept { return run_.chain.wrench(); }
  bool silent() const noexcept { return run_.silent.load(); }
  /// s, between two ticks.
  double period() const noexcept { return static_cast<double>(run_.period) * 1e-9; }
  const LoopStatistics &statistics() const noexcept { return run_.statistics; }
  /// Relates the clocks: for the log, and for samples with a time.
  void set_running_time(std::int64_t monotonic, std::int64_t running) noexcept {
    run_.running_time.set(monotonic, running);
  }
  /// Returns the running time in ns, by the last set_running_time().
  std::int64_t running_time(std::int64_t monotonic) const noexcept {
    return run_.running_time.at(monotonic);
  }

  // Streaming thread.

  /// `motion` came at `arrival` (ns, monotonic). Its time is running time as set_running_time()
  /// relates it to the monotonic clock, or kAtOnce. A field goes back to its pool by itself.
  /// The motion is lost, and counted, if the loop has stood still for seconds and the ring is full.
  void submit(TimedMotion motion, std::int64_t arrival = monotonic_now()) noexcept {
    if (!submissions_.push({std::move(motion), arrival, epoch_.load()}))
      count_lost_sample();
  }
  void submit(const MotionSample &sample, std::int64_t arrival = monotonic_now(),
              std::int64_t middle = kAtOnce) noexcept {
    submit(TimedMotion{sample, true, middle}, arrival);
  }
  void submit(FieldPool::Field field, std::int64_t arrival = monotonic_now(),
              std::int64_t middle = kAtOnce) noexcept {
    const MotionSample frame = frame_of(*field);
    submit(TimedMotion{frame, true, middle, std::move(field)}, arrival);
  }
  /// As submit(); the streaming thread of the reliefs.
  void submit(TimedRelief relief) noexcept {
    if (!reliefs_.push({std::move(relief), relief_epoch_.load()}))
      count_lost_sample();
  }
  /// Of a sample for which there was no room before submit().
  void count_lost_sample() noexcept { run_.statistics.samples_lost.fetch_add(1); }
  /// Nothing was measured; the flags of the sample give the reason.
  void submit_gap(const MotionSample &sample = {}, std::int64_t arrival = monotonic_now(),
                  std::int64_t middle = kAtOnce) noexcept {
    submit(TimedMotion{sample, false, middle}, arrival);
  }

  // One writer at a time.
  void set_settings(const LoopSettings &settings) noexcept { settings_.write(settings); }

  // Pointer thread.
  HandPosition hand() noexcept {
    run_.hand.refresh();
    return run_.hand.value();
  }
  Impulse impulse() noexcept {
    run_.impulse_slot.refresh();
    return run_.impulse_slot.value();
  }
  const RealTimeThread &thread() const noexcept { return thread_; }
  /// What the loop did before a rule stopped the force.
  FlightRecorder &recorder() noexcept { return run_.recorder; }
  /// The device has gone for good, the loop no longer uses it, and it may be destroyed.
  bool device_lost() const noexcept { return run_.device_lost.load(); }
  /// Only when device_lost(): the loop continues with this one, silent until armed.
  void replace_device(spidar::HapticDevice *device) noexcept {
    run_.device_lost.store(false);
    run_.replacement.store(device);
  }

  /// The thread that ticks; any other after stop(). Continues with the device of replace_device().
  void adopt_replacement() noexcept;

private:
  struct Submission {
    TimedMotion motion;
    std::int64_t arrival = 0; // ns, monotonic
    std::uint32_t epoch = 0;
  };

  struct ReliefSubmission {
    TimedRelief relief;
    std::uint32_t epoch = 0;
  };

  // Everything that begins anew with a start, which replaces it as a whole.
  struct Run {
    Run() = default;
    Run(Environment of, std::uint32_t at_epoch, std::uint32_t at_relief_epoch);

    // Between threads.
    SharedValue<bool> calibrate;
    SharedValue<bool> silent = true;
    SharedValue<std::uint32_t> tick_holds;
    SharedValue<bool> device_lost;
    SharedValue<spidar::HapticDevice *> replacement; // pointer thread -> loop
    NewestSlot<HandPosition> hand;                   // loop -> pointer thread
    NewestSlot<Impulse> impulse_slot;                // loop -> pointer thread
    RunningTime running_time;
    LoopStatistics statistics;

    // The loop's own; others touch them only while it does not run.
    Environment environment;
    std::int64_t period = 1'000'000; // ns
    std::vector<std::unique_ptr<ForceLaw>> laws;
    MotionInterpolator interpolator;
    MotionConditioner conditioner;
    spidar::DeviceLimits limits; // of the device, or of the one that was lost
    LoopSettings settings;       // as far as the device can do them
    SafetyChain chain{limits};
    SuspendDetector suspend;
    WashOut wash_out;
    PointerPosition place; // of the hand, as last known
    MotionAt motion;       // at the time of this tick
    Touch touch;
    CarryLaw carry;
    double longest_dt = 0;              // s between two ticks, lately
    bool broken = false;                // a sample held a number that is not finite
    const ForceLaw *followed = nullptr; // the law that followed a motion on the last tick
    Impulse impulse;
    std::uint32_t epoch = 0;
    std::uint32_t relief_epoch = 0;
    bool flushed = false;             // samples were dropped since the last tick
    std::int64_t last_tick = 0;       // ns, 0: none yet
    std::int64_t rests_since = 0;     // ns, end of the run before; 0: there was none
    std::int64_t retry_at = 0;        // ns, while faulted
    bool exchanged = false;           // on this tick
    bool interrupted = false;         // at the last exchange
    bool interruption_begins = false; // on this tick
    int failed_exchanges = 0;
    GripWatch grip;
    ShakeWatch shake;
    std::optional<std::int64_t> log_start; // ns, monotonic; of the first row
    bool row_had_force = false;
    FlightRecorder recorder;          // the pointer thread's, once it has kept something
    std::uint32_t recorded_holds = 0; // of the tick before
    std::int64_t began_at = 0;        // ns, of the first tick
  };

  void run(const std::stop_token &stop) noexcept;
  void adopt_limits() noexcept;
  void count_tick(std::int64_t lateness) noexcept;
  void expect_late_ticks(double dt) noexcept;
  void receive_submissions(std::int64_t now) noexcept;
  void exchange(std::int64_t now) noexcept;
  void update_hand(double dt) noexcept;
  void lose_device() noexcept;
  void receive_reliefs(std::int64_t running) noexcept;
  void update_motion(std::int64_t now) noexcept;
  void update_touch(double dt) noexcept;
  void update_carry(double dt) noexcept;
  std::uint32_t holds_of_tick(double dt, bool late) noexcept;
  void calm_law(SafetyChain::Input &input, double dt) noexcept;
  spidar::Wrench next_wrench(double dt, bool late) noexcept;
  void record_tick(const TickRow &row, bool late) noexcept;
  void log_tick(std::int64_t now, TickRow &row) noexcept;
  TickRow make_row(std::int64_t now, const spidar::Wrench &wrench) noexcept;

  // Outlive a run.
  std::atomic<std::uint32_t> holds_ = kHoldClosed | kHoldPaused; // any thread
  std::atomic<bool> homed_ = false;                              // loop, thread that opens
  std::atomic<std::uint32_t> epoch_ = 0;                         // of the samples; any thread
  std::atomic<std::uint32_t> relief_epoch_ = 0;                  // of the reliefs; any thread
  SampleRing<Submission, 256> submissions_;                      // streaming thread -> loop
  SampleRing<ReliefSubmission, 16> reliefs_;                     // the reliefs' -> loop
  NewestSlot<LoopSettings> settings_; // property setters, under the object's lock -> loop

  Run run_;

  RealTimeThread thread_; // last: ends before what it uses
};

} // namespace haptic
