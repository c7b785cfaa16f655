// SPDX-License-Identifier: LGPL-2.1-or-later
// The real-time loop: device exchange, interpolation, law, safety chain, command. No GStreamer in
// it.
#pragma once

#include "duration-histogram.hpp"
#include "field-pool.hpp"
#include "field-sampler.hpp"
#include "force-law.hpp"
#include "motion-conditioning.hpp"
#include "motion-interpolator.hpp"
#include "newest-slot.hpp"
#include "running-time.hpp"
#include "safety-chain.hpp"
#include "sample-ring.hpp"
#include "suspend-detector.hpp"
#include "tick-log.hpp"

#include <atomic>
#include <functional>
#include <memory>
#include <spidar/haptic-device.hpp>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace haptic {

/// ns of the monotonic clock.
std::int64_t monotonic_now() noexcept;

/// What may change while the loop runs. Handed over whole, so that no tick sees half a change.
struct LoopSettings {
  std::size_t law = 0; ///< index into force_laws()
  LawSettings law_settings;
  double reference_width = kReferenceWidth; ///< px, 0: native
  double slew_rate = 20;                    ///< N/s
  double damping = 1;                       ///< N·s/m
  double smooth_hz = 0;                     ///< Hz, 0: off
};

/// Where the hand is, for the pointer.
struct HandPosition {
  spidar::Vector3 position = spidar::Vector3::Zero(); ///< m
  bool valid = false;
};

/// What was commanded since start(): a mean force is the difference of two readings.
struct Impulse {
  spidar::Vector3 impulse = spidar::Vector3::Zero(); ///< N·s
  double time = 0;                                   ///< s
};

/// Written by the loop, read by anybody. Since the last start().
struct LoopStatistics {
  std::atomic<std::uint64_t> ticks = 0;
  std::atomic<std::uint64_t> late_ticks = 0;    ///< began more than a period late
  std::atomic<std::uint64_t> missed_ticks = 0;  ///< began more than 20 ms late
  std::atomic<std::uint64_t> device_faults = 0; ///< three failed exchanges in a row, or unplugged
  std::atomic<std::uint64_t> interruptions = 0; ///< times that the guardian let go of the motors
  std::atomic<std::uint64_t> overspeeds = 0;    ///< grip faster than 1 m/s with a force on it
  std::atomic<std::uint64_t> non_finite = 0;    ///< ticks silenced by a NaN or an infinity
  std::atomic<std::uint64_t> suspends = 0;      ///< times that the machine slept
  std::atomic<std::uint64_t> log_rows_lost = 0;
  std::atomic<std::uint64_t> samples_used = 0;
  std::atomic<std::int64_t> sample_age_sum = 0; ///< ns from submit() to the first tick with it
  std::atomic<std::int64_t> sample_age_max = 0; ///< ns
  std::atomic<double> force_max = 0;            ///< N
  DurationHistogram lateness;
  DurationHistogram body;
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
    double rate = 1000;                     ///< Hz
    std::function<void()> entered;          ///< called in the thread before the loop proper
    std::function<void()> left;             ///< and after it
  };

  // Life cycle: one thread at a time.

  /// Starts the thread, silent (kHoldPaused). Throws std::system_error.
  void start(Environment environment);
  /// Zero wrench, two exchanges, join. Harmless when not started.
  void stop() noexcept;
  /// As start() without the thread: the caller drives tick(). For tests and measurements.
  void prepare(Environment environment);
  /// One period of the loop, begun at `now` though meant for `scheduled` (ns). Real-time safe.
  void tick(std::int64_t scheduled, std::int64_t now) noexcept;

  // Any thread.

  void hold(std::uint32_t holds) noexcept { holds_.fetch_or(holds); }
  void unhold(std::uint32_t holds) noexcept { holds_.fetch_and(~holds); }
  std::uint32_t holds() const noexcept { return holds_.load(); }
  /// Forgets every sample submitted so far.
  void drop_samples() noexcept { epoch_.fetch_add(1); }
  void calibrate() noexcept { calibrate_.store(true); }
  /// What was commanded last; of the thread that ticks.
  const spidar::Wrench &wrench() const noexcept { return chain_.wrench(); }
  bool silent() const noexcept { return silent_.load(); }
  const LoopStatistics &statistics() const noexcept { return statistics_; }
  /// How the clocks are related: for the log, and for samples with a time.
  void set_running_time(std::int64_t monotonic, std::int64_t running) noexcept {
    running_time_.set(monotonic, running);
  }
  /// ns, as last related.
  std::int64_t running_time(std::int64_t monotonic) const noexcept {
    return running_time_.at(monotonic);
  }

  // Streaming thread.

  /// A measurement, come at `arrival` (ns, monotonic), that is to be felt `middle` (ns, running
  /// time that set_running_time() relates to the monotonic clock; MotionInterpolator).
  void submit(const MotionSample &sample, std::int64_t arrival = monotonic_now(),
              std::int64_t middle = kAtOnce) noexcept {
    submit({{sample, true, middle}, arrival, epoch_.load()});
  }
  /// The same of a field, which is felt where the hand is. It goes back to its pool by itself.
  void submit(FieldPool::Field field, std::int64_t arrival = monotonic_now(),
              std::int64_t middle = kAtOnce) noexcept {
    const MotionSample frame = frame_of(*field);
    submit({{frame, true, middle, std::move(field)}, arrival, epoch_.load()});
  }
  /// Nothing was measured; the sample's flags say why.
  void submit_gap(const MotionSample &sample = {}, std::int64_t arrival = monotonic_now(),
                  std::int64_t middle = kAtOnce) noexcept {
    submit({{sample, false, middle}, arrival, epoch_.load()});
  }

  // One writer at a time.
  void set_settings(const LoopSettings &settings) noexcept { settings_.write(settings); }

  // Pointer thread.
  HandPosition hand() noexcept {
    hand_.refresh();
    return hand_.value();
  }
  Impulse impulse() noexcept {
    impulse_slot_.refresh();
    return impulse_slot_.value();
  }
  /// 0 with real-time priority, else why not (errno); -1 until the thread runs.
  int priority_error() const noexcept { return priority_error_.load(); }
  /// 0 when what the loop touches cannot be swapped out, else why not (errno).
  int memory_error() const noexcept { return memory_error_.load(); }
  /// The loop has let go of its device, which went for good and may be destroyed.
  bool device_lost() const noexcept { return device_lost_.load(); }
  /// Only when device_lost(): the loop goes on with this one, silent until armed.
  void replace_device(spidar::HapticDevice *device) noexcept {
    device_lost_.store(false);
    replacement_.store(device);
  }

private:
  struct Submission {
    TimedMotion motion;
    std::int64_t arrival = 0; // ns, monotonic
    std::uint32_t epoch = 0;
  };

  // A loop that is so far behind has stood still for seconds: what is lost then is stale anyway.
  void submit(Submission submission) noexcept { submissions_.push(std::move(submission)); }

  void run(const std::stop_token &stop) noexcept;
  void take_submissions(std::int64_t now) noexcept;
  void take_replacement() noexcept;
  void exchange(std::int64_t now) noexcept;
  void lose_device() noexcept;
  void feel(std::int64_t now) noexcept;
  spidar::Wrench next_wrench(double dt, bool late) noexcept;
  void write_row(std::int64_t now, const spidar::Wrench &wrench) noexcept;

  // Between threads.
  std::atomic<std::uint32_t> holds_ = kHoldClosed | kHoldPaused;
  std::atomic<std::uint32_t> epoch_ = 0;
  std::atomic<bool> calibrate_ = false;
  std::atomic<bool> silent_ = true;
  std::atomic<int> priority_error_ = -1;
  std::atomic<int> memory_error_ = 0;
  std::atomic<bool> device_lost_ = false;
  std::atomic<spidar::HapticDevice *> replacement_ = nullptr; // pointer thread -> loop
  SampleRing<Submission, 256> submissions_;                   // streaming thread -> loop
  NewestSlot<LoopSettings> settings_; // property setters, under the object's lock -> loop
  NewestSlot<HandPosition> hand_;     // loop -> pointer thread
  NewestSlot<Impulse> impulse_slot_;  // loop -> pointer thread
  RunningTime running_time_;
  LoopStatistics statistics_;

  // The loop's own, others touch them only while it does not run.
  Environment environment_;
  std::int64_t period_ = 1'000'000; // ns
  std::vector<std::unique_ptr<ForceLaw>> laws_;
  SafetyChain chain_;
  MotionInterpolator interpolator_;
  PointerPosition place_; // of the hand, as last known
  MotionAt motion_;       // felt now
  bool broken_ = false;   // a sample held a number that is not finite
  MotionConditioner conditioner_;
  SuspendDetector suspend_;
  Impulse impulse_;
  std::uint32_t current_epoch_ = 0;
  bool flushed_ = false;       // samples were dropped since the last tick
  std::int64_t last_tick_ = 0; // ns, 0: none yet
  std::int64_t retry_at_ = 0;  // ns, while faulted
  int failed_exchanges_ = 0;
  bool log_begun_ = false;
  bool row_had_force_ = false;

  std::jthread thread_;
};

} // namespace haptic
