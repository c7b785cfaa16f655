// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/haptic-loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;                                              // ns
constexpr std::int64_t kTooLate = std::chrono::nanoseconds(spidar::kLongestSilence).count(); // ns
constexpr std::int64_t kRetryFaultedDevice = kSecond / 10;                                   // ns
// The holds that a tick finds for itself. The others are in holds_.
constexpr std::uint32_t kTickHolds = kHoldFlushing | kHoldLate | kHoldNoPose | kHoldGap |
                                     kHoldStale | kHoldCut | kHoldNonFinite | kHoldDeadMan |
                                     kHoldSlipped;

// Of these the film is the reason: the hand has done nothing, and the surface stays where it is.
constexpr std::uint32_t kHoldsOfFilm =
    kHoldGap | kHoldStale | kHoldCut | kHoldFlushing | kHoldEnded | kHoldSpent;
// ns, before the thread ends: a pause fades within 100 ms.
constexpr std::int64_t kLongestFade = 150'000'000;
// s, time constants. A late tick is rarely alone. While a spring holds, what the tick owes is paid
// first: with 1 s, a way gave 0.70 of 0.5 mJ.
constexpr double kForgetsLate = 1;
constexpr double kForgetsLateHeld = 5;

// Only the loop writes its counters, so no read-modify-write instruction is needed. Such an
// instruction, or a store in the default order, waits for all stores before it, and after a sleep
// many miss the caches.
template <typename T>
void add(std::atomic<T> &counter, T amount = 1) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + amount, std::memory_order_relaxed);
}

template <typename T>
void set(std::atomic<T> &value, T to) noexcept {
  value.store(to, std::memory_order_release);
}

// As exchange({}), which costs more; what comes just after the look is taken at the next tick.
template <typename T>
T take(std::atomic<T> &value) noexcept {
  return value.load(std::memory_order_relaxed) ? value.exchange({}) : T{};
}

template <typename T>
void raise(std::atomic<T> &maximum, T value) noexcept {
  if (value > maximum.load(std::memory_order_relaxed))
    maximum.store(value, std::memory_order_relaxed);
}

double seconds(std::int64_t nanoseconds) noexcept {
  return static_cast<double>(nanoseconds) / static_cast<double>(kSecond);
}

} // namespace

LoopSettings within(const LoopSettings &settings, const spidar::DeviceLimits &device) noexcept {
  LoopSettings possible = settings;
  LawSettings &law = possible.law_settings;
  law.max_force = std::min(law.max_force, device.force);
  law.max_torque = std::min(law.max_torque, device.strongest_torque());
  law.max_push = std::min(law.max_push, device.strongest_push());
  if (!device.knows_newtons())
    possible.damping = 0;
  return possible;
}

HapticLoop::Run::Run(Environment of, std::uint32_t at_epoch, std::uint32_t at_relief_epoch)
    : device_lost(of.lost), environment(std::move(of)),
      period(std::llround(static_cast<double>(kSecond) / environment.rate)), epoch(at_epoch),
      relief_epoch(at_relief_epoch) {
  for (const auto &law : force_laws())
    laws.push_back(law.make());
  if (environment.records)
    recorder = FlightRecorder(environment.rate);
}

void HapticLoop::adopt_limits() noexcept {
  const spidar::HapticDevice *device = run_.environment.device;
  run_.limits = device ? device->limits() : spidar::DeviceLimits{};
  run_.chain.set_device(run_.limits);
  run_.settings = within(settings_.value(), run_.limits);
}

HapticLoop::HapticLoop() = default;

HapticLoop::~HapticLoop() {
  stop();
}

void HapticLoop::prepare(Environment environment) {
  hold(kHoldPaused);
  unhold(kHoldFlushing | kHoldEnded);
  drop_samples();
  SafetyChain chain = run_.chain;
  std::int64_t rests_since = run_.rests_since;
  if (run_.last_tick) {
    chain.begin_run(seconds(run_.period));
    rests_since = run_.last_tick + run_.period;
  }
  run_ = Run(std::move(environment), epoch_, relief_epoch_);
  run_.chain = chain;
  adopt_limits();
  run_.rests_since = rests_since;
}

void HapticLoop::start(Environment environment) {
  prepare(std::move(environment));
  start_thread();
}

void HapticLoop::start_thread() {
  thread_.start(run_.environment.callbacks, std::as_bytes(std::span(this, 1)),
                [this](const std::stop_token &stop) { run(stop); });
}

void HapticLoop::stop() noexcept {
  thread_.end();
}

void HapticLoop::run(const std::stop_token &stop) noexcept {
  LoopClock &clock = *run_.environment.clock;
  std::int64_t next = clock.now() + run_.period;
  std::int64_t deadline = 0; // ns, of the fade before the end; 0: not yet
  const auto ends = [&] {
    if (!stop.stop_requested())
      return false;
    if (deadline == 0) {
      hold(kHoldPaused);
      deadline = clock.now() + kLongestFade;
    }
    return run_.silent.load() || clock.now() >= deadline;
  };
  while (!ends()) {
    clock.sleep_until(next);
    const std::int64_t now = clock.now();
    if (run_.suspend.has_slept(now, clock.boot_time())) {
      hold(kHoldSuspended);
      add<std::uint64_t>(run_.statistics.suspends);
    }
    tick(next, now);
    run_.statistics.body.record(clock.now() - now);
    next += run_.period;
    if (now > next) // skip the periods that are past rather than run them in a burst
      next += (now - next) / run_.period * run_.period;
  }

  if (spidar::HapticDevice *device = run_.environment.device) {
    device->rest(); // else the guardian misses the ticks that no longer come
    device->exchange(clock.now());
    device->exchange(clock.now());
  }
  run_.silent = true;
  run_.tick_holds = 0;
}

void HapticLoop::count_tick(std::int64_t lateness) noexcept {
  LoopStatistics &statistics = run_.statistics;
  statistics.lateness.record(lateness);
  add<std::uint64_t>(statistics.ticks);
  if (lateness > run_.period)
    add<std::uint64_t>(statistics.late_ticks);
  if (lateness > kTooLate)
    add<std::uint64_t>(statistics.missed_ticks);
}

void HapticLoop::tick(std::int64_t scheduled, std::int64_t now) noexcept {
  const std::int64_t lateness = now - scheduled;
  count_tick(lateness);
  if (!run_.last_tick && run_.rests_since)
    run_.chain.rest(seconds(now - run_.rests_since));
  const double dt = seconds(run_.last_tick ? now - run_.last_tick : run_.period);
  if (!run_.last_tick)
    run_.began_at = now;
  run_.last_tick = now;
  expect_late_ticks(dt);

  if (settings_.refresh())
    run_.settings = within(settings_.value(), run_.limits);
  receive_submissions(now);
  adopt_replacement();
  exchange(now);
  update_hand(dt);
  update_motion(now);
  update_touch(dt);
  update_carry(dt);
  const spidar::Wrench wrench = next_wrench(dt, lateness > kTooLate);
  if (spidar::HapticDevice *device = run_.environment.device) {
    device->let_rest(run_.chain.silent() && (run_.chain.holds() & ~kHoldSpent));
    device->limit_side_torque(
        run_.chain.most_side_torque(wrench.force, run_.settings.law_settings.max_torque));
    device->command(wrench);
    set(run_.statistics.given_up_force, device->state().given_up.force.norm());
    set(run_.statistics.given_up_torque, device->state().given_up.torque.norm());
  }
  if (run_.environment.log || run_.environment.records) {
    TickRow row = make_row(now, wrench);
    if (run_.environment.records)
      record_tick(row, lateness > run_.period);
    if (run_.environment.log)
      log_tick(now, row);
  }
  set(run_.statistics.carry_stiffness, run_.carry.stiffness());
  set(run_.statistics.carry_distance, run_.carry.spring().norm());
  run_.impulse.impulse += wrench.force * dt;
  run_.impulse.time += dt;
  run_.impulse_slot.write(run_.impulse);
  for (std::size_t i = 0; i < kLimitNames.size(); ++i)
    if (run_.chain.limits() & kLimitNames[i].bit)
      add<std::uint64_t>(run_.statistics.limited[i]);
  set(run_.silent, run_.chain.silent());
  set(run_.tick_holds, run_.chain.holds() & kTickHolds);
  raise(run_.statistics.force_max, wrench.force.norm());
  set(run_.statistics.force_rms, run_.chain.continuous_force().rms());
}

// A stiffness that comes back under the hand would be felt as a push. The spring to a held thing
// becomes shorter as it becomes stiffer.
void HapticLoop::expect_late_ticks(double dt) noexcept {
  if (!run_.touch.contact().touches)
    run_.longest_dt *=
        std::exp(-dt / (run_.carry.stiffness() > 0 ? kForgetsLateHeld : kForgetsLate));
  run_.longest_dt = std::max({run_.longest_dt, seconds(run_.period), dt});
}

void HapticLoop::receive_submissions(std::int64_t now) noexcept {
  const std::uint32_t epoch = epoch_.load();
  run_.flushed = epoch != run_.epoch;
  run_.epoch = epoch;
  if (run_.flushed)
    run_.interpolator.clear();
  run_.broken = false;
  const std::int64_t running = run_.running_time.at(now);
  receive_reliefs(running);
  for (Submission submission; submissions_.pop(submission);) {
    if (submission.epoch != epoch)
      continue;
    const MotionSample &sample = submission.motion.sample;
    if (!is_finite(sample) || !std::isfinite(sample.confidence) ||
        !std::isfinite(sample.held.x + sample.held.y)) {
      run_.broken = true;
      continue;
    }
    const bool measured = submission.motion.measured;
    run_.interpolator.add(std::move(submission.motion), running);
    if (!measured)
      continue;
    const std::int64_t age = now - submission.arrival;
    add<std::uint64_t>(run_.statistics.samples_used);
    add(run_.statistics.sample_age_sum, age);
    raise(run_.statistics.sample_age_max, age);
  }
}

void HapticLoop::receive_reliefs(std::int64_t running) noexcept {
  const std::uint32_t epoch = relief_epoch_.load();
  if (epoch != run_.relief_epoch)
    run_.touch.clear();
  run_.relief_epoch = epoch;
  for (ReliefSubmission submission; reliefs_.pop(submission);)
    if (submission.epoch == epoch)
      run_.touch.add(std::move(submission.relief), running);
}

void HapticLoop::adopt_replacement() noexcept {
  spidar::HapticDevice *device = take(run_.replacement);
  if (!device)
    return;
  run_.environment.device = device;
  adopt_limits();
  run_.failed_exchanges = 0;
  run_.retry_at = 0;
  homed_.store(false);
  hold(kHoldFaulted); // an `arm` while the device was lost does not count
  unhold(kHoldClosed);
}

void HapticLoop::lose_device() noexcept {
  hold(kHoldFaulted | kHoldClosed);
  homed_.store(false);
  run_.hand.write({});
  run_.environment.device = nullptr;
  run_.device_lost.store(true);
}

void HapticLoop::exchange(std::int64_t now) noexcept {
  run_.exchanged = run_.interruption_begins = false;
  spidar::HapticDevice *device = run_.environment.device;
  if (!device)
    return;
  if (take(run_.calibrate)) {
    device->calibrate();
    run_.chain.calibrate();
    run_.wash_out.reset();
    run_.touch.calibrate();
    run_.carry.restart();
  }
  const bool faulted = holds_.load() & kHoldFaulted;
  if (faulted && now < run_.retry_at)
    return;
  run_.retry_at = now + kRetryFaultedDevice;
  if (faulted) // not a force of zero, which needs a tick every few milliseconds
    device->rest();
  const bool answered = device->exchange(now);
  run_.exchanged = true;
  const bool gone = !answered && !device->connected();
  if (answered) {
    run_.failed_exchanges = 0;
  } else if (++run_.failed_exchanges == kFailuresToFault || gone) {
    run_.failed_exchanges = 0;
    if (!faulted) {
      hold(kHoldFaulted);
      add<std::uint64_t>(run_.statistics.device_faults);
      run_.retry_at = 0; // puts it at rest, which it may accept even if it does not answer
    }
  }
  const bool before = std::exchange(run_.interrupted, device->state().interrupted);
  run_.interruption_begins = run_.interrupted && !before;
  if (run_.interrupted) {
    run_.chain.restart(); // the motors are at rest
    run_.touch.hold();
    run_.carry.restart();
  }
  if (run_.interruption_begins)
    add<std::uint64_t>(run_.statistics.interruptions);
  if (gone)
    lose_device();
}

// A device that was not asked on this tick keeps the hand as it was.
void HapticLoop::update_hand(double dt) noexcept {
  const spidar::HapticDevice *device = run_.environment.device;
  if (!device)
    return;
  const spidar::DeviceState &state = device->state();
  const spidar::Vector3 &half = device->workspace_half();
  if (state.valid) {
    set(homed_, true);
    run_.wash_out.step(state.pose.position, state.velocity, half, run_.settings.wash_out, dt);
    run_.place = map_pointer(state.pose.position, half, run_.wash_out.shift());
    // The button of a dead-man switch says that there may be a force, no more.
    run_.place.pressed = state.pressed && !run_.environment.dead_man;
  }
  const LoopSettings &settings = run_.settings;
  HandPosition hand{.position = state.pose.position,
                    .valid = state.valid,
                    .pressed = state.pressed,
                    .shift = run_.wash_out.shift(),
                    .region_z = std::nullopt,
                    .proxy = std::nullopt};
  if (settings.touch != TouchMode::off) {
    const Contact &contact = run_.touch.contact();
    hand.region_z = settings.region_z;
    hand.proxy = contact.touches ? contact.proxy : hand.position;
  }
  run_.hand.write(hand);
}

void HapticLoop::update_motion(std::int64_t now) noexcept {
  // While the pipeline is paused its time stands still.
  if (!run_.flushed && (holds_.load() & kHoldPaused))
    return;
  const std::int64_t running = run_.running_time.at(now);
  PointerPosition place = run_.place;
  if (run_.settings.touch != TouchMode::off)
    place.z = run_.settings.region_z;
  run_.motion = run_.interpolator.at(running, place);
  run_.touch.update(running);
}

void HapticLoop::update_touch(double dt) noexcept {
  const LoopSettings &settings = run_.settings;
  const spidar::HapticDevice *device = run_.environment.device;
  if (settings.touch == TouchMode::off || !device || !run_.limits.knows_newtons())
    return run_.touch.leave();
  if (!device->state().valid) // the hand may be anywhere when it is known again
    return run_.touch.hold();
  if (run_.chain.holds() & ~kHoldsOfFilm)
    run_.touch.hold();
  const spidar::DeviceState &state = device->state();
  const ContactLimits limits{.device = run_.limits,
                             .slew_rate = settings.slew_rate,
                             .longest_dt = run_.longest_dt,
                             .energy = run_.chain.energy_of_hand()};
  run_.touch.step(state.pose.position, device->workspace_half(), run_.wash_out.shift(), limits, dt);
}

// Of a tether that a hold has ended nothing is left: it begins anew where the hand is then. That
// nothing is measured does not end it; a thing that is hidden comes back.
void HapticLoop::update_carry(double dt) noexcept {
  const LoopSettings &settings = run_.settings;
  const spidar::HapticDevice *device = run_.environment.device;
  if (settings.hold_law == HoldLaw::motion || settings.touch == TouchMode::surface || !device ||
      !device->state().valid || !run_.limits.knows_newtons() ||
      (run_.chain.holds() & ~(kHoldGap | kHoldSpent)))
    return run_.carry.restart();
  const MotionAt &motion = run_.motion;
  const bool fresh = motion.age <= stale_after(motion.interval);
  if (motion.held.another)
    run_.carry.end();
  run_.carry.step(fresh ? motion.held.state : HoldState::none,
                  map_way(motion.held.moved, device->workspace_half()),
                  device->state().pose.position,
                  {.device = run_.limits,
                   .max_force = settings.law_settings.max_force,
                   .slew_rate = settings.slew_rate,
                   .longest_dt = run_.longest_dt,
                   .energy = run_.chain.energy_of_hand()},
                  dt);
}

std::uint32_t HapticLoop::holds_of_tick(double dt, bool late) noexcept {
  std::uint32_t holds = holds_.load();
  if (late)
    holds |= kHoldLate;
  if (run_.flushed) // a flush may begin and end within a tick
    holds |= kHoldFlushing;
  const TouchMode touch = run_.settings.touch;
  if ((run_.motion.cut && touch != TouchMode::surface) ||
      (run_.touch.cut() && touch != TouchMode::off))
    holds |= kHoldCut;
  const std::uint32_t of_grip =
      run_.grip.holds(run_.environment.device, run_.chain, run_.environment.dead_man, dt);
  if (of_grip & ~holds & kHoldOverspeed) {
    hold(kHoldOverspeed);
    add<std::uint64_t>(run_.statistics.overspeeds);
  }
  return holds | of_grip;
}

// First halves what the law makes of the hand's motion, then stops the force.
void HapticLoop::calm_law(SafetyChain::Input &input, double dt) noexcept {
  if (run_.chain.silent())
    return;
  constexpr double kUsualPeriod = 1e-3; // s
  const double share = run_.shake.step(input.of_hand, input.hand_velocity,
                                       run_.limits.most_resistance(kUsualPeriod), dt);
  input.wanted.force -= (1 - share) * input.of_hand;
  input.of_hand *= share;
  if (!run_.shake.stops() || (holds_.load() & kHoldShaking))
    return;
  run_.shake = {};
  hold(kHoldShaking);
  add<std::uint64_t>(run_.statistics.shakes);
}

spidar::Wrench HapticLoop::next_wrench(double dt, bool late) noexcept {
  const LoopSettings &settings = run_.settings;
  LawSettings law = settings.law_settings;
  const MotionAt &now = run_.motion;
  SafetyChain::Input input;
  input.holds = holds_of_tick(dt, late);
  PlanarVelocity hand;
  if (spidar::HapticDevice *device = run_.environment.device) {
    input.hand_velocity = device->state().velocity;
    input.hand_turning = device->state().angular_velocity;
    if (run_.exchanged) { // else it was counted before
      input.acted = device->state().acted;
      input.moved = device->state().moved;
      input.turned = device->state().turned;
    }
    hand = scale_hand(input.hand_velocity, device->workspace_half(), now.sample,
                      settings.reference_width);
  }
  // All of them resist the hand.
  const double resistance = // N·s/m
      run_.limits.most_resistance(run_.longest_dt) - run_.touch.damping() - run_.carry.damping();
  if (run_.environment.bounds_hand)
    law.most_for_hand = std::max(resistance, 0.0) * input.hand_velocity.head<2>().norm();

  if (!now.measured)
    run_.conditioner.restart_low_pass();
  const Motion &motion = run_.conditioner.step(scale_motion(now.sample, settings.reference_width),
                                               settings.smooth_hz, dt);
  // Of a film that is paused or shows nothing the time stands still.
  const bool moves = now.measured && !(input.holds & kHoldPaused);
  ForceLaw *const felt = run_.laws[settings.law].get();
  if (moves && run_.followed != felt)
    felt->restart();
  run_.followed = moves ? felt : nullptr;
  input.wanted = felt->wrench(motion, hand, law, moves ? dt : 0);
  input.of_hand = felt->of_hand();
  calm_law(input, dt);
  input.measured = now.measured;
  input.trust = confidence_gate(now.sample.confidence);
  input.age = now.age;
  input.interval = now.interval;
  if (settings.touch != TouchMode::off)
    run_.touch.apply(settings.touch, input);
  run_.carry.apply(settings.hold_law, input);
  if (run_.broken)
    input.wanted.force.setConstant(std::numeric_limits<double>::quiet_NaN());
  input.max_force = law.max_force;
  input.continuous_force = settings.continuous_force;
  input.max_torque = law.max_torque;
  input.slew_rate = settings.slew_rate;
  input.damping = settings.damping;
  input.dt = dt;
  input.longest_dt = run_.longest_dt;
  spidar::Wrench wrench = run_.chain.step(input);
  if (run_.chain.found_non_finite())
    add<std::uint64_t>(run_.statistics.non_finite);
  return wrench;
}

// A release is no riddle: the user asked for it.
void HapticLoop::record_tick(const TickRow &row, bool late) noexcept {
  constexpr std::uint32_t kRules = kFaults | kHoldNonFinite | kHoldSlipped;
  run_.recorder.record(row, late);
  const std::uint32_t holds = holds_.load() | run_.chain.holds();
  // Not because of a fault.
  const bool interrupted = run_.interruption_begins && !(holds & kHoldFaulted);
  const std::uint32_t begun = holds & ~std::exchange(run_.recorded_holds, holds) & kRules;
  if (begun || interrupted)
    run_.recorder.keep(begun);
}

// The log begins with the running time. While the pipeline does not play, it continues only until
// it has shown the force reach zero.
void HapticLoop::log_tick(std::int64_t now, TickRow &row) noexcept {
  const std::uint32_t holds = holds_.load();
  const bool playing = !(holds & kHoldPaused);
  if (!run_.log_start && playing && run_.running_time.at(now) >= 0)
    run_.log_start = now;
  const bool has_force = !run_.chain.silent();
  const bool wanted =
      run_.log_start && ((playing && !(holds & kHoldEnded)) || has_force || run_.row_had_force);
  run_.row_had_force = has_force;
  row.mono = seconds(now - run_.log_start.value_or(now));
  if (wanted && !run_.environment.log->write(row))
    add<std::uint64_t>(run_.statistics.log_rows_lost);
}

TickRow HapticLoop::make_row(std::int64_t now, const spidar::Wrench &wrench) noexcept {
  const MotionSample &sample = run_.motion.sample;
  const bool playing = !(holds_.load() & kHoldPaused);
  TickRow row;
  row.time = playing ? run_.running_time.advance(now) : run_.running_time.last();
  if (run_.environment.device)
    row.read(run_.environment.device->state());
  if (!run_.chain.silent() || run_.chain.follows_sample()) {
    row.velocity = {sample.velocity_x, sample.velocity_y};
    row.spin = sample.spin;
  }
  row.commanded = wrench;
  row.confidence = sample.confidence;
  row.mono = seconds(now - run_.began_at);
  row.hold = run_.chain.holds();
  row.limits = run_.chain.limits();
  row.energy = run_.chain.continuous_force().used();
  const Contact &contact = run_.touch.contact();
  row.touches = contact.touches;
  row.proxy = contact.touches ? contact.proxy : row.position;
  return row;
}

} // namespace haptic
