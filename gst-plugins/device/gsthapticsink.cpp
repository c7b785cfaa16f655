// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-hapticsink
 *
 * Lets the hand feel the motion that velocityavg measures. See docs/elements/hapticsink.md.
 */
#include "gsthapticsink.h"

#include "cadence.hpp"
#include "device-choice.hpp"
#include "exception-barrier.hpp"
#include "field-pool.hpp"
#include "field-sampler.hpp"
#include "gst-raii.hpp"
#include "haptic-loop.hpp"
#include "motion-sample.hpp"
#include "playback-rate.hpp"
#include "pointer-event.hpp"
#include "pointer-mapping.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <spidar/error.hpp>
#include <string>
#include <system_error>
#include <utility>

GST_DEBUG_CATEGORY_STATIC(haptic_sink_debug);
#define GST_CAT_DEFAULT haptic_sink_debug

namespace {

using namespace std::chrono_literals;
using haptic::guarded;
using haptic::ObjectLock;

enum class LatencyMode { automatic, synchronized, immediate };
enum class Liveness { unknown, live, not_live };

constexpr auto kPointerPeriod = 10ms;
constexpr auto kClockPeriod = 100ms;
constexpr auto kTrackerGrace = 1s;
constexpr auto kFirstReopening = 100ms; // after the loss; then twice as long each time
constexpr auto kLastReopening = 500ms;
constexpr auto kEndFade = 150ms; // the fade's 100 ms and some ticks

constexpr double kHighestForce = 5;  // N, what a SPIDAR-G's motors are good for
constexpr double kHighestAlpha = 10; // s/px
constexpr unsigned kWidestFrame = 65536;
constexpr double kLowestSlewRate = 0.1; // N/s
constexpr double kHighestSlewRate = 1000;
constexpr unsigned kLowestRate = 100; // Hz
constexpr unsigned kHighestRate = 4000;
constexpr double kLongestGainWindow = 600; // s
constexpr double kHighestTorque = 0.1;     // N·m, 5 N at the grip's radius
constexpr double kSlowestSpinHalf = 0.01;  // rad/s
constexpr double kFastestSpinHalf = 100;
constexpr double kHighestDamping = 10; // N·s/m
constexpr double kHighestSmoothHz = 500;

// A motion can be felt when it is seen if its sample is known 1.5 intervals before.
constexpr double kLookAheadIntervals = 1.5;
constexpr GstClockTime kLongestLookAhead = 750 * GST_MSECOND; // queues hold 1 s

struct State {
  // The object's lock.
  haptic::DeviceChoice choice;
  std::string log_location;
  haptic::LoopSettings settings; // handed to the loop on every change

  // The thread that changes the state; the pointer thread while it runs and the loop has lost the
  // device.
  haptic::DeviceChoice opened_as;
  std::unique_ptr<spidar::HapticDevice> device;
  std::unique_ptr<haptic::TickLog> log;

  // Streaming thread. Made when fields are to come; before the loop, which gives them back.
  std::unique_ptr<haptic::FieldPool> fields;
  bool takes_fields = false; // what the caps say

  // Its members say who may call them.
  haptic::HapticLoop loop;

  // Streaming thread; the counters are read by anybody.
  std::atomic<std::uint64_t> samples = 0;
  std::atomic<std::uint64_t> bad_samples = 0;
  std::atomic<std::uint64_t> gaps = 0;
  bool warned_of_bad_sample = false;
  haptic::Cadence cadence;
  GstClockTime last_interval = 0; // of the sample before
  GstClockTime look_ahead = 0;    // running time

  std::atomic<LatencyMode> latency_mode = LatencyMode::automatic;
  std::atomic<haptic::RateLaw> rate_law = haptic::RateLaw::as_seen;
  std::atomic<Liveness> liveness = Liveness::unknown;

  // Wakes the streaming thread where it waits for the force to fade at the end of the stream.
  std::mutex end_mutex;
  std::condition_variable end_changed;
  bool unlocked = false; // end_mutex

  std::mutex pointer_mutex; // only to sleep on
  std::condition_variable_any pointer_wake;
  std::jthread pointer_thread; // last: ends before what it uses
};

} // namespace

struct _GstHapticSink {
  GstBaseSink parent;
  State *state;
};

#define GST_TYPE_HAPTIC_SINK_FORCE_LAW (gst_haptic_sink_force_law_get_type())
static GType gst_haptic_sink_force_law_get_type() {
  static const GType type = [] {
    static std::vector<GEnumValue> values;
    for (const auto &law : haptic::force_laws())
      values.push_back({static_cast<gint>(values.size()), law.description, law.name});
    values.push_back({0, nullptr, nullptr});
    return g_enum_register_static("GstHapticSinkForceLaw", values.data());
  }();
  return type;
}

#define GST_TYPE_HAPTIC_SINK_LATENCY_MODE (gst_haptic_sink_latency_mode_get_type())
static GType gst_haptic_sink_latency_mode_get_type() {
  static const GType type = [] {
    static const GEnumValue values[] = {
        {static_cast<gint>(LatencyMode::automatic),
         "Immediate if the source is live, else synchronized", "auto"},
        {static_cast<gint>(LatencyMode::synchronized), "Each sample at its time stamp",
         "synchronized"},
        {static_cast<gint>(LatencyMode::immediate), "Each sample as soon as it comes", "immediate"},
        {0, nullptr, nullptr}};
    return g_enum_register_static("GstHapticSinkLatencyMode", values);
  }();
  return type;
}

#define GST_TYPE_HAPTIC_SINK_RATE_LAW (gst_haptic_sink_rate_law_get_type())
static GType gst_haptic_sink_rate_law_get_type() {
  static const GType type = [] {
    static const GEnumValue values[] = {
        {static_cast<gint>(haptic::RateLaw::as_seen),
         "Motion as it is seen: slow motion feels softer", "as-seen"},
        {static_cast<gint>(haptic::RateLaw::as_filmed),
         "Motion as it was filmed, however fast it is played", "as-filmed"},
        {0, nullptr, nullptr}};
    return g_enum_register_static("GstHapticSinkRateLaw", values);
  }();
  return type;
}

G_DEFINE_TYPE_WITH_CODE(GstHapticSink, gst_haptic_sink, GST_TYPE_BASE_SINK,
                        GST_DEBUG_CATEGORY_INIT(haptic_sink_debug, "hapticsink", 0,
                                                "motion as force on the hand"))
GST_ELEMENT_REGISTER_DEFINE(hapticsink, "hapticsink", GST_RANK_NONE, GST_TYPE_HAPTIC_SINK)

namespace {

enum Property {
  kPropDevice = 1,
  kPropForceLaw,
  kPropMaxForce,
  kPropAlpha,
  kPropReferenceWidth,
  kPropLatencyMode,
  kPropRate,
  kPropSlewRate,
  kPropGeometry,
  kPropLogLocation,
  kPropSimHand,
  kPropArmed,
  kPropStats,
  kPropGainWindow,
  kPropMaxTorque,
  kPropSpinHalf,
  kPropMaxPush,
  kPropDamping,
  kPropSmoothHz,
  kPropRateLaw,
  kPropCount
};
std::array<GParamSpec *, kPropCount> properties{};

State &state_of(gpointer object) {
  return *GST_HAPTIC_SINK(object)->state;
}

GstBaseSinkClass *parent_class() {
  return GST_BASE_SINK_CLASS(gst_haptic_sink_parent_class);
}

bool is_armed(const State &state) {
  return !(state.loop.holds() & (haptic::kHoldClosed | haptic::kLatches));
}

// ---- statistics ---------------------------------------------------------------------------------

haptic::StructurePtr make_stats(const State &state) {
  const haptic::LoopStatistics &loop = state.loop.statistics();
  const auto ms = [](auto nanoseconds) { return static_cast<double>(nanoseconds) * 1e-6; };
  const std::uint64_t used = loop.samples_used;
  const double mean_age = used ? ms(loop.sample_age_sum.load()) / static_cast<double>(used) : 0;
  const std::uint64_t faults =
      loop.device_faults + loop.overspeeds + loop.suspends + loop.non_finite + loop.interruptions;
  return haptic::StructurePtr(
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
                        "samples", G_TYPE_UINT64, state.samples.load(),                  //
                        "bad-samples", G_TYPE_UINT64, state.bad_samples.load(),          //
                        "gaps", G_TYPE_UINT64, state.gaps.load(),                        //
                        "sample-age", G_TYPE_DOUBLE, mean_age,                           //
                        "sample-age-max", G_TYPE_DOUBLE, ms(loop.sample_age_max.load()), //
                        "force-max", G_TYPE_DOUBLE, loop.force_max.load(),               //
                        "faults", G_TYPE_UINT64, faults,                                 //
                        "log-rows-lost", G_TYPE_UINT64, loop.log_rows_lost.load(), nullptr));
}

void post_stats(GstHapticSink *self) {
  gst_element_post_message(
      GST_ELEMENT(self),
      gst_message_new_element(GST_OBJECT(self), make_stats(*self->state).release()));
}

// ---- time ---------------------------------------------------------------------------------------

struct ClockReading {
  std::int64_t monotonic; // ns
  std::int64_t running;   // ns
};

// Nothing without a clock. Of a few readings the least disturbed one: the thread may be preempted
// between reading the two clocks.
std::optional<ClockReading> read_clocks(GstHapticSink *self) {
  constexpr int kReadings = 5;
  GstClock *clock = gst_element_get_clock(GST_ELEMENT(self));
  if (!clock)
    return std::nullopt;
  const GstClockTime base = gst_element_get_base_time(GST_ELEMENT(self));
  std::optional<ClockReading> best;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kReadings; ++i) {
    const std::int64_t before = haptic::monotonic_now();
    const GstClockTime time = gst_clock_get_time(clock);
    const std::int64_t taken = haptic::monotonic_now() - before;
    if (!GST_CLOCK_TIME_IS_VALID(time) || !GST_CLOCK_TIME_IS_VALID(base) || taken >= least)
      continue;
    least = taken;
    best = ClockReading{before + taken / 2, GST_CLOCK_DIFF(base, time)};
  }
  gst_object_unref(clock);
  return best;
}

void refresh_running_time(GstHapticSink *self) {
  if (const auto reading = read_clocks(self))
    self->state->loop.set_running_time(reading->monotonic, reading->running);
}

// ---- pointer thread -----------------------------------------------------------------------------

// Opens a device that was unplugged again when it is back.
class Reopening {
public:
  explicit Reopening(GstHapticSink *self) : self_(self) {}

  /// True when there is a new device, which the loop has been given.
  bool step() {
    State &state = *self_->state;
    if (!state.loop.device_lost()) {
      wait_ = kFirstReopening;
      return false;
    }
    const auto now = std::chrono::steady_clock::now();
    if (state.device || !waiting_) {
      state.device.reset();
      waiting_ = true;
      reported_.clear();
      next_ = now + wait_;
    }
    if (now < next_)
      return false;
    try {
      state.device = haptic::reopen_device(state.opened_as);
    } catch (const spidar::Error &error) {
      wait_ = std::min<std::chrono::milliseconds>(2 * wait_, kLastReopening);
      next_ = now + wait_;
      report(error);
      return false;
    }
    waiting_ = false;
    state.loop.replace_device(state.device.get());
    GST_ELEMENT_INFO(self_, RESOURCE, OPEN_READ_WRITE,
                     ("The device is back: %s. Hold the grip in the centre, calibrate (signal "
                      "calibrate), and re-arm (signal arm).",
                      state.device->description().c_str()),
                     (nullptr));
    return true;
  }

private:
  // What has just been plugged in may for a moment not be allowed to be opened.
  void report(const spidar::Error &error) {
    GST_DEBUG_OBJECT(self_, "not yet: %s", error.what());
    if (error.cause() == spidar::Cause::not_found)
      return reported_.clear();
    if (reported_ != error.what() && wait_ == kLastReopening) {
      reported_ = error.what();
      GST_ELEMENT_WARNING(self_, RESOURCE, OPEN_READ_WRITE, ("%s", error.what()),
                          ("while opening it again"));
    }
  }

  GstHapticSink *self_;
  std::chrono::milliseconds wait_ = kFirstReopening;
  std::chrono::steady_clock::time_point next_;
  bool waiting_ = false;
  std::string reported_;
};

// What the pointer thread remembers from round to round.
class PointerRounds {
public:
  explicit PointerRounds(GstHapticSink *self)
      : self_(self), reopening_(self), armed_(is_armed(*self->state)) {
    know_device();
  }

  void round() {
    const auto now = std::chrono::steady_clock::now();
    const bool playing = !(self_->state->loop.holds() & haptic::kHoldPaused);
    if (playing && now - clock_read_ > kClockPeriod) {
      clock_read_ = now;
      refresh_running_time(self_);
    }
    if (has_hand_)
      tell_pointer(playing);
    report_priority();
    report_faults();
    if (reopening_.step())
      know_device();
    report_log();
    if (const bool armed = is_armed(*self_->state); armed != armed_) {
      armed_ = armed;
      g_object_notify_by_pspec(G_OBJECT(self_), properties[kPropArmed]);
    }
  }

private:
  void know_device() {
    const auto &device = self_->state->device;
    if (!device)
      return;
    has_hand_ = true;
    workspace_half_ = device->workspace_half();
    description_ = device->description();
  }

  void tell_pointer(bool playing) {
    const haptic::HandPosition hand = self_->state->loop.hand();
    if (!hand.valid)
      return;
    haptic::PointerPosition position = haptic::map_pointer(hand.position, workspace_half_);
    const haptic::Impulse impulse = self_->state->loop.impulse();
    if (const double taken = impulse.time - told_.time; taken > 0) {
      const spidar::Vector3 mean = (impulse.impulse - told_.impulse) / taken;
      position.force = {mean.x(), mean.y(), mean.z()};
    }
    const std::int64_t now = haptic::monotonic_now();
    if (!gate_.pass(position, now))
      return;
    told_ = impulse;
    position.device = description_;
    if (playing)
      if (const auto reading = read_clocks(self_); reading && reading->running >= 0)
        position.timestamp = static_cast<GstClockTime>(reading->running);
    const bool handled = gst_pad_push_event(GST_BASE_SINK_PAD(self_),
                                            haptic::make_pointer_event(position).release());
    GST_LOG_OBJECT(self_, "pointer at %.3f, %.3f%s", position.x, position.y,
                   handled ? "" : ", which nobody wanted");
    tracker_found_ = tracker_found_ || handled;
    if (!tracker_found_ && !tracker_reported_ &&
        std::chrono::steady_clock::now() - started_ > kTrackerGrace) {
      tracker_reported_ = true;
      GST_INFO_OBJECT(self_, "no tracker upstream; the pointer goes nowhere");
    }
  }

  void report_priority() {
    const int error = self_->state->loop.priority_error();
    if (priority_reported_ || error < 0)
      return;
    priority_reported_ = true;
    const int memory_error = self_->state->loop.memory_error();
    if (error == 0 && memory_error == 0)
      GST_DEBUG_OBJECT(self_, "the loop has real-time priority, and its memory is locked");
    else
      GST_INFO_OBJECT(self_,
                      "a busy machine may delay the force: real-time priority %s, locked memory "
                      "%s; allow them with the lines \"@plugdev - rtprio 60\" and \"@plugdev - "
                      "memlock 8192\" in /etc/security/limits.d/spidar.conf",
                      error ? g_strerror(error) : "granted",
                      memory_error ? g_strerror(memory_error) : "granted");
  }

  void report_faults() {
    const haptic::LoopStatistics &loop = self_->state->loop.statistics();
    if (const auto faults = loop.device_faults.load(); faults != device_faults_) {
      device_faults_ = faults;
      GST_ELEMENT_WARNING(self_, RESOURCE, WRITE,
                          ("The device does not answer. The force is off and the video goes on. "
                           "Check its cable and power, then re-arm (signal arm)."),
                          ("three exchanges in a row failed, or it was unplugged"));
    }
    if (const auto overspeeds = loop.overspeeds.load(); overspeeds != overspeeds_) {
      overspeeds_ = overspeeds;
      GST_ELEMENT_WARNING(self_, RESOURCE, FAILED,
                          ("The grip moved faster than 1 m/s, as if it had been let go. The force "
                           "is off and the video goes on. Take the grip and re-arm (signal arm)."),
                          ("latched until re-armed"));
    }
    if (const auto suspends = loop.suspends.load(); suspends != suspends_) {
      suspends_ = suspends;
      GST_ELEMENT_WARNING(self_, RESOURCE, FAILED,
                          ("The machine slept. The force is off and the video goes on. Take the "
                           "grip and re-arm (signal arm)."),
                          ("latched until re-armed"));
    }
    if (!non_finite_reported_ && loop.non_finite.load()) {
      non_finite_reported_ = true;
      GST_WARNING_OBJECT(self_, "a force that was not finite was taken as zero");
    }
  }

  void report_log() {
    const auto &log = self_->state->log;
    if (log_reported_ || !log || !log->error())
      return;
    log_reported_ = true;
    GST_ELEMENT_WARNING(self_, RESOURCE, WRITE,
                        ("The log cannot be written any more: %s. It is incomplete; the force "
                         "goes on.",
                         g_strerror(log->error())),
                        (nullptr));
  }

  GstHapticSink *self_;
  Reopening reopening_;
  bool has_hand_ = false;
  spidar::Vector3 workspace_half_ = spidar::Vector3::Ones(); // m
  std::string description_;
  haptic::PointerGate gate_;
  haptic::Impulse told_; // as of the last event
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point clock_read_;
  std::uint64_t device_faults_ = 0;
  std::uint64_t overspeeds_ = 0;
  std::uint64_t suspends_ = 0;
  bool armed_;
  bool tracker_found_ = false;
  bool tracker_reported_ = false;
  bool priority_reported_ = false;
  bool non_finite_reported_ = false;
  bool log_reported_ = false;
};

void run_pointer_thread(GstHapticSink *self, const std::stop_token &stop) {
  State &state = *self->state;
  PointerRounds rounds(self);
  while (!stop.stop_requested()) {
    rounds.round();
    std::unique_lock lock(state.pointer_mutex);
    state.pointer_wake.wait_for(lock, stop, kPointerPeriod, [] { return false; });
  }
  rounds.round(); // what happened since must not go unreported
}

// ---- device and threads -------------------------------------------------------------------------

GstResourceError resource_error(spidar::Cause cause) {
  switch (cause) {
  case spidar::Cause::not_found:
    return GST_RESOURCE_ERROR_NOT_FOUND;
  case spidar::Cause::busy:
    return GST_RESOURCE_ERROR_BUSY;
  case spidar::Cause::geometry:
  case spidar::Cause::argument:
    return GST_RESOURCE_ERROR_SETTINGS;
  case spidar::Cause::permission:
  case spidar::Cause::io:
    break;
  }
  return GST_RESOURCE_ERROR_OPEN_READ_WRITE;
}

bool open_device(GstHapticSink *self) {
  State &state = *self->state;
  haptic::DeviceChoice choice;
  {
    const ObjectLock lock(self);
    choice = state.choice;
  }
  haptic::OpenedDevice opened;
  try {
    opened = haptic::open_device(choice);
  } catch (const spidar::Error &error) {
    gst_element_message_full(GST_ELEMENT(self), GST_MESSAGE_ERROR, GST_RESOURCE_ERROR,
                             resource_error(error.cause()), g_strdup(error.what()),
                             g_strdup_printf("device=%s geometry=%s sim-hand=%s",
                                             choice.device.c_str(), choice.geometry.c_str(),
                                             choice.sim_hand.c_str()),
                             __FILE__, GST_FUNCTION, __LINE__);
    return false;
  }
  if (opened.simulated_instead)
    GST_ELEMENT_WARNING(self, RESOURCE, NOT_FOUND,
                        ("No SPIDAR-G found on USB; a simulated one takes its place. Plug one in, "
                         "or say device=sim to be spared this message."),
                        (nullptr));
  state.device = std::move(opened.device);
  state.opened_as = choice;
  // What went wrong with a device is over once it is opened anew; what the user said is not.
  state.loop.unhold(haptic::kHoldClosed | haptic::kHoldOverspeed | haptic::kHoldFaulted |
                    haptic::kHoldSuspended);
  GST_INFO_OBJECT(self, "opened %s",
                  state.device ? state.device->description().c_str() : "no device");
  return true;
}

void close_device(GstHapticSink *self) {
  self->state->loop.hold(haptic::kHoldClosed);
  self->state->device.reset();
}

// Properties may have been changed in READY.
bool reopen_if_changed(GstHapticSink *self) {
  State &state = *self->state;
  {
    const ObjectLock lock(self);
    if (state.choice == state.opened_as)
      return true;
  }
  close_device(self);
  return open_device(self);
}

bool open_log(GstHapticSink *self) {
  State &state = *self->state;
  std::string path;
  {
    const ObjectLock lock(self);
    path = state.log_location;
  }
  if (path.empty())
    return true;
  try {
    state.log = std::make_unique<haptic::TickLog>(path);
  } catch (const std::system_error &error) {
    GST_ELEMENT_ERROR(
        self, RESOURCE, OPEN_WRITE,
        ("The log \"%s\" cannot be written: %s.", path.c_str(), error.code().message().c_str()),
        ("log-location"));
    return false;
  }
  return true;
}

void post_stream_status(GstHapticSink *self, GstStreamStatusType type) {
  gst_element_post_message(
      GST_ELEMENT(self), gst_message_new_stream_status(GST_OBJECT(self), type, GST_ELEMENT(self)));
}

void stop_pointer_thread_and_log(State &state) {
  state.pointer_thread = {};
  state.log.reset();
}

bool start_threads(GstHapticSink *self) {
  State &state = *self->state;
  if (!reopen_if_changed(self) || !open_log(self))
    return false;
  state.samples = state.bad_samples = state.gaps = 0;
  state.warned_of_bad_sample = false;
  state.cadence.forget();
  state.last_interval = state.look_ahead = 0;
  state.liveness = Liveness::unknown;

  haptic::HapticLoop::Environment environment;
  environment.device = state.device.get();
  environment.lost = !state.device && state.opened_as.device != "none"; // in a run before this one
  environment.log = state.log.get();
  environment.rate = state.opened_as.rate;
  environment.entered = [self] {
    guarded(self, [&] { post_stream_status(self, GST_STREAM_STATUS_TYPE_ENTER); });
  };
  environment.left = [self] {
    guarded(self, [&] { post_stream_status(self, GST_STREAM_STATUS_TYPE_LEAVE); });
  };
  post_stream_status(self, GST_STREAM_STATUS_TYPE_CREATE);
  try {
    state.loop.start(std::move(environment));
    state.loop.set_running_time(haptic::monotonic_now(), 0); // until there is a clock to ask
    state.pointer_thread = std::jthread([self](const std::stop_token &stop) {
      guarded(self, [&] { run_pointer_thread(self, stop); });
    });
  } catch (const std::system_error &) {
    state.loop.stop();
    stop_pointer_thread_and_log(state);
    throw;
  }
  return true;
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  GstHapticSink *self = GST_HAPTIC_SINK(element);
  State &state = *self->state;
  switch (transition) {
  case GST_STATE_CHANGE_READY_TO_PAUSED:
    if (!start_threads(self))
      return GST_STATE_CHANGE_FAILURE;
    break;
  case GST_STATE_CHANGE_PLAYING_TO_PAUSED:
    state.loop.hold(haptic::kHoldPaused);
    break;
  case GST_STATE_CHANGE_PAUSED_TO_READY:
    state.loop.stop();
    break;
  default:
    break;
  }

  // A sample is taken before its frame is due, so that on a pause the next may be held up behind
  // another sink that has its frame. There is nothing to show while paused: nothing to wait for.
  GstBaseSink *sink = GST_BASE_SINK(self);
  const gboolean async = gst_base_sink_is_async_enabled(sink);
  if (transition == GST_STATE_CHANGE_PLAYING_TO_PAUSED)
    gst_base_sink_set_async_enabled(sink, FALSE);
  const GstStateChangeReturn result =
      GST_ELEMENT_CLASS(gst_haptic_sink_parent_class)->change_state(element, transition);
  gst_base_sink_set_async_enabled(sink, async);
  const bool failed = result == GST_STATE_CHANGE_FAILURE;

  switch (transition) {
  case GST_STATE_CHANGE_READY_TO_PAUSED:
    if (failed) {
      state.loop.stop();
      stop_pointer_thread_and_log(state);
    }
    break;
  case GST_STATE_CHANGE_PAUSED_TO_PLAYING:
    if (!failed) {
      refresh_running_time(self);
      state.loop.unhold(haptic::kHoldPaused);
    }
    break;
  case GST_STATE_CHANGE_PAUSED_TO_READY:
    // Not before the parent has let the streaming thread go: the pointer thread may be in an
    // element that waits for it.
    stop_pointer_thread_and_log(state);
    break;
  default:
    break;
  }
  return result;
}

// ---- streaming ----------------------------------------------------------------------------------

bool is_immediate(GstHapticSink *self) {
  State &state = *self->state;
  if (!gst_base_sink_get_sync(GST_BASE_SINK(self)))
    return true;
  const LatencyMode mode = state.latency_mode;
  if (mode != LatencyMode::automatic)
    return mode == LatencyMode::immediate;
  if (state.liveness == Liveness::unknown) {
    // Asked of the peer: the base class answers only once it has prerolled, which costs a live
    // source its first sample.
    const haptic::QueryPtr query(gst_query_new_latency());
    if (gst_pad_peer_query(GST_BASE_SINK_PAD(self), query.get())) {
      gboolean live = FALSE;
      gst_query_parse_latency(query.get(), &live, nullptr, nullptr);
      state.liveness = live ? Liveness::live : Liveness::not_live;
      GST_INFO_OBJECT(self, "%s",
                      live ? "live: samples are felt as soon as they come"
                           : "not live: samples are felt at their time stamps");
    }
  }
  return state.liveness == Liveness::live;
}

// ns of running time at which what has this time stamp is presented; kAtOnce when it is not to
// wait.
std::int64_t presented_at(GstHapticSink *self, GstClockTime pts) {
  GstBaseSink *sink = GST_BASE_SINK(self);
  if (is_immediate(self) || !GST_CLOCK_TIME_IS_VALID(pts) ||
      sink->segment.format != GST_FORMAT_TIME)
    return haptic::kAtOnce;
  guint64 running = 0;
  const int sign = gst_segment_to_running_time_full(&sink->segment, GST_FORMAT_TIME, pts, &running);
  if (sign == 0)
    return haptic::kAtOnce;
  return sign * static_cast<std::int64_t>(running) +
         static_cast<std::int64_t>(gst_base_sink_get_latency(sink)) +
         gst_base_sink_get_ts_offset(sink);
}

// Samples are wanted so long before they are due. It grows to what the stream needs; a single late
// frame is no measure.
void look_ahead(State &state, GstClockTime interval) {
  const GstClockTime usual = std::min(interval, std::exchange(state.last_interval, interval));
  const auto wanted = static_cast<GstClockTime>(kLookAheadIntervals * static_cast<double>(usual));
  state.look_ahead = std::clamp(wanted, state.look_ahead, kLongestLookAhead);
}

// The middle of a frame's interval, when that is to be felt.
std::int64_t middle_of(GstHapticSink *self, GstClockTime pts, std::uint64_t interval) {
  const std::int64_t time = presented_at(self, pts);
  return time == haptic::kAtOnce ? time : time - static_cast<std::int64_t>(interval / 2);
}

void take_gap(GstHapticSink *self, GstClockTime pts, const haptic::MotionSample &sample = {}) {
  State &state = *self->state;
  ++state.gaps;
  state.cadence.forget();
  state.loop.submit_gap(sample, haptic::monotonic_now(),
                        middle_of(self, pts, std::min(sample.interval, kLongestLookAhead)));
}

haptic::Playback playback_of(GstHapticSink *self) {
  const GstSegment &segment = GST_BASE_SINK(self)->segment;
  return {segment.rate, segment.applied_rate,
          (segment.flags & (GST_SEGMENT_FLAG_TRICKMODE | GST_SEGMENT_FLAG_TRICKMODE_KEY_UNITS)) !=
              0};
}

void take_sample(GstHapticSink *self, GstClockTime pts, haptic::MotionSample sample) {
  State &state = *self->state;
  const auto correction = static_cast<float>(state.cadence.correction(sample));
  if (sample.flags & haptic::kMotionDuplicate)
    return; // says nothing new; the motion goes on
  sample.velocity_x *= correction;
  sample.velocity_y *= correction;
  sample.spin *= correction;
  sample.divergence *= correction;
  const auto played = haptic::play(sample, playback_of(self), state.rate_law);
  if (!played)
    return take_gap(self, pts);
  look_ahead(state, played->interval);
  state.loop.submit(*played, haptic::monotonic_now(), middle_of(self, pts, played->interval));
}

void take_field(GstHapticSink *self, GstClockTime pts, haptic::FieldPool::Field field) {
  State &state = *self->state;
  const auto correction = static_cast<float>(state.cadence.correction(haptic::frame_of(*field)));
  if (field->flags & haptic::kMotionDuplicate)
    return;
  for (haptic::FieldCell &cell : field->cells) {
    cell.velocity_x *= correction;
    cell.velocity_y *= correction;
  }
  if (!haptic::play(*field, playback_of(self), state.rate_law))
    return take_gap(self, pts);
  const std::uint64_t interval = field->interval;
  look_ahead(state, interval);
  state.loop.submit(std::move(field), haptic::monotonic_now(), middle_of(self, pts, interval));
}

void take_damaged(GstHapticSink *self, GstBuffer *buffer) {
  State &state = *self->state;
  ++state.bad_samples;
  state.loop.submit_gap();
  if (!std::exchange(state.warned_of_bad_sample, true))
    GST_ELEMENT_WARNING(self, STREAM, FORMAT,
                        ("A motion sample is damaged and was felt as nothing. Further ones are "
                         "only counted (stats)."),
                        ("%" GST_PTR_FORMAT, static_cast<void *>(buffer)));
}

void render_sample(GstHapticSink *self, GstBuffer *buffer, std::span<const std::uint8_t> bytes) {
  const auto sample = haptic::unpack_motion_sample(bytes);
  const GstClockTime pts = GST_BUFFER_PTS(buffer);
  const bool gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP);
  if (!gap && (!sample || !haptic::is_plausible(*sample)))
    return take_damaged(self, buffer);
  self->state->samples += !gap;
  if (!gap && sample->confidence > 0)
    take_sample(self, pts, *sample);
  else
    take_gap(self, pts, sample.value_or(haptic::MotionSample{}));
}

void render_field(GstHapticSink *self, GstBuffer *buffer, std::span<const std::uint8_t> bytes) {
  haptic::FieldPool::Field field = self->state->fields->acquire();
  if (!field)
    return; // the loop stands still; as with samples, the newest is lost
  const bool readable = haptic::unpack_motion_field(bytes, *field);
  const GstClockTime pts = GST_BUFFER_PTS(buffer);
  const bool gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP);
  if (!gap && (!readable || !haptic::is_plausible(*field)))
    return take_damaged(self, buffer);
  self->state->samples += !gap;
  const bool measured = std::ranges::any_of(
      field->cells, [](const haptic::FieldCell &cell) { return cell.confidence > 0; });
  if (!gap && measured)
    take_field(self, pts, std::move(field));
  else
    take_gap(self, pts, readable ? haptic::frame_of(*field) : haptic::MotionSample{});
}

GstFlowReturn render(GstBaseSink *sink, GstBuffer *buffer) {
  GstHapticSink *self = GST_HAPTIC_SINK(sink);
  refresh_running_time(self);
  GstMapInfo map{};
  const bool mapped = gst_buffer_map(buffer, &map, GST_MAP_READ);
  const std::span<const std::uint8_t> bytes(map.data, map.size);
  if (self->state->takes_fields)
    render_field(self, buffer, bytes);
  else
    render_sample(self, buffer, bytes);
  if (mapped)
    gst_buffer_unmap(buffer, &map);
  return GST_FLOW_OK;
}

void get_times(GstBaseSink *sink, GstBuffer *buffer, GstClockTime *start, GstClockTime *end) {
  *start = *end = GST_CLOCK_TIME_NONE;
  if (is_immediate(GST_HAPTIC_SINK(sink)))
    return; // nothing to wait for
  parent_class()->get_times(sink, buffer, start, end);
  // Handed over earlier by the look-ahead, but not before the segment begins: what is outside of it
  // is dropped.
  const GstSegment &segment = sink->segment;
  const auto ahead = static_cast<GstClockTime>(static_cast<double>(state_of(sink).look_ahead) *
                                               std::abs(segment.rate));
  if (segment.rate > 0 && GST_CLOCK_TIME_IS_VALID(*start) && *start > segment.start)
    *start -= std::min(ahead, *start - segment.start);
  if (segment.rate < 0 && GST_CLOCK_TIME_IS_VALID(*end) && GST_CLOCK_TIME_IS_VALID(segment.stop) &&
      *end < segment.stop)
    *end += std::min(ahead, segment.stop - *end);
}

gboolean set_caps(GstBaseSink *sink, GstCaps *caps) {
  GST_DEBUG_OBJECT(sink, "%" GST_PTR_FORMAT, static_cast<void *>(caps));
  gint n = 0;
  gint d = 0;
  State &state = state_of(sink);
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  state.takes_fields = g_strcmp0(gst_structure_get_string(structure, "layout"), "field") == 0;
  if (state.takes_fields && !state.fields)
    state.fields = std::make_unique<haptic::FieldPool>();
  if (gst_structure_get_fraction(structure, "framerate", &n, &d) && n > 0 && d > 0) {
    state.last_interval =
        gst_util_uint64_scale(GST_SECOND, static_cast<guint64>(d), static_cast<guint64>(n));
    look_ahead(state, state.last_interval);
  }
  return TRUE;
}

gboolean event(GstBaseSink *sink, GstEvent *event) {
  haptic::HapticLoop &loop = state_of(sink).loop;
  const GstEventType type = GST_EVENT_TYPE(event);
  if (type == GST_EVENT_FLUSH_START) {
    loop.hold(haptic::kHoldFlushing);
    loop.drop_samples();
  } else if (type == GST_EVENT_STREAM_START || type == GST_EVENT_SEGMENT) {
    loop.unhold(haptic::kHoldEnded);
  }
  const gboolean result = parent_class()->event(sink, event);
  if (type == GST_EVENT_FLUSH_STOP) {
    loop.drop_samples(); // what render() may have been about to submit
    loop.unhold(haptic::kHoldFlushing | haptic::kHoldEnded);
  }
  return result;
}

// The force is gone before anybody is told of the end, since programs then tear everything down.
GstFlowReturn fade_at_end(GstBaseSink *sink) {
  State &state = state_of(sink);
  state.loop.hold(haptic::kHoldEnded);
  const auto deadline = std::chrono::steady_clock::now() + kEndFade;
  while (!state.loop.silent() && std::chrono::steady_clock::now() < deadline) {
    bool unlocked = false;
    {
      std::unique_lock lock(state.end_mutex);
      unlocked = state.end_changed.wait_for(lock, 2ms, [&] { return state.unlocked; });
    }
    if (!unlocked)
      continue;
    const GstFlowReturn result = gst_base_sink_wait_preroll(sink);
    if (result != GST_FLOW_OK)
      return result;
  }
  return GST_FLOW_OK;
}

GstFlowReturn wait_event(GstBaseSink *sink, GstEvent *event) {
  GstHapticSink *self = GST_HAPTIC_SINK(sink);
  if (GST_EVENT_TYPE(event) == GST_EVENT_GAP && is_immediate(self)) {
    const GstFlowReturn result = gst_base_sink_do_preroll(sink, GST_MINI_OBJECT_CAST(event));
    if (result == GST_FLOW_OK)
      take_gap(self, GST_CLOCK_TIME_NONE);
    return result;
  }
  GstFlowReturn result = parent_class()->wait_event(sink, event);
  if (result != GST_FLOW_OK)
    return result;
  if (GST_EVENT_TYPE(event) == GST_EVENT_GAP) {
    GstClockTime pts = GST_CLOCK_TIME_NONE;
    gst_event_parse_gap(event, &pts, nullptr);
    take_gap(self, pts);
  }
  if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) {
    result = fade_at_end(sink);
    if (result == GST_FLOW_OK)
      post_stats(self);
  }
  return result;
}

gboolean set_unlocked(GstBaseSink *sink, bool unlocked) {
  State &state = state_of(sink);
  {
    const std::lock_guard lock(state.end_mutex);
    state.unlocked = unlocked;
  }
  state.end_changed.notify_all();
  return TRUE;
}

// ---- properties and signals ---------------------------------------------------------------------

std::string string_of(const GValue *value) {
  const gchar *text = g_value_get_string(value);
  return text ? text : "";
}

void set_property(GObject *object, guint id, const GValue *value, GParamSpec *pspec) {
  State &state = state_of(object);
  const ObjectLock lock(object);
  switch (id) {
  case kPropDevice:
    state.choice.device = string_of(value);
    return;
  case kPropGeometry:
    state.choice.geometry = string_of(value);
    return;
  case kPropSimHand:
    state.choice.sim_hand = string_of(value);
    return;
  case kPropRate:
    state.choice.rate = g_value_get_uint(value);
    return;
  case kPropLogLocation:
    state.log_location = string_of(value);
    return;
  case kPropLatencyMode:
    state.latency_mode = static_cast<LatencyMode>(g_value_get_enum(value));
    return;
  case kPropForceLaw:
    state.settings.law = static_cast<std::size_t>(g_value_get_enum(value));
    break;
  case kPropMaxForce:
    state.settings.law_settings.max_force = g_value_get_double(value);
    break;
  case kPropAlpha:
    state.settings.law_settings.alpha = g_value_get_double(value);
    break;
  case kPropReferenceWidth:
    state.settings.reference_width = g_value_get_uint(value);
    break;
  case kPropSlewRate:
    state.settings.slew_rate = g_value_get_double(value);
    break;
  case kPropGainWindow:
    state.settings.law_settings.gain_window = g_value_get_double(value);
    break;
  case kPropMaxTorque:
    state.settings.law_settings.max_torque = g_value_get_double(value);
    break;
  case kPropSpinHalf:
    state.settings.law_settings.spin_half = g_value_get_double(value);
    break;
  case kPropMaxPush:
    state.settings.law_settings.max_push = g_value_get_double(value);
    break;
  case kPropDamping:
    state.settings.damping = g_value_get_double(value);
    break;
  case kPropSmoothHz:
    state.settings.smooth_hz = g_value_get_double(value);
    break;
  case kPropRateLaw:
    state.rate_law = static_cast<haptic::RateLaw>(g_value_get_enum(value));
    return;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
    return;
  }
  state.loop.set_settings(state.settings);
}

void get_property(GObject *object, guint id, GValue *value, GParamSpec *pspec) {
  State &state = state_of(object);
  if (id == kPropStats) {
    g_value_take_boxed(value, make_stats(state).release());
    return;
  }
  const ObjectLock lock(object);
  switch (id) {
  case kPropDevice:
    g_value_set_string(value, state.choice.device.c_str());
    break;
  case kPropGeometry:
    g_value_set_string(value, state.choice.geometry.c_str());
    break;
  case kPropSimHand:
    g_value_set_string(value, state.choice.sim_hand.c_str());
    break;
  case kPropRate:
    g_value_set_uint(value, state.choice.rate);
    break;
  case kPropLogLocation:
    g_value_set_string(value, state.log_location.empty() ? nullptr : state.log_location.c_str());
    break;
  case kPropLatencyMode:
    g_value_set_enum(value, static_cast<gint>(state.latency_mode.load()));
    break;
  case kPropForceLaw:
    g_value_set_enum(value, static_cast<gint>(state.settings.law));
    break;
  case kPropMaxForce:
    g_value_set_double(value, state.settings.law_settings.max_force);
    break;
  case kPropAlpha:
    g_value_set_double(value, state.settings.law_settings.alpha);
    break;
  case kPropReferenceWidth:
    g_value_set_uint(value, static_cast<guint>(state.settings.reference_width));
    break;
  case kPropSlewRate:
    g_value_set_double(value, state.settings.slew_rate);
    break;
  case kPropGainWindow:
    g_value_set_double(value, state.settings.law_settings.gain_window);
    break;
  case kPropMaxTorque:
    g_value_set_double(value, state.settings.law_settings.max_torque);
    break;
  case kPropSpinHalf:
    g_value_set_double(value, state.settings.law_settings.spin_half);
    break;
  case kPropMaxPush:
    g_value_set_double(value, state.settings.law_settings.max_push);
    break;
  case kPropDamping:
    g_value_set_double(value, state.settings.damping);
    break;
  case kPropSmoothHz:
    g_value_set_double(value, state.settings.smooth_hz);
    break;
  case kPropRateLaw:
    g_value_set_enum(value, static_cast<gint>(state.rate_law.load()));
    break;
  case kPropArmed:
    g_value_set_boolean(value, is_armed(state));
    break;
  default:
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
    break;
  }
}

void calibrate(GstHapticSink *self) {
  self->state->loop.calibrate();
}

void arm(GstHapticSink *self) {
  self->state->loop.unhold(haptic::kLatches);
  g_object_notify_by_pspec(G_OBJECT(self), properties[kPropArmed]);
}

void release(GstHapticSink *self) {
  self->state->loop.hold(haptic::kHoldReleased);
  g_object_notify_by_pspec(G_OBJECT(self), properties[kPropArmed]);
}

void install_properties(GObjectClass *klass) {
  const auto ready = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS |
                                              GST_PARAM_MUTABLE_READY);
  const auto playing = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS |
                                                GST_PARAM_MUTABLE_PLAYING);
  const auto readable = static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS);
  const haptic::DeviceChoice choice;
  const haptic::LoopSettings settings;

  properties[kPropDevice] = g_param_spec_string(
      "device", "Device",
      "auto, sim, usb, usb:ID (its rotary switch), evdev, evdev:PATH (a joystick or wheel with "
      "force feedback) or none; auto takes the first SPIDAR-G found, else the simulated one",
      choice.device.c_str(), ready);
  properties[kPropForceLaw] =
      g_param_spec_enum("force-law", "Force Law", "How motion becomes force",
                        GST_TYPE_HAPTIC_SINK_FORCE_LAW, static_cast<gint>(settings.law), playing);
  properties[kPropMaxForce] =
      g_param_spec_double("max-force", "Maximum Force", "The force that no motion exceeds, N", 0,
                          kHighestForce, settings.law_settings.max_force, playing);
  properties[kPropAlpha] = g_param_spec_double(
      "alpha", "Alpha",
      "Steepness of the force law, s/px, at a frame reference-width wide: 1/alpha px/s give half "
      "of max-force",
      0, kHighestAlpha, settings.law_settings.alpha, playing);
  properties[kPropReferenceWidth] = g_param_spec_uint(
      "reference-width", "Reference Width",
      "Frame width, px, that alpha is meant at; velocities are scaled to it (0 = native pixels)", 0,
      kWidestFrame, static_cast<guint>(settings.reference_width), playing);
  properties[kPropLatencyMode] = g_param_spec_enum(
      "latency-mode", "Latency Mode", "When a sample is felt", GST_TYPE_HAPTIC_SINK_LATENCY_MODE,
      static_cast<gint>(LatencyMode::automatic), playing);
  properties[kPropRate] = g_param_spec_uint("rate", "Rate", "Force updates per second, Hz",
                                            kLowestRate, kHighestRate, choice.rate, ready);
  properties[kPropSlewRate] =
      g_param_spec_double("slew-rate", "Slew Rate", "How fast the force may change, N/s",
                          kLowestSlewRate, kHighestSlewRate, settings.slew_rate, playing);
  properties[kPropGainWindow] = g_param_spec_double(
      "gain-window", "Gain Window",
      "With force-law=linear: the fastest motion of so many seconds gives max-force", 0.1,
      kLongestGainWindow, settings.law_settings.gain_window, playing);
  properties[kPropMaxTorque] = g_param_spec_double(
      "max-torque", "Maximum Torque", "The torque that no rotation exceeds, N·m; 0: no torque", 0,
      kHighestTorque, settings.law_settings.max_torque, playing);
  properties[kPropSpinHalf] = g_param_spec_double(
      "spin-half", "Spin Half", "The rotation that gives half of max-torque, rad/s",
      kSlowestSpinHalf, kFastestSpinHalf, settings.law_settings.spin_half, playing);
  properties[kPropMaxPush] = g_param_spec_double(
      "max-push", "Maximum Push",
      "The force towards the user that no approach exceeds, N; 0.5 1/s give half of it, 0: none", 0,
      kHighestForce, settings.law_settings.max_push, playing);
  properties[kPropDamping] = g_param_spec_double(
      "damping", "Damping",
      "Against the hand's speed above 0.1 m/s, N·s/m; never more than the force itself", 0,
      kHighestDamping, settings.damping, playing);
  properties[kPropSmoothHz] = g_param_spec_double(
      "smooth-hz", "Smooth Hz",
      "Cut-off of an additional low-pass on the motion, Hz; 12 for noisy frames, 0: none", 0,
      kHighestSmoothHz, settings.smooth_hz, playing);
  properties[kPropRateLaw] = g_param_spec_enum(
      "rate-law", "Rate Law", "What a film played slower or faster feels like",
      GST_TYPE_HAPTIC_SINK_RATE_LAW, static_cast<gint>(haptic::RateLaw::as_seen), playing);
  properties[kPropGeometry] =
      g_param_spec_string("geometry", "Geometry", "Name or file of the device's geometry",
                          choice.geometry.c_str(), ready);
  properties[kPropLogLocation] =
      g_param_spec_string("log-location", "Log Location",
                          "CSV file that gets one row per force update", nullptr, ready);
  properties[kPropSimHand] = g_param_spec_string(
      "sim-hand", "Simulated Hand",
      "What holds the simulated grip: hold:X,Y,Z, circle:RADIUS,PERIOD, file:PATH or free; X, Y, Z "
      "and RADIUS in -1..1 of the half workspace, PERIOD in s",
      choice.sim_hand.c_str(), ready);
  properties[kPropArmed] = g_param_spec_boolean(
      "armed", "Armed", "Whether the device is open and allowed to exert force", FALSE, readable);
  properties[kPropStats] =
      g_param_spec_boxed("stats", "Statistics", "Counters and timing since the last start",
                         GST_TYPE_STRUCTURE, readable);
  g_object_class_install_properties(klass, kPropCount, properties.data());
}

void install_action(GstHapticSinkClass *klass, const char *name, void (*action)(GstHapticSink *)) {
  g_signal_new_class_handler(name, G_TYPE_FROM_CLASS(klass),
                             static_cast<GSignalFlags>(G_SIGNAL_RUN_LAST | G_SIGNAL_ACTION),
                             G_CALLBACK(action), nullptr, nullptr, nullptr, G_TYPE_NONE, 0);
}

} // namespace

// ---- GObject ------------------------------------------------------------------------------------

static void gst_haptic_sink_finalize(GObject *object) {
  delete GST_HAPTIC_SINK(object)->state;
  G_OBJECT_CLASS(gst_haptic_sink_parent_class)->finalize(object);
}

static void gst_haptic_sink_class_init(GstHapticSinkClass *klass) {
  GObjectClass *object_class = G_OBJECT_CLASS(klass);
  GstElementClass *element_class = GST_ELEMENT_CLASS(klass);
  GstBaseSinkClass *sink_class = GST_BASE_SINK_CLASS(klass);

  static GstStaticPadTemplate sink_template =
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS));
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_set_static_metadata(element_class, "Haptic sink", "Sink/Haptics",
                                        "Motion in frames as force on the hand",
                                        "Feeling Wind project");

  object_class->finalize = gst_haptic_sink_finalize;
  object_class->set_property = [](GObject *object, guint id, const GValue *value,
                                  GParamSpec *pspec) {
    guarded(object, [&] { set_property(object, id, value, pspec); });
  };
  object_class->get_property = [](GObject *object, guint id, GValue *value, GParamSpec *pspec) {
    guarded(object, [&] { get_property(object, id, value, pspec); });
  };
  install_properties(object_class);

  /**
   * GstHapticSink::calibrate:
   *
   * Takes the present position of the grip as the centre of the workspace.
   */
  install_action(klass, "calibrate",
                 [](GstHapticSink *self) { guarded(self, [&] { calibrate(self); }); });
  /**
   * GstHapticSink::arm:
   *
   * Allows force again after `release` or a fault; it comes back within half a second.
   */
  install_action(klass, "arm", [](GstHapticSink *self) { guarded(self, [&] { arm(self); }); });
  /**
   * GstHapticSink::release:
   *
   * Lets go: the force fades in 50 ms and stays off until `arm`.
   */
  install_action(klass, "release",
                 [](GstHapticSink *self) { guarded(self, [&] { release(self); }); });

  element_class->change_state = [](GstElement *element, GstStateChange transition) {
    return guarded(element, GST_STATE_CHANGE_FAILURE,
                   [&] { return change_state(element, transition); });
  };
  sink_class->start = [](GstBaseSink *sink) -> gboolean {
    return guarded(sink, FALSE, [&] { return gboolean{open_device(GST_HAPTIC_SINK(sink))}; });
  };
  sink_class->stop = [](GstBaseSink *sink) -> gboolean {
    return guarded(sink, FALSE, [&] {
      close_device(GST_HAPTIC_SINK(sink));
      return TRUE;
    });
  };
  sink_class->set_caps = [](GstBaseSink *sink, GstCaps *caps) -> gboolean {
    return guarded(sink, FALSE, [&] { return set_caps(sink, caps); });
  };
  sink_class->get_times = [](GstBaseSink *sink, GstBuffer *buffer, GstClockTime *start,
                             GstClockTime *end) {
    guarded(sink, [&] { get_times(sink, buffer, start, end); });
  };
  sink_class->event = [](GstBaseSink *sink, GstEvent *e) -> gboolean {
    return guarded(sink, FALSE, [&] { return event(sink, e); });
  };
  sink_class->wait_event = [](GstBaseSink *sink, GstEvent *e) {
    return guarded(sink, GST_FLOW_ERROR, [&] { return wait_event(sink, e); });
  };
  sink_class->unlock = [](GstBaseSink *sink) -> gboolean {
    return guarded(sink, FALSE, [&] { return set_unlocked(sink, true); });
  };
  sink_class->unlock_stop = [](GstBaseSink *sink) -> gboolean {
    return guarded(sink, FALSE, [&] { return set_unlocked(sink, false); });
  };
  sink_class->render = [](GstBaseSink *sink, GstBuffer *buffer) {
    return guarded(sink, GST_FLOW_ERROR, [&] { return render(sink, buffer); });
  };

  gst_type_mark_as_plugin_api(GST_TYPE_HAPTIC_SINK_FORCE_LAW, static_cast<GstPluginAPIFlags>(0));
  gst_type_mark_as_plugin_api(GST_TYPE_HAPTIC_SINK_LATENCY_MODE, static_cast<GstPluginAPIFlags>(0));
  gst_type_mark_as_plugin_api(GST_TYPE_HAPTIC_SINK_RATE_LAW, static_cast<GstPluginAPIFlags>(0));
}

static void gst_haptic_sink_init(GstHapticSink *self) {
  self->state = new State;
  // The pipeline's latency is the largest of its sinks': this one must not add to it. Nor may a
  // slow device make the tracker skip frames.
  gst_base_sink_set_processing_deadline(GST_BASE_SINK(self), 0);
  gst_base_sink_set_qos_enabled(GST_BASE_SINK(self), FALSE);
}
