// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/haptic-session.hpp"

#include "format-text.hpp"
#include "messages.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace haptic {
namespace {

constexpr std::int64_t kMs = 1'000'000; // ns
constexpr std::int64_t kPointerPeriod = 10 * kMs;
constexpr std::int64_t kClockPeriod = 100 * kMs;
constexpr std::int64_t kLongestFade = 500 * kMs; // before a sleep

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

} // namespace

HapticSession::HapticSession(SessionClient &client, DeviceOpener opener)
    : client_(client), opener_(std::move(opener)), run_(fields_, relief_pool_) {}

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
  identity_ = device_ ? device_->identity() : "";
  loop_.set_homed(!device_);
  loop_.unhold(kHoldClosed | kHoldFaulted);
  state_.set_device(device_ ? device_->description() : "");
  update_state();
  client_.note(Severity::info, "opened " + (device_ ? device_->description() : "no device"));
  if (const std::string remark = device_ ? device_->remark() : ""; !remark.empty())
    client_.on_notice({Severity::warning, NoticeCause::open, remark, {}});
  return true;
}

void HapticSession::close() {
  loop_.hold(kHoldClosed);
  // A fault ends with the device that had it. What the user asked for (kHoldReleased), and what
  // disarmed a grip, do not.
  loop_.unhold(kHoldFaulted);
  device_.reset();
  opened_as_.reset();
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

void HapticSession::end_stream() {
  loop_.hold(kHoldEnded);
  update_state();
}

void HapticSession::update_state() {
  const auto read = [this] { return SessionCause{loop_.reasons(), loop_.homed(), clock_->now()}; };
  state_.update(read, [this](const SessionStatus &status) { client_.on_session_changed(status); });
}

bool HapticSession::open_log(const std::string &path) {
  if (path.empty())
    return true;
  const auto refuse = [&](const std::string &reason) {
    client_.on_notice({Severity::error, NoticeCause::open_log,
                       format_text(messages::kLogNotWritable, path.c_str(), reason.c_str()),
                       "log-location"});
    return false;
  };
  std::error_code unknown;
  if (std::filesystem::is_fifo(path, unknown)) // opening it would wait for a reader
    return refuse("it is a FIFO");
  try {
    log_ = std::make_unique<TickLog>(path, *clock_);
  } catch (const std::system_error &error) {
    return refuse(error.code().message());
  }
  return true;
}

void HapticSession::warn_of_what_is_beyond(const RunSettings &settings) {
  const spidar::DeviceLimits &limits = device_->limits();
  const LawSettings &law = settings.loop.law_settings;
  std::string most;
  const auto compare = [&](const char *property, double set, double limit, const char *unit) {
    if (limit > 0 && set > limit) // a device that has no torque at all needs no warning
      most += (most.empty() ? "" : ", ") + format_text("%s=%g%s", property, limit, unit);
  };
  compare("max-force", law.max_force, limits.force, " N");
  compare("max-torque", law.max_torque, limits.strongest_torque(), " N·m");
  compare("max-push", law.max_push, limits.strongest_push(), " N");
  compare("rate", settings.choice.rate, limits.rate, " Hz");
  if (!most.empty())
    client_.on_notice(
        {Severity::warning,
         NoticeCause::settings,
         format_text(messages::kBeyondDevice, device_->description().c_str(), most.c_str()),
         {}});
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
  run_.armed = is_armed();
  const spidar::DeviceLimits limits = device_ ? device_->limits() : spidar::DeviceLimits{};
  run_.reports = SessionReports(settings.fault_location, limits);
  read_description();
  if (device_)
    warn_of_what_is_beyond(settings);
  rate_ = std::min(static_cast<double>(opened_as_->rate), limits.rate);

  loop_.prepare({.device = device_.get(),
                 .lost = !device_ && opened_as_->device != "none", // in a run before this one
                 .log = log_.get(),
                 .clock = clock_,
                 .rate = rate_,
                 .dead_man = opened_as_->dead_man == DeadMan::button,
                 .records = !settings.fault_location.empty(),
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
  if (log_)
    log_->finish(); // its last rows may fail
  report(clock_->now());
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
  if (result.lost)
    loop_.count_lost_sample();
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
      run_.reports.report_tracker(client_, handled, now);
    }
    clock_->wait_until(clock_->now() + kPointerPeriod, self.stop_token());
  }
}

void HapticSession::round(std::int64_t now) {
  if (const auto point = work(now))
    run_.reports.report_tracker(client_, client_.on_point(*point), now);
}

// Everything of a round but sending the point that it returns.
std::optional<PointerPosition> HapticSession::work(std::int64_t now) {
  const bool playing = !(loop_.holds() & kHoldPaused);
  if (playing && (!run_.clock_read_at || now - *run_.clock_read_at > kClockPeriod)) {
    run_.clock_read_at = now;
    if (const auto reading = client_.read_clocks())
      set_running_time(*reading);
  }
  auto point = run_.has_hand ? next_point(now, playing) : std::nullopt;
  report(now);
  reopen_lost_device(now);
  return point;
}

void HapticSession::report(std::int64_t now) {
  run_.reports.report(client_, loop_, services_.get(), log_.get(), now);
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

// ---- before the machine sleeps ------------------------------------------------------------------

// A thread of the services. The machine sleeps once this returns.
void HapticSession::on_sleep() {
  loop_.hold(kHoldSuspended);
  client_.on_notice({Severity::info, NoticeCause::failed, messages::kAboutToSleep, {}});
  const std::int64_t deadline = clock_->now() + kLongestFade;
  while (!loop_.silent() && clock_->now() < deadline)
    clock_->wait_until(clock_->now() + kMs);
  // The next exchange sends what the last tick has computed.
  clock_->wait_until(clock_->now() + static_cast<std::int64_t>(3000 * kMs / rate_));
}

void HapticSession::reopen_lost_device(std::int64_t now) {
  if (!loop_.device_lost())
    return run_.reopening.rest();
  device_.reset();
  device_ = run_.reopening.attempt(
      now, [this] { return opener_.reopen(*opened_as_, identity_); }, client_);
  if (!device_)
    return;
  loop_.replace_device(device_.get());
  state_.set_device(device_->description());
  client_.on_notice({Severity::info,
                     NoticeCause::open,
                     format_text(messages::kDeviceIsBack, device_->description().c_str()),
                     {}});
  read_description();
}

} // namespace haptic
