// SPDX-License-Identifier: LGPL-2.1-or-later
#include "haptic-loop.hpp"

#include "pointer-mapping.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <limits>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>

namespace haptic {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;            // ns
constexpr std::int64_t kTooLate = 20'000'000;              // ns
constexpr std::int64_t kRetryFaultedDevice = kSecond / 10; // ns
constexpr double kGripLetGo = 1.0;                         // m/s
constexpr int kFailuresToFault = 3;
constexpr int kRealTimePriority = 50; // above what desktops use, below the kernel's threads

// Only the loop writes its counters, so no read-modify-write instruction is needed.
template <typename T>
void add(std::atomic<T> &counter, T amount = 1) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + amount, std::memory_order_relaxed);
}

template <typename T>
void raise(std::atomic<T> &maximum, T value) noexcept {
  if (value > maximum.load(std::memory_order_relaxed))
    maximum.store(value, std::memory_order_relaxed);
}

void reset(LoopStatistics &s) noexcept {
  for (auto *counter :
       {&s.ticks, &s.late_ticks, &s.missed_ticks, &s.device_faults, &s.overspeeds, &s.suspends,
        &s.interruptions, &s.non_finite, &s.log_rows_lost, &s.samples_used})
    counter->store(0);
  s.sample_age_sum = 0;
  s.sample_age_max = 0;
  s.force_max = 0;
  s.lateness.reset();
  s.body.reset();
}

void sleep_until(std::int64_t when) noexcept {
  const timespec at{.tv_sec = when / kSecond, .tv_nsec = when % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
}

void back_to_normal_priority() noexcept {
  const sched_param normal{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal);
}

// The stack as deep as the loop ever needs it: touched once and kept, so that no tick waits for a
// page.
[[gnu::noinline]] int lock_stack() noexcept {
  constexpr std::size_t kDepth = 65536;
  volatile char stack[kDepth];
  for (std::size_t i = 0; i < kDepth; i += 1024)
    stack[i] = 0;
  return mlock(const_cast<char *>(stack), kDepth) == 0 ? 0 : errno;
}

int lock_memory(const HapticLoop &loop) noexcept {
  if (const int error = lock_stack(); error != 0)
    return error;
  return mlock(&loop, sizeof loop) == 0 ? 0 : errno;
}

int ask_for_real_time_priority() noexcept {
  const sched_param wanted{.sched_priority = kRealTimePriority};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  // At normal priority the kernel may delay a wake-up by 50 us to save power, unless told not to.
  prctl(PR_SET_TIMERSLACK, 1UL);
  return error;
}

bool is_finite(const MotionSample &sample) noexcept {
  return std::isfinite(sample.velocity_x) && std::isfinite(sample.velocity_y) &&
         std::isfinite(sample.spin) && std::isfinite(sample.divergence) &&
         std::isfinite(sample.confidence);
}

std::int64_t read_clock(clockid_t clock) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return now.tv_sec * kSecond + now.tv_nsec;
}

} // namespace

std::int64_t monotonic_now() noexcept {
  return read_clock(CLOCK_MONOTONIC);
}

HapticLoop::HapticLoop() {
  for (const auto &law : force_laws())
    laws_.push_back(law.make());
}

HapticLoop::~HapticLoop() {
  stop();
}

void HapticLoop::prepare(Environment environment) {
  environment_ = std::move(environment);
  period_ = std::llround(static_cast<double>(kSecond) / environment_.rate);
  hold(kHoldPaused);
  unhold(kHoldFlushing | kHoldEnded);
  drop_samples();
  chain_ = {};
  interpolator_.clear();
  place_ = {};
  motion_ = {};
  conditioner_ = {};
  suspend_ = {};
  impulse_ = {};
  impulse_slot_.write(impulse_);
  last_tick_ = 0;
  retry_at_ = 0;
  failed_exchanges_ = 0;
  flushed_ = false;
  current_epoch_ = epoch_;
  log_begun_ = false;
  row_had_force_ = false;
  running_time_.reset();
  reset(statistics_);
  silent_ = true;
  priority_error_ = -1;
  memory_error_ = 0;
  replacement_ = nullptr;
  device_lost_ = environment_.lost;
}

void HapticLoop::start(Environment environment) {
  prepare(std::move(environment));
  thread_ = std::jthread([this](const std::stop_token &stop) { run(stop); });
}

void HapticLoop::stop() noexcept {
  thread_ = {};
}

void HapticLoop::run(const std::stop_token &stop) noexcept {
  if (environment_.entered)
    environment_.entered();
  memory_error_ = lock_memory(*this);
  priority_error_ = ask_for_real_time_priority();

  std::int64_t next = monotonic_now() + period_;
  while (!stop.stop_requested()) {
    sleep_until(next);
    const std::int64_t now = monotonic_now();
    if (suspend_.has_slept(now, read_clock(CLOCK_BOOTTIME))) {
      hold(kHoldSuspended);
      add<std::uint64_t>(statistics_.suspends);
    }
    tick(next, now);
    statistics_.body.record(monotonic_now() - now);
    next += period_;
    if (now > next) // skip what is past rather than hurry after it
      next += (now - next) / period_ * period_;
  }

  if (environment_.device) {
    environment_.device->command({});
    environment_.device->exchange();
    environment_.device->exchange();
  }
  silent_ = true;
  back_to_normal_priority();
  if (environment_.left)
    environment_.left();
}

void HapticLoop::tick(std::int64_t scheduled, std::int64_t now) noexcept {
  const std::int64_t lateness = now - scheduled;
  statistics_.lateness.record(lateness);
  add<std::uint64_t>(statistics_.ticks);
  if (lateness > period_)
    add<std::uint64_t>(statistics_.late_ticks);
  const bool too_late = lateness > kTooLate;
  if (too_late)
    add<std::uint64_t>(statistics_.missed_ticks);
  const std::int64_t elapsed = last_tick_ ? now - last_tick_ : period_;
  last_tick_ = now;

  settings_.refresh();
  const double dt = static_cast<double>(elapsed) / static_cast<double>(kSecond);
  take_submissions(now);
  take_replacement();
  exchange(now);
  feel(now);
  const spidar::Wrench wrench = next_wrench(dt, too_late);
  if (environment_.device)
    environment_.device->command(wrench);
  if (environment_.log)
    write_row(now, wrench);
  impulse_.impulse += wrench.force * dt;
  impulse_.time += dt;
  impulse_slot_.write(impulse_);
  silent_.store(chain_.silent());
  raise(statistics_.force_max, wrench.force.norm());
}

void HapticLoop::take_submissions(std::int64_t now) noexcept {
  const std::uint32_t epoch = epoch_.load();
  flushed_ = epoch != current_epoch_;
  current_epoch_ = epoch;
  if (flushed_)
    interpolator_.clear();
  broken_ = false;
  const std::int64_t running = running_time_.at(now);
  for (Submission submission; submissions_.pop(submission);) {
    if (submission.epoch != epoch)
      continue;
    if (!is_finite(submission.motion.sample)) {
      broken_ = true;
      continue;
    }
    const bool measured = submission.motion.measured;
    interpolator_.add(std::move(submission.motion), running);
    if (!measured)
      continue;
    const std::int64_t age = now - submission.arrival;
    add<std::uint64_t>(statistics_.samples_used);
    add(statistics_.sample_age_sum, age);
    raise(statistics_.sample_age_max, age);
  }
}

void HapticLoop::take_replacement() noexcept {
  spidar::HapticDevice *device = replacement_.exchange(nullptr);
  if (!device)
    return;
  environment_.device = device;
  failed_exchanges_ = 0;
  retry_at_ = 0;
  hold(kHoldFaulted); // somebody may have armed what was not there
  unhold(kHoldClosed);
}

void HapticLoop::lose_device() noexcept {
  hold(kHoldFaulted | kHoldClosed);
  hand_.write({});
  environment_.device = nullptr;
  device_lost_.store(true);
}

void HapticLoop::exchange(std::int64_t now) noexcept {
  spidar::HapticDevice *device = environment_.device;
  if (!device)
    return;
  if (calibrate_.exchange(false))
    device->calibrate();
  const bool faulted = holds_.load() & kHoldFaulted;
  if (faulted && now < retry_at_)
    return;
  retry_at_ = now + kRetryFaultedDevice;
  const bool answered = device->exchange();
  const bool gone = !answered && !device->connected();
  if (answered) {
    failed_exchanges_ = 0;
  } else if (++failed_exchanges_ == kFailuresToFault || gone) {
    failed_exchanges_ = 0;
    if (!faulted) {
      hold(kHoldFaulted);
      add<std::uint64_t>(statistics_.device_faults);
      retry_at_ = 0; // with a force of zero, which it may take even if it does not answer
    }
  }
  if (device->state().interrupted) {
    chain_ = {}; // the force was taken off the motors: it begins anew, from zero
    add<std::uint64_t>(statistics_.interruptions);
  }
  if (gone)
    return lose_device();
  hand_.write({device->state().pose.position, device->state().valid});
}

void HapticLoop::feel(std::int64_t now) noexcept {
  if (environment_.device && environment_.device->state().valid)
    place_ = map_pointer(environment_.device->state().pose.position,
                         environment_.device->workspace_half());
  // While the pipeline is paused its time stands still.
  if (flushed_ || !(holds_.load() & kHoldPaused))
    motion_ = interpolator_.at(running_time_.at(now), place_);
}

spidar::Wrench HapticLoop::next_wrench(double dt, bool late) noexcept {
  const LoopSettings &settings = settings_.value();
  std::uint32_t holds = holds_.load();
  if (late)
    holds |= kHoldLate;
  if (flushed_) // a flush may be over within a tick
    holds |= kHoldFlushing;
  if (motion_.cut)
    holds |= kHoldCut;
  SafetyChain::Input input;
  PlanarVelocity hand;
  if (environment_.device) {
    const auto &state = environment_.device->state();
    input.hand_velocity = state.velocity;
    hand = scale_hand(state.velocity, environment_.device->workspace_half(), motion_.sample,
                      settings.reference_width);
    if (!state.valid)
      holds |= kHoldNoPose;
    // A grip that nobody pushes may move as it likes.
    else if (environment_.device->grip_is_free() && state.velocity.norm() > kGripLetGo &&
             !chain_.silent() && !(holds & kHoldOverspeed)) {
      hold(kHoldOverspeed);
      holds |= kHoldOverspeed;
      add<std::uint64_t>(statistics_.overspeeds);
    }
  }

  if (!motion_.measured)
    conditioner_.restart_low_pass();
  const Motion &motion = conditioner_.step(scale_motion(motion_.sample, settings.reference_width),
                                           settings.smooth_hz, dt);
  input.wanted = laws_[settings.law]->wrench(motion, hand, settings.law_settings, dt);
  if (broken_)
    input.wanted.force.setConstant(std::numeric_limits<double>::quiet_NaN());
  input.measured = motion_.measured;
  input.confidence = motion_.sample.confidence;
  input.age = motion_.age;
  input.interval = motion_.interval;
  input.holds = holds;
  input.max_force = settings.law_settings.max_force;
  input.max_torque = settings.law_settings.max_torque;
  input.slew_rate = settings.slew_rate;
  input.damping = settings.damping;
  input.dt = dt;
  spidar::Wrench wrench = chain_.step(input);
  if (chain_.found_non_finite())
    add<std::uint64_t>(statistics_.non_finite);
  return wrench;
}

// The log begins with the running time. While the pipeline does not play, it goes on only until it
// has shown the force reach zero.
void HapticLoop::write_row(std::int64_t now, const spidar::Wrench &wrench) noexcept {
  const std::uint32_t holds = holds_.load();
  const bool playing = !(holds & kHoldPaused);
  log_begun_ = log_begun_ || (playing && running_time_.at(now) >= 0);
  const bool has_force = !chain_.silent();
  const bool wanted =
      log_begun_ && ((playing && !(holds & kHoldEnded)) || has_force || row_had_force_);
  row_had_force_ = has_force;
  if (!wanted)
    return;

  TickRow row;
  row.time = playing ? running_time_.advance(now) : running_time_.last();
  if (environment_.device) {
    const auto &state = environment_.device->state();
    for (std::size_t i = 0; i < row.position.size(); ++i)
      row.position[i] = state.pose.position[static_cast<Eigen::Index>(i)];
    for (std::size_t i = 0; i < row.tension.size(); ++i)
      row.tension[i] = state.tensions[static_cast<Eigen::Index>(i)];
  }
  if (has_force || chain_.listening()) {
    row.velocity = {motion_.sample.velocity_x, motion_.sample.velocity_y};
    row.spin = motion_.sample.spin;
  }
  row.force = {wrench.force.x(), wrench.force.y(), wrench.force.z()};
  row.torque = {wrench.torque.x(), wrench.torque.y(), wrench.torque.z()};
  row.confidence = motion_.sample.confidence;
  if (!environment_.log->write(row))
    add<std::uint64_t>(statistics_.log_rows_lost);
}

} // namespace haptic
