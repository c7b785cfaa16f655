// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/session-reports.hpp"

#include "format-text.hpp"
#include "messages.hpp"
#include "session/fault-record.hpp"

#include <spidar/machine.hpp>
#include <system_error>
#include <utility>

namespace haptic {
namespace {

constexpr std::int64_t kTrackerGrace = 1'000'000'000; // ns
// A pipeline that begins to play keeps the processors busy, and the priority comes with a delay.
constexpr std::int64_t kSettles = 1'000'000'000; // ns
constexpr std::int64_t kJudged = 5'000'000'000;  // ns, after that

// A warning whenever its counter has changed, or once.
struct FaultReport {
  SharedValue<std::uint64_t> LoopStatistics::*counter;
  bool once;
  std::optional<NoticeCause> cause;
  const char *text;
  const char *detail;
};
constexpr std::array kFaultReports = {
    FaultReport{&LoopStatistics::device_faults, false, NoticeCause::write, messages::kDeviceSilent,
                "three exchanges in a row failed, or it was unplugged"},
    FaultReport{&LoopStatistics::overspeeds, false, NoticeCause::failed, messages::kGripLetGo,
                "latched until re-armed"},
    FaultReport{&LoopStatistics::suspends, false, NoticeCause::failed, messages::kMachineSlept,
                "latched until re-armed"},
    FaultReport{&LoopStatistics::shakes, false, NoticeCause::failed, messages::kForceShook,
                "latched until re-armed"},
    FaultReport{&LoopStatistics::non_finite, true, std::nullopt,
                "a force that was not finite counted as zero", ""},
    FaultReport{&LoopStatistics::samples_lost, true, NoticeCause::failed, messages::kSamplesLost,
                ""},
};

std::string error_text(int error) {
  return std::generic_category().message(error);
}

} // namespace

void SessionReports::report(SessionClient &client, HapticLoop &loop, SystemServices *services,
                            const TickLog *log, std::int64_t now) {
  began_at_ = began_at_.value_or(now);
  report_priority(client, loop.thread(), services);
  report_faults(client, loop.statistics());
  report_timing(client, loop, now);
  report_record(client, loop.recorder());
  report_log(client, log);
}

void SessionReports::report_tracker(SessionClient &client, bool handled, std::int64_t now) {
  tracker_found_ = tracker_found_ || handled;
  if (tracker_found_ || tracker_reported_ || now - *began_at_ <= kTrackerGrace)
    return;
  tracker_reported_ = true;
  client.note(Severity::info, "no tracker upstream takes the pointer events");
}

void SessionReports::report_priority(SessionClient &client, const RealTimeThread &thread,
                                     SystemServices *services) {
  int error = thread.priority_error();
  if (priority_reported_ || error < 0)
    return;
  if (error > 0 && services) {
    if (!std::exchange(priority_requested_, true))
      services->request_real_time(thread.number());
    const RealTimeAnswer answer = services->real_time_answer();
    if (answer == RealTimeAnswer::pending)
      return;
    if (answer == RealTimeAnswer::granted) {
      error = 0;
      client.note(Severity::info, messages::kPriorityOnLoan);
    }
  }
  priority_reported_ = true;
  has_priority_ = error == 0;
  const int memory_error = thread.memory_error();
  if (error == 0 && memory_error == 0)
    client.note(Severity::debug,
                "the loop has real-time priority; its object and its stack are locked");
  else
    client.note(Severity::info,
                format_text(messages::kNoRealTime, error ? error_text(error).c_str() : "granted",
                            memory_error ? error_text(memory_error).c_str() : "yes"));
}

void SessionReports::report_faults(SessionClient &client, const LoopStatistics &statistics) {
  static_assert(std::tuple_size_v<decltype(reported_)> == kFaultReports.size());
  for (std::size_t i = 0; i < kFaultReports.size(); ++i) {
    const FaultReport &fault = kFaultReports[i];
    const std::uint64_t count = (statistics.*fault.counter).load();
    const std::uint64_t before = std::exchange(reported_[i], count);
    if (count == before || (fault.once && before))
      continue;
    std::string text = fault.text;
    if (fault.counter == &LoopStatistics::overspeeds)
      text = format_text(messages::kGripLetGo, device_.let_go_speed, device_.let_go_turn);
    client.on_notice({Severity::warning, fault.cause, text, fault.detail});
  }
}

// As spidar-check --machine, once, and only if the first seconds of the force show that the machine
// is not fit or has limits.
void SessionReports::report_timing(SessionClient &client, const HapticLoop &loop,
                                   std::int64_t now) {
  if (timing_reported_)
    return;
  if (loop.holds() & kHoldPaused) {
    playing_since_.reset();
    return;
  }
  const std::int64_t played = now - *(playing_since_ = playing_since_.value_or(now));
  const DurationHistogram &lateness = loop.statistics().lateness;
  if (played < kSettles)
    settled_ = lateness.counts();
  if (played < kSettles + kJudged)
    return;
  timing_reported_ = true;
  const spidar::MachineVerdict verdict =
      spidar::judge_machine({.period = loop.period(),
                             .priority = has_priority_,
                             .lateness = {.usual = 1e-6 * lateness.percentile_us(0.999, settled_),
                                          .worst = 1e-6 * lateness.percentile_us(1, settled_)},
                             .device = device_});
  if (verdict.fitness == spidar::Fitness::fit)
    client.note(Severity::info, verdict.text);
  else
    client.on_notice({Severity::info, NoticeCause::failed, verdict.text, {}});
}

// Not a warning: the fault itself is one.
void SessionReports::report_record(SessionClient &client, FlightRecorder &recorder) {
  if (const std::string told = write_fault_record(recorder, fault_location_); !told.empty())
    client.on_notice({Severity::info, NoticeCause::failed, told, {}});
}

void SessionReports::report_log(SessionClient &client, const TickLog *log) {
  if (log_reported_ || !log || !log->error())
    return;
  log_reported_ = true;
  client.on_notice({Severity::warning,
                    NoticeCause::write,
                    format_text(messages::kLogStopped, error_text(log->error()).c_str()),
                    {}});
}

} // namespace haptic
