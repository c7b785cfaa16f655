// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/sink-messages.hpp"

#include <cstdint>
#include <string>

namespace haptic {
namespace {

struct ErrorCode {
  GQuark domain;
  gint code;
};

ErrorCode error_code(NoticeCause cause) {
  switch (cause) {
  case NoticeCause::not_found:
    return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NOT_FOUND};
  case NoticeCause::busy:
    return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_BUSY};
  case NoticeCause::settings:
    return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_SETTINGS};
  case NoticeCause::open:
    return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_OPEN_READ_WRITE};
  case NoticeCause::open_log:
    return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_OPEN_WRITE};
  case NoticeCause::write:
    return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_WRITE};
  case NoticeCause::format:
    return {GST_STREAM_ERROR, GST_STREAM_ERROR_FORMAT};
  case NoticeCause::failed:
    break;
  }
  return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_FAILED};
}

struct MessageLevel {
  GstMessageType message;
  GstDebugLevel log;
};

MessageLevel message_level(Severity severity) {
  switch (severity) {
  case Severity::error:
    return {GST_MESSAGE_ERROR, GST_LEVEL_ERROR};
  case Severity::warning:
    return {GST_MESSAGE_WARNING, GST_LEVEL_WARNING};
  case Severity::info:
    return {GST_MESSAGE_INFO, GST_LEVEL_INFO};
  case Severity::debug:
    break;
  }
  return {GST_MESSAGE_INFO, GST_LEVEL_DEBUG};
}

} // namespace

GstDebugLevel log_level(Severity severity) {
  return message_level(severity).log;
}

void post_notice(GstElement *element, const Notice &notice) {
  const ErrorCode code = error_code(*notice.cause);
  gchar *detail = notice.detail.empty() ? nullptr : g_strdup(notice.detail.c_str());
  gst_element_message_full(element, message_level(notice.severity).message, code.domain, code.code,
                           g_strdup(notice.text.c_str()), detail, __FILE__, GST_FUNCTION, __LINE__);
}

void post_stream_status(GstElement *element, GstStreamStatusType type) {
  gst_element_post_message(element,
                           gst_message_new_stream_status(GST_OBJECT(element), type, element));
}

void post_session(GstElement *element, const SessionStatus &status) {
  GstStructure *structure =
      gst_structure_new("haptic-session",                               //
                        "state", G_TYPE_STRING, name_of(status.state),  //
                        "reason", G_TYPE_STRING, status.reason.c_str(), //
                        "device", G_TYPE_STRING, status.device.c_str(), nullptr);
  gst_element_post_message(element, gst_message_new_element(GST_OBJECT(element), structure));
}

void post_stats(GstElement *element, const HapticSession &session) {
  gst_element_post_message(
      element, gst_message_new_element(GST_OBJECT(element), make_stats(session).release()));
}

StructurePtr make_stats(const HapticSession &session) {
  const LoopStatistics &loop = session.statistics();
  const SampleIntake &intake = session.intake();
  const auto ms = [](auto nanoseconds) { return static_cast<double>(nanoseconds) * 1e-6; };
  const std::uint64_t used = loop.samples_used;
  const double mean_age = used ? ms(loop.sample_age_sum.load()) / static_cast<double>(used) : 0;
  StructurePtr stats(
      gst_structure_new("hapticsink-stats",                                              //
                        "ticks", G_TYPE_UINT64, loop.ticks.load(),                       //
                        "late-ticks", G_TYPE_UINT64, loop.late_ticks.load(),             //
                        "missed-ticks", G_TYPE_UINT64, loop.missed_ticks.load(),         //
                        "jitter-p50", G_TYPE_DOUBLE, loop.lateness.percentile_us(0.5),   //
                        "jitter-p99", G_TYPE_DOUBLE, loop.lateness.percentile_us(0.99),  //
                        "jitter-max", G_TYPE_DOUBLE, loop.lateness.max_us(),             //
                        "loop-p50", G_TYPE_DOUBLE, loop.body.percentile_us(0.5),         //
                        "loop-p99", G_TYPE_DOUBLE, loop.body.percentile_us(0.99),        //
                        "loop-max", G_TYPE_DOUBLE, loop.body.max_us(),                   //
                        "samples", G_TYPE_UINT64, intake.samples(),                      //
                        "bad-samples", G_TYPE_UINT64, intake.bad_samples(),              //
                        "gaps", G_TYPE_UINT64, intake.gaps(),                            //
                        "reliefs", G_TYPE_UINT64, session.reliefs().reliefs(),           //
                        "bad-reliefs", G_TYPE_UINT64, session.reliefs().bad_reliefs(),   //
                        "sample-age", G_TYPE_DOUBLE, mean_age,                           //
                        "sample-age-max", G_TYPE_DOUBLE, ms(loop.sample_age_max.load()), //
                        "force-max", G_TYPE_DOUBLE, loop.force_max.load(),               //
                        "force-rms", G_TYPE_DOUBLE, loop.force_rms.load(),               //
                        "carry-stiffness", G_TYPE_DOUBLE, loop.carry_stiffness.load(),   //
                        "carry-distance", G_TYPE_DOUBLE, loop.carry_distance.load(),     //
                        "given-up-force", G_TYPE_DOUBLE, loop.given_up_force.load(),     //
                        "given-up-torque", G_TYPE_DOUBLE, loop.given_up_torque.load(),   //
                        "faults", G_TYPE_UINT64, loop.faults(),                          //
                        "log-rows-lost", G_TYPE_UINT64, loop.log_rows_lost.load(),       //
                        "samples-lost", G_TYPE_UINT64, loop.samples_lost.load(),         //
                        "state", G_TYPE_STRING, name_of(session.state()), nullptr));
  for (std::size_t i = 0; i < kLimitNames.size(); ++i)
    gst_structure_set(stats.get(), (std::string("limited-by-") + kLimitNames[i].name).c_str(),
                      G_TYPE_UINT64, loop.limited[i].load(), nullptr);
  return stats;
}

// Of a few readings the least disturbed one: the thread may be preempted between the two clocks.
std::optional<ClockReading> read_clocks(GstElement *element, const LoopClock &monotonic) {
  constexpr int kReadings = 5;
  GstClock *clock = gst_element_get_clock(element);
  if (!clock)
    return std::nullopt;
  const GstClockTime base = gst_element_get_base_time(element);
  std::optional<ClockReading> best;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kReadings; ++i) {
    const std::int64_t before = monotonic.now();
    const GstClockTime time = gst_clock_get_time(clock);
    const std::int64_t duration = monotonic.now() - before;
    if (!GST_CLOCK_TIME_IS_VALID(time) || !GST_CLOCK_TIME_IS_VALID(base) || duration >= least)
      continue;
    least = duration;
    best = ClockReading{before + duration / 2, GST_CLOCK_DIFF(base, time)};
  }
  gst_object_unref(clock);
  return best;
}

} // namespace haptic
