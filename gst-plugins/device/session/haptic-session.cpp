// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/haptic-session.hpp"

#include "format-text.hpp"
#include "messages.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

namespace haptic {
namespace {

constexpr std::int64_t kMs = 1'000'000; // ns
constexpr std::int64_t kPointerPeriod = 10 * kMs;
constexpr std::int64_t kClockPeriod = 100 * kMs;
constexpr std::int64_t kTrackerGrace = 1000 * kMs;
constexpr std::int64_t kFirstReopening = 100 * kMs; // after the loss; doubled with each attempt
constexpr std::int64_t kLastReopening = 500 * kMs;

constexpr std::int64_t kLongestFade = 500 * kMs; // before a sleep

// The faults that are reported whenever their counter has changed.
struct FaultReport {
  SharedValue<std::uint64_t> LoopStatistics::*counter;
  NoticeCause cause;
  const char *text;
  const char *detail;
};
constexpr std::array kFaultReports = {
    FaultReport{&LoopStatistics::device_faults, NoticeCause::write, messages::kDeviceSilent,
                "three exchanges in a row failed, or it was unplugged"},
    FaultReport{&LoopStatistics::overspeeds, NoticeCause::failed, messages::kGripLetGo,
                "latched until re-armed"},
    FaultReport{&LoopStatistics::suspends, NoticeCause::failed, messages::kMachineSlept,
                "latched until re-armed"},
};

NoticeCause notice_cause(spidar::Cause cause) noexcept {
  switch (cause) {
  case spidar::Cause::not_found:
    return NoticeCause::not_found;
  case spidar::Cause::busy:
    return NoticeCause::busy;
  case spidar::Cause::geometry:
  case spidar::Cause::argument:
    return NoticeCause::settings;
  case spidar::Cause::permission:
  case spidar::Cause::io:
    break;
  }
  return NoticeCause::open;
}

std::string error_text(int error) {
  return std::generic_category().message(error);
}

} // namespace

HapticSession::HapticSession(SessionClient &client, DeviceOpener opener)
    : client_(client), opener_(std::move(opener)), run_(fields_, relief_pool_) {}

void HapticSession::note(Severity severity, std::string text) {
  client_.on_notice({severity, std::nullopt, std::move(text), {}});
}

// ---- the device and the run ---------------------------------------------------------------------

bool HapticSession::open(const DeviceChoice &choice) {
  OpenedDevice opened;
  try {
    opened = opener_.open(choice);
  } catch (const spidar::Error &error) {
    client_.on_notice({Severity::error, notice_cause(error.cause()), error.what(),
                       "device=" + choice.device + " geometry=" + choice.geometry +
                           " sim-hand=" + choice.sim_hand});
    return false;
  }
  if (opened.simulated_instead)
    client_.on_notice({Severity::warning, NoticeCause::not_found, messages::kSimulatedInstead, {}});
  device_ = std::move(opened.device);
  opened_as_ = choice;
  loop_.set_homed(!device_);
  loop_.unhold(kHoldClosed | kFaults);
  state_.set_device(device_ ? device_->description() : "");
  update_state();
  note(Severity::info, "opened " + (device_ ? device_->description() : "no device"));
  if (const std::string remark = device_ ? device_->remark() : ""; !remark.empty())
    client_.on_notice({Severity::warning, NoticeCause::open, remark, {}});
  return true;
}

void HapticSession::close() {
  loop_.hold(kHoldClosed);
  // A fault ends with the device that had it. What the user asked for (kHoldReleased) does not.
  loop_.unhold(kFaults);
  device_.reset();
  update_state();
}

void HapticSession::arm() {
  loop_.unhold(kLatches);
  update_state();
}

void HapticSession::release() {
  loop_.hold(kHoldReleased);
  update_state();
}

void HapticSession::update_state() {
  const auto read = [this] { return SessionCause{loop_.reasons(), loop_.homed()}; };
  state_.update(read, [this](const SessionStatus &status) { client_.on_session_changed(status); });
}

bool HapticSession::open_log(const std::string &path) {
  if (path.empty())
    return true;
  try {
    log_ = std::make_unique<TickLog>(path, *clock_);
  } catch (const std::system_error &error) {
    client_.on_notice(
        {Severity::error, NoticeCause::open_log,
         format_text(messages::kLogNotWritable, path.c_str(), error.code().message().c_str()),
         "log-location"});
    return false;
  }
  return true;
}

bool HapticSession::prepare(const RunSettings &settings) {
  if (settings.choice != opened_as_) { // a property has changed since open()
    close();
    if (!open(settings.choice))
      return false;
  }
  if (!open_log(settings.log_location))
    return false;
  run_ = Run(fields_, relief_pool_);
  run_.reopening.wait = kFirstReopening;
  run_.armed = is_armed();
  read_description();

  loop_.prepare({.device = device_.get(),
                 .lost = !device_ && opened_as_.device != "none", // in a run before this one
                 .log = log_.get(),
                 .clock = clock_,
                 .rate = static_cast<double>(opened_as_.rate),
                 .dead_man = opened_as_.dead_man == DeadMan::button,
                 .callbacks = settings.callbacks});
  loop_.set_running_time(clock_->now(), 0); // until the client has a clock
  return true;
}

void HapticSession::start_loop() {
  loop_.start_thread();
  services_ = std::make_unique<SystemServices>([this] { on_sleep(); });
}

void HapticSession::end_run() {
  loop_.adopt_replacement(); // if no tick has
  report();
  services_.reset();
  log_.reset();
}

// ---- streaming ----------------------------------------------------------------------------------

void HapticSession::begin_flush() noexcept {
  loop_.hold(kHoldFlushing);
  loop_.drop_samples();
}

void HapticSession::end_flush() noexcept {
  loop_.drop_samples(); // those that accept() was about to submit
  loop_.unhold(kHoldFlushing | kHoldEnded);
}

void HapticSession::accept(std::span<const std::uint8_t> bytes, bool gap,
                           const Presentation &presentation) {
  SampleIntake::Result result = run_.intake.accept(bytes, gap, presentation);
  if (result.motion)
    loop_.submit(*std::move(result.motion), clock_->now());
  if (result.damaged && !std::exchange(run_.damage_reported, true))
    client_.on_notice({Severity::warning, NoticeCause::format, messages::kSampleDamaged,
                       std::to_string(bytes.size()) + " bytes"});
}

void HapticSession::accept_relief(std::span<const std::uint8_t> bytes, bool gap,
                                  std::int64_t time) {
  ReliefIntake::Result result = run_.reliefs.accept(bytes, gap, time);
  if (result.relief)
    loop_.submit(*std::move(result.relief));
  if (result.damaged && !std::exchange(run_.relief_damage_reported, true))
    client_.on_notice({Severity::warning, NoticeCause::format, messages::kReliefDamaged,
                       std::to_string(bytes.size()) + " bytes"});
}

void HapticSession::accept_gap(std::int64_t time) noexcept {
  loop_.submit(run_.intake.accept_gap(time), clock_->now());
}

// ---- pointer thread -----------------------------------------------------------------------------

void HapticSession::run_rounds(CallbackThread::Self &self) {
  while (!self.stop_requested()) {
    const std::int64_t now = clock_->now();
    if (const auto point = work(now)) {
      bool handled = false;
      if (!self.call_out(
              [&client = client_, &point, &handled] { handled = client.on_point(*point); }))
        return;
      report_tracker(handled, now);
    }
    clock_->wait_until(clock_->now() + kPointerPeriod, self.stop_token());
  }
}

void HapticSession::round(std::int64_t now) {
  if (const auto point = work(now))
    report_tracker(client_.on_point(*point), now);
}

// Everything of a round but sending the point that it returns.
std::optional<PointerPosition> HapticSession::work(std::int64_t now) {
  if (!run_.began_at)
    run_.began_at = now;
  const bool playing = !(loop_.holds() & kHoldPaused);
  if (playing && (!run_.clock_read_at || now - *run_.clock_read_at > kClockPeriod)) {
    run_.clock_read_at = now;
    if (const auto reading = client_.read_clocks())
      set_running_time(*reading);
  }
  auto point = run_.has_hand ? next_point(now, playing) : std::nullopt;
  report();
  reopen_lost_device(now);
  return point;
}

void HapticSession::report() {
  report_priority();
  report_faults();
  report_losses();
  report_log();
  update_state();
  if (const bool armed = is_armed(); armed != run_.armed) {
    run_.armed = armed;
    client_.on_armed_changed();
  }
}

void HapticSession::read_description() {
  if (!device_)
    return;
  run_.has_hand = true;
  run_.workspace_half = device_->workspace_half();
  run_.description = device_->description();
}

std::optional<PointerPosition> HapticSession::next_point(std::int64_t now, bool playing) {
  const HandPosition hand = loop_.hand();
  if (!hand.valid)
    return std::nullopt;
  PointerPosition point = map_pointer(hand.position, run_.workspace_half, hand.shift);
  if (hand.region_z)
    point.z = *hand.region_z;
  if (hand.proxy) {
    const PointerPosition proxy = map_pointer(*hand.proxy, run_.workspace_half, hand.shift);
    point.proxy = {proxy.x, proxy.y, (*hand.proxy - hand.position).norm()};
  }
  point.pressed = hand.pressed;
  const Impulse impulse = loop_.impulse();
  if (const double elapsed = impulse.time - run_.last_sent.time; elapsed > 0) {
    const spidar::Vector3 mean = (impulse.impulse - run_.last_sent.impulse) / elapsed;
    point.force = {mean.x(), mean.y(), mean.z()};
  }
  if (!run_.gate.pass(point, now))
    return std::nullopt;
  run_.last_sent = impulse;
  point.device = run_.description;
  if (playing)
    if (const auto reading = client_.read_clocks(); reading && reading->running >= 0)
      point.timestamp = static_cast<std::uint64_t>(reading->running);
  return point;
}

void HapticSession::report_tracker(bool handled, std::int64_t now) {
  run_.tracker_found = run_.tracker_found || handled;
  if (run_.tracker_found || run_.tracker_reported || now - *run_.began_at <= kTrackerGrace)
    return;
  run_.tracker_reported = true;
  note(Severity::info, "no tracker upstream takes the pointer events");
}

void HapticSession::report_priority() {
  int error = loop_.thread().priority_error();
  if (run_.priority_reported || error < 0)
    return;
  if (error > 0 && services_) {
    if (!std::exchange(run_.priority_requested, true))
      services_->request_real_time(loop_.thread().number());
    const RealTimeAnswer answer = services_->real_time_answer();
    if (answer == RealTimeAnswer::pending)
      return;
    if (answer == RealTimeAnswer::granted)
      error = 0;
  }
  run_.priority_reported = true;
  const int memory_error = loop_.thread().memory_error();
  if (error == 0 && memory_error == 0)
    note(Severity::debug, "the loop has real-time priority, and its memory is locked");
  else
    note(Severity::info,
         format_text(messages::kNoRealTime, error ? error_text(error).c_str() : "granted",
                     memory_error ? error_text(memory_error).c_str() : "granted"));
}

void HapticSession::report_faults() {
  const LoopStatistics &statistics = loop_.statistics();
  static_assert(std::tuple_size_v<decltype(Run::faults)> == kFaultReports.size());
  for (std::size_t i = 0; i < kFaultReports.size(); ++i) {
    const FaultReport &report = kFaultReports[i];
    const std::uint64_t count = (statistics.*report.counter).load();
    if (std::exchange(run_.faults[i], count) != count)
      client_.on_notice({Severity::warning, report.cause, report.text, report.detail});
  }
  if (!run_.non_finite_reported && statistics.non_finite.load() > 0) {
    run_.non_finite_reported = true;
    note(Severity::warning, "a force that was not finite counted as zero");
  }
}

void HapticSession::report_losses() {
  if (run_.loss_reported || loop_.statistics().samples_lost.load() == 0)
    return;
  run_.loss_reported = true;
  client_.on_notice({Severity::warning, NoticeCause::failed, messages::kSamplesLost, {}});
}

void HapticSession::report_log() {
  if (run_.log_reported || !log_ || !log_->error())
    return;
  run_.log_reported = true;
  client_.on_notice({Severity::warning,
                     NoticeCause::write,
                     format_text(messages::kLogStopped, error_text(log_->error()).c_str()),
                     {}});
}

// ---- before the machine sleeps ------------------------------------------------------------------

// A thread of the services. The machine sleeps once this returns.
void HapticSession::on_sleep() {
  loop_.hold(kHoldSuspended);
  client_.on_notice({Severity::info, NoticeCause::failed, messages::kAboutToSleep, {}});
  const std::int64_t deadline = clock_->now() + kLongestFade;
  while (!loop_.silent() && clock_->now() < deadline)
    clock_->wait_until(clock_->now() + kMs);
  // The next exchange sends what the last tick has computed.
  clock_->wait_until(clock_->now() + 3000 * kMs / opened_as_.rate);
}

// ---- opening a lost device again ----------------------------------------------------------------

void HapticSession::reopen_lost_device(std::int64_t now) {
  Reopening &reopening = run_.reopening;
  if (!loop_.device_lost()) {
    reopening.wait = kFirstReopening;
    return;
  }
  if (device_ || !reopening.waiting) {
    device_.reset();
    reopening = {.waiting = true, .wait = reopening.wait, .next_at = now + reopening.wait};
  }
  if (now < reopening.next_at)
    return;
  try {
    device_ = opener_.reopen(opened_as_);
  } catch (const spidar::Error &error) {
    reopening.wait = std::min(2 * reopening.wait, kLastReopening);
    reopening.next_at = now + reopening.wait;
    report_reopening(error);
    return;
  }
  reopening.waiting = false;
  loop_.replace_device(device_.get());
  state_.set_device(device_->description());
  client_.on_notice({Severity::info,
                     NoticeCause::open,
                     format_text(messages::kDeviceIsBack, device_->description().c_str()),
                     {}});
  read_description();
}

// A device that has just been plugged in may need a moment until it may be opened.
void HapticSession::report_reopening(const spidar::Error &error) {
  Reopening &reopening = run_.reopening;
  note(Severity::debug, std::string("not opened again yet: ") + error.what());
  if (error.cause() == spidar::Cause::not_found) {
    reopening.reported.clear();
  } else if (reopening.reported != error.what() && reopening.wait == kLastReopening) {
    reopening.reported = error.what();
    client_.on_notice(
        {Severity::warning, NoticeCause::open, error.what(), "while opening it again"});
  }
}

} // namespace haptic
