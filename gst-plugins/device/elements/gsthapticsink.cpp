// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-hapticsink
 *
 * Lets the hand feel the motion that velocityavg or motionfield measures. This file connects
 * GStreamer to haptic::HapticSession, which does the work. See docs/elements/hapticsink.md.
 *
 * |[
 * gst-launch-1.0 videotestsrc is-live=true ! roitracker ! velocityavg ! hapticsink device=sim
 * ]|
 */
#include "elements/gsthapticsink.h"

#include "elements/call-queue.hpp"
#include "elements/presentation-time.hpp"
#include "elements/relief-pad.hpp"
#include "elements/sink-clock.hpp"
#include "elements/sink-messages.hpp"
#include "elements/sink-properties.hpp"
#include "glue/controllers.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"
#include "glue/relief-pad.hpp"
#include "samples/motion-field.hpp"
#include "session/haptic-session.hpp"
#include "share/callback-thread.hpp"
#include "share/loop-clock.hpp"

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>

GST_DEBUG_CATEGORY(haptic_sink_debug);
#define GST_CAT_DEFAULT haptic_sink_debug

namespace {

using haptic::guarded;
using haptic::kGuarded;
using haptic::ObjectLock;
using haptic::SinkSettings;

constexpr std::int64_t kMs = 1'000'000;              // ns
constexpr std::int64_t kEndFade = 150 * kMs;         // at the end of the stream, and some ticks
constexpr std::int64_t kLongestHandler = 1000 * kMs; // that the end of the stream waits for
constexpr std::int64_t kLookAtEnd = 2 * kMs;         // between two looks while it waits

enum class ReliefsBy { none, sink, relief }; // by which pad

/// Posts what the session reports.
class Client final : public haptic::SessionClient {
public:
  explicit Client(GstHapticSink *self) : self_(self) {}
  void on_notice(const haptic::Notice &notice) override;
  bool on_point(const haptic::PointerPosition &point) override;
  void on_armed_changed() override;
  void on_session_changed(const haptic::SessionStatus &status) override;
  std::optional<haptic::ClockReading> read_clocks() override;

private:
  GstHapticSink *self_;
};

// State changes that this thread is in. Elsewhere handlers are called by the queue.
thread_local int state_changes = 0;

struct InStateChange {
  InStateChange() { ++state_changes; }
  ~InStateChange() { --state_changes; }
  InStateChange(const InStateChange &) = delete;
  InStateChange &operator=(const InStateChange &) = delete;
};

struct State {
  explicit State(GstHapticSink *self)
      : client(self), session(client), calls(GST_ELEMENT(self)),
        presentation_time(GST_BASE_SINK(self), settings, session) {}

  SinkSettings settings; // the object's lock
  Client client;
  haptic::HapticSession session; // its members have their threads
  haptic::CallQueue calls;
  std::atomic<bool> armed = false; // as of the last notification
  std::atomic<int> notified_state = static_cast<int>(haptic::SessionState::closed); // the same

  // By the pad `sink` from its caps to the end of the run; by `relief` while that pad exists.
  std::atomic<ReliefsBy> reliefs_by = ReliefsBy::none;

  haptic::RequestedPad relief_pad; // has its own lock

  haptic::PresentationTime presentation_time; // streaming threads

  unsigned change = 0; // the element's state lock; number of the last state change

  unsigned stats_wanted = 0;              // the streaming thread; at the ends of the stream
  std::atomic<unsigned> stats_posted = 0; // the newest of them

  haptic::CallbackThread pointer_thread; // last: ends before what it uses
};

} // namespace

struct _GstHapticSink {
  GstBaseSink parent;
  State *state;
};

G_DEFINE_TYPE_WITH_CODE(GstHapticSink, gst_haptic_sink, GST_TYPE_BASE_SINK,
                        GST_DEBUG_CATEGORY_INIT(haptic_sink_debug, "hapticsink", 0,
                                                "motion as force on the hand"))
GST_ELEMENT_REGISTER_DEFINE(hapticsink, "hapticsink", GST_RANK_NONE, GST_TYPE_HAPTIC_SINK)

namespace {

State &state_of(gpointer object) {
  return *GST_HAPTIC_SINK(object)->state;
}

template <typename Value>
Value setting_of(gpointer object, Value SinkSettings::*member) {
  return haptic::locked_copy(object, state_of(object).settings.*member);
}

GstBaseSinkClass *parent_class() {
  return GST_BASE_SINK_CLASS(gst_haptic_sink_parent_class);
}

// The properties that follow the table's.
constexpr guint kPropArmed = 1 + haptic::kSinkProperties;
constexpr guint kPropStats = 2 + haptic::kSinkProperties;
constexpr guint kPropSessionState = 3 + haptic::kSinkProperties;
GParamSpec *armed_property = nullptr;
GParamSpec *session_state_property = nullptr;

// ---- messages -----------------------------------------------------------------------------------

// Whether `armed` has another value than at the last notification.
bool armed_has_changed(State &state) {
  const bool armed = state.session.is_armed();
  return state.armed.exchange(armed) != armed;
}

void notify_armed(GstHapticSink *self) {
  g_object_notify_by_pspec(G_OBJECT(self), armed_property);
}

void Client::on_notice(const haptic::Notice &notice) {
  if (!notice.cause) {
    GST_CAT_LEVEL_LOG(GST_CAT_DEFAULT, haptic::log_level(notice.severity), self_, "%s",
                      notice.text.c_str());
    return;
  }
  const auto post = [self = self_, notice] { haptic::post_notice(GST_ELEMENT(self), notice); };
  if (state_changes)
    post();
  else
    self_->state->calls.add(post);
}

bool Client::on_point(const haptic::PointerPosition &point) {
  const bool handled =
      gst_pad_push_event(GST_BASE_SINK_PAD(self_), haptic::make_pointer_event(point).release());
  GST_LOG_OBJECT(self_, "pointer at %.3f, %.3f%s", point.x, point.y, handled ? "" : ", not used");
  return handled;
}

void Client::on_armed_changed() {
  if (armed_has_changed(*self_->state))
    self_->state->calls.add([self = self_] { notify_armed(self); });
}

void Client::on_session_changed(const haptic::SessionStatus &status) {
  self_->state->calls.add([self = self_, status] {
    haptic::post_session(GST_ELEMENT(self), status);
    const int state = static_cast<int>(status.state);
    if (self->state->notified_state.exchange(state) != state)
      g_object_notify_by_pspec(G_OBJECT(self), session_state_property);
  });
}

std::optional<haptic::ClockReading> Client::read_clocks() {
  return haptic::read_clocks(GST_ELEMENT(self_), self_->state->session.clock());
}

haptic::Playback playback_of(const GstSegment &segment) {
  constexpr int kSkips = GST_SEGMENT_FLAG_TRICKMODE | GST_SEGMENT_FLAG_TRICKMODE_KEY_UNITS;
  return {segment.rate, segment.applied_rate, (segment.flags & kSkips) != 0};
}

// Returns false if the pad `sink` is to have reliefs, but the pad `relief` has them.
bool choose_reliefs(State &state, bool by_sink) {
  ReliefsBy before = by_sink ? ReliefsBy::none : ReliefsBy::sink;
  const ReliefsBy now = by_sink ? ReliefsBy::sink : ReliefsBy::none;
  return state.reliefs_by.compare_exchange_strong(before, now) || !by_sink || before == now;
}

// ---- states -------------------------------------------------------------------------------------

void set_running_time(GstHapticSink *self) {
  const auto reading = self->state->client.read_clocks();
  if (!reading)
    return;
  self->state->session.set_running_time(*reading);
  self->state->presentation_time.set_known(true);
}

void end_pointer_thread(GstHapticSink *self) {
  State &state = *self->state;
  state.pointer_thread.end();
  state.session.end_run();
  state.calls.drain(); // before the bus is emptied
}

bool start_threads(GstHapticSink *self) {
  State &state = *self->state;
  const auto post_status = [self](GstStreamStatusType type) {
    guarded(self, [&] { haptic::post_stream_status(GST_ELEMENT(self), type); });
  };
  const unsigned change = state.change;
  post_status(GST_STREAM_STATUS_TYPE_CREATE);
  if (state.change != change) {
    GST_WARNING_OBJECT(self, "a handler has changed the state meanwhile");
    return false;
  }
  const haptic::CallbackThread::Keeper keeper = [self] {
    return std::shared_ptr<void>(gst_object_ref(self), gst_object_unref);
  };
  const auto entered = [=] { post_status(GST_STREAM_STATUS_TYPE_ENTER); };
  if (!state.session.prepare(
          {.choice = setting_of(self, &SinkSettings::choice),
           .loop = setting_of(self, &SinkSettings::loop),
           .log_location = setting_of(self, &SinkSettings::log_location),
           .fault_location = haptic::fault_folder(setting_of(self, &SinkSettings::fault_location)),
           .callbacks = {.entered = entered, .keeper = keeper}}))
    return false;
  state.presentation_time.begin_run();
  try {
    state.session.start_loop();
    state.pointer_thread =
        haptic::CallbackThread(keeper, [self](haptic::CallbackThread::Self &thread) {
          guarded(self, [&] { self->state->session.run_rounds(thread); });
        });
  } catch (const std::system_error &) {
    state.session.stop_loop();
    state.session.end_run();
    throw;
  }
  return true;
}

// A sample comes before its frame is due, so that on a pause the next one may wait behind another
// sink that has its frame. A paused hapticsink shows nothing: it does not wait for a sample,
// neither to pause nor to go on. The base class must not call the second asynchronous: if a sample
// arrives just then, it commits PLAYING before it posts ASYNC_START, and never posts ASYNC_DONE.
GstStateChangeReturn change_parent_state(GstElement *element, GstStateChange transition) {
  const auto change = [=] {
    return GST_ELEMENT_CLASS(gst_haptic_sink_parent_class)->change_state(element, transition);
  };
  if (transition != GST_STATE_CHANGE_PLAYING_TO_PAUSED &&
      transition != GST_STATE_CHANGE_PAUSED_TO_PLAYING)
    return change();
  GstBaseSink *sink = GST_BASE_SINK(element);
  const gboolean async = gst_base_sink_is_async_enabled(sink);
  gst_base_sink_set_async_enabled(sink, FALSE);
  const GstStateChangeReturn result = change();
  gst_base_sink_set_async_enabled(sink, async);
  return result;
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  GstHapticSink *self = GST_HAPTIC_SINK(element);
  State &state = *self->state;
  const InStateChange in_state_change;
  ++state.change;
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED && !start_threads(self))
    return GST_STATE_CHANGE_FAILURE;
  if (transition == GST_STATE_CHANGE_PLAYING_TO_PAUSED)
    state.session.pause();
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) {
    state.session.stop_loop();
    // Here and not in the loop's thread, whose end this one has waited for.
    haptic::post_stream_status(element, GST_STREAM_STATUS_TYPE_LEAVE);
  }

  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED)
    state.relief_pad.set_running(true);
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY)
    state.relief_pad.set_running(false);

  const GstStateChangeReturn result = change_parent_state(element, transition);
  const bool failed = result == GST_STATE_CHANGE_FAILURE;

  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED && failed) {
    state.relief_pad.set_running(false);
    if (const haptic::PadPtr relief{gst_element_get_static_pad(element, "relief")})
      gst_pad_set_active(relief.get(), FALSE);
    state.session.stop_loop();
    end_pointer_thread(self);
  }
  if (transition == GST_STATE_CHANGE_PAUSED_TO_PLAYING && !failed) {
    set_running_time(self);
    state.session.play();
  }
  // After the parent, which ends the streaming thread: the pointer thread may be in an element that
  // waits for that thread.
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) {
    choose_reliefs(state, false);
    end_pointer_thread(self);
  }
  // The bin may be freed next, and GStreamer shut down: no message may be under way.
  if (transition == GST_STATE_CHANGE_READY_TO_NULL)
    state.calls.finish();
  return result;
}

// ---- streaming ----------------------------------------------------------------------------------

GstFlowReturn render(GstBaseSink *sink, GstBuffer *buffer) {
  GstHapticSink *self = GST_HAPTIC_SINK(sink);
  State &state = *self->state;
  set_running_time(self);
  haptic::sync_controllers(self, sink->segment, buffer);
  const std::int64_t time = state.presentation_time.of(sink->segment, GST_BUFFER_PTS(buffer));
  const bool gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP);
  const haptic::ReadableBuffer readable(buffer);
  if (state.reliefs_by == ReliefsBy::sink)
    state.session.accept_relief_alone(readable.bytes(), gap, time);
  else
    state.session.accept(readable.bytes(), gap,
                         {.time = time,
                          .playback = playback_of(sink->segment),
                          .rate_law = setting_of(self, &SinkSettings::rate_law)});
  return GST_FLOW_OK;
}

gboolean set_caps(GstBaseSink *sink, GstCaps *caps) {
  GST_DEBUG_OBJECT(sink, "%" GST_PTR_FORMAT, static_cast<void *>(caps));
  haptic::SampleIntake &intake = state_of(sink).session.intake();
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  if (!choose_reliefs(state_of(sink), gst_structure_has_name(structure, "haptics/x-field")))
    return FALSE;
  intake.set_layout(g_strcmp0(gst_structure_get_string(structure, "layout"), "field") == 0);
  gint n = 0;
  gint d = 0;
  if (gst_structure_get_fraction(structure, "framerate", &n, &d) && n > 0 && d > 0)
    intake.set_frame_duration(
        gst_util_uint64_scale(GST_SECOND, static_cast<guint64>(d), static_cast<guint64>(n)));
  return TRUE;
}

gboolean event(GstBaseSink *sink, GstEvent *event) {
  haptic::HapticSession &session = state_of(sink).session;
  const GstEventType type = GST_EVENT_TYPE(event);
  if (type == GST_EVENT_FLUSH_START) {
    state_of(sink).presentation_time.set_known(false);
    session.begin_flush();
  } else if (type == GST_EVENT_STREAM_START || type == GST_EVENT_SEGMENT) {
    session.begin_stream();
  }
  const gboolean result = parent_class()->event(sink, event);
  if (type == GST_EVENT_FLUSH_STOP)
    session.end_flush();
  return result;
}

// Reliefs come by the pad `sink` or by this one, of which there is one. Any thread.
GstPad *request_pad(GstElement *element, GstPadTemplate *of) {
  GstHapticSink *self = GST_HAPTIC_SINK(element);
  ReliefsBy none = ReliefsBy::none;
  if (!self->state->reliefs_by.compare_exchange_strong(none, ReliefsBy::relief))
    return nullptr;
  GstPad *pad = self->state->relief_pad.request(element, [&] {
    return haptic::add_relief_pad(element, of, self->state->session,
                                  self->state->presentation_time);
  });
  if (!pad)
    self->state->reliefs_by = ReliefsBy::none;
  return pad;
}

void release_pad(GstElement *element, GstPad *pad) {
  State &state = state_of(element);
  haptic::remove_relief_pad(element, pad, state.session);
  state.relief_pad.released();
  state.reliefs_by = ReliefsBy::none;
}

// The base class sends it upstream from the pad `sink` alone. Reliefs may have a source of their
// own, which comes second: what it sent before its own flush is discarded with it.
gboolean send_event(GstElement *element, GstEvent *event) {
  const haptic::EventPtr seek(GST_EVENT_TYPE(event) == GST_EVENT_SEEK ? gst_event_ref(event)
                                                                      : nullptr);
  gboolean handled = GST_ELEMENT_CLASS(gst_haptic_sink_parent_class)->send_event(element, event);
  const haptic::PadPtr relief(seek ? gst_element_get_static_pad(element, "relief") : nullptr);
  if (relief && gst_pad_is_linked(relief.get()))
    handled = gst_pad_push_event(relief.get(), gst_event_ref(seek.get())) && handled;
  return handled;
}

// Waits until the condition holds, for at most `limit` ns, without the preroll lock, which every
// state change needs. PAUSED suspends the wait, a flush or READY ends it.
template <typename Condition>
GstFlowReturn wait_at_end(GstBaseSink *sink, std::int64_t limit, const Condition &condition) {
  haptic::LoopClock &clock = state_of(sink).session.clock();
  const std::int64_t deadline = clock.now() + limit;
  while (!condition() && clock.now() < deadline) {
    GST_BASE_SINK_PREROLL_UNLOCK(sink);
    clock.wait_until(clock.now() + kLookAtEnd);
    GST_BASE_SINK_PREROLL_LOCK(sink);
    if (sink->flushing)
      return GST_FLOW_FLUSHING;
    if (!sink->need_preroll)
      continue;
    if (const GstFlowReturn result = gst_base_sink_wait_preroll(sink); result != GST_FLOW_OK)
      return result;
  }
  return GST_FLOW_OK;
}

// The force is zero before the EOS message is posted, because programs then end the pipeline.
GstFlowReturn fade_at_end(GstBaseSink *sink) {
  haptic::HapticSession &session = state_of(sink).session;
  session.end_stream();
  return wait_at_end(sink, kEndFade, [&] { return session.silent(); });
}

// Before the EOS message, but from another thread: a handler may change the state. After a seek the
// handler of an earlier end may still run: each end waits for its own.
GstFlowReturn post_stats(GstHapticSink *self) {
  State &state = *self->state;
  const unsigned number = ++state.stats_wanted;
  state.calls.add([self, number] {
    haptic::post_stats(GST_ELEMENT(self), self->state->session);
    self->state->stats_posted = number;
  });
  return wait_at_end(GST_BASE_SINK(self), kLongestHandler,
                     [&] { return state.stats_posted == number; });
}

GstFlowReturn wait_event(GstBaseSink *sink, GstEvent *event) {
  GstHapticSink *self = GST_HAPTIC_SINK(sink);
  haptic::HapticSession &session = self->state->session;
  const bool gap = GST_EVENT_TYPE(event) == GST_EVENT_GAP;
  GstFlowReturn result = gap && self->state->presentation_time.is_immediate()
                             ? gst_base_sink_do_preroll(sink, GST_MINI_OBJECT_CAST(event))
                             : parent_class()->wait_event(sink, event);
  if (result != GST_FLOW_OK)
    return result;
  if (gap) {
    GstClockTime pts = GST_CLOCK_TIME_NONE;
    gst_event_parse_gap(event, &pts, nullptr);
    const std::int64_t time = self->state->presentation_time.of(sink->segment, pts);
    if (self->state->reliefs_by == ReliefsBy::sink)
      session.accept_relief({}, true, time);
    else
      session.accept_gap(time);
  }
  if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) {
    result = fade_at_end(sink);
    if (result == GST_FLOW_OK)
      result = post_stats(self);
  }
  return result;
}

// ---- properties and signals ---------------------------------------------------------------------

void set_property(GObject *object, guint id, const GValue *value) {
  State &state = state_of(object);
  const ObjectLock lock(object);
  haptic::sink_properties()[id - 1].set(state.settings, value);
  state.session.set_settings(state.settings.loop);
}

void get_property(GObject *object, guint id, GValue *value) {
  State &state = state_of(object);
  if (id == kPropStats) {
    g_value_take_boxed(value, haptic::make_stats(state.session).release());
  } else if (id == kPropArmed) {
    g_value_set_boolean(value, state.session.is_armed());
  } else if (id == kPropSessionState) {
    g_value_set_enum(value, static_cast<gint>(state.session.state()));
  } else {
    const ObjectLock lock(object);
    haptic::sink_properties()[id - 1].get(state.settings, value);
  }
}

void install_properties(GObjectClass *klass) {
  klass->set_property = kGuarded<set_property>;
  klass->get_property = kGuarded<get_property>;
  guint id = 0;
  for (const auto &row : haptic::sink_properties())
    g_object_class_install_property(klass, ++id, row.spec);
  armed_property = g_param_spec_boolean("armed", "Armed",
                                        "Whether the device is open and allowed to exert force",
                                        FALSE, haptic::kReadOnly);
  g_object_class_install_property(klass, kPropArmed, armed_property);
  g_object_class_install_property(klass, kPropStats,
                                  g_param_spec_boxed("stats", "Statistics",
                                                     "Counters and timing since the last start",
                                                     GST_TYPE_STRUCTURE, haptic::kReadOnly));
  session_state_property =
      g_param_spec_enum("session-state", "Session State", "Whether and why a force is possible",
                        haptic::session_state_type(),
                        static_cast<gint>(haptic::SessionState::closed), haptic::kReadOnly);
  g_object_class_install_property(klass, kPropSessionState, session_state_property);
}

template <void (haptic::HapticSession::*kAction)()>
void change_armed(GstHapticSink *self) {
  (self->state->session.*kAction)();
  if (armed_has_changed(*self->state))
    notify_armed(self);
}

void install_action(GObjectClass *klass, const char *name, void (*action)(GstHapticSink *)) {
  g_signal_new_class_handler(name, G_TYPE_FROM_CLASS(klass),
                             static_cast<GSignalFlags>(G_SIGNAL_RUN_LAST | G_SIGNAL_ACTION),
                             G_CALLBACK(action), nullptr, nullptr, nullptr, G_TYPE_NONE, 0);
}

void install_actions(GObjectClass *klass) {
  /**
   * GstHapticSink::calibrate:
   *
   * Makes the present position of the grip the centre of the workspace.
   */
  install_action(klass, "calibrate",
                 kGuarded<[](GstHapticSink *self) { self->state->session.calibrate(); }>);
  /**
   * GstHapticSink::arm:
   *
   * Allows force again after `release` or a fault; it comes back within half a second.
   */
  install_action(klass, "arm", kGuarded<change_armed<&haptic::HapticSession::arm>>);
  /**
   * GstHapticSink::release:
   *
   * The force fades in 50 ms and stays off until `arm`.
   */
  install_action(klass, "release", kGuarded<change_armed<&haptic::HapticSession::release>>);
}

// ---- virtual functions --------------------------------------------------------------------------

void install_sink_functions(GstBaseSinkClass *klass) {
  klass->start = kGuarded<[](GstBaseSink *sink) {
    State &state = state_of(sink);
    const bool opened = state.session.open(setting_of(sink, &SinkSettings::choice));
    state.client.on_armed_changed();
    return gboolean{opened};
  }>;
  klass->stop = kGuarded<[](GstBaseSink *sink) {
    State &state = state_of(sink);
    state.session.close();
    state.client.on_armed_changed();
    return TRUE;
  }>;
  klass->set_caps = kGuarded<set_caps>;
  klass->get_times = [](GstBaseSink *sink, GstBuffer *buffer, GstClockTime *start,
                        GstClockTime *end) {
    guarded(sink, [&] {
      *start = *end = GST_CLOCK_TIME_NONE;
      haptic::PresentationTime &time = state_of(sink).presentation_time;
      if (time.is_immediate())
        return; // nothing to wait for
      parent_class()->get_times(sink, buffer, start, end);
      time.look_ahead(*start, *end);
    });
  };
  klass->event = kGuarded<event>;
  klass->wait_event = kGuarded<wait_event>;
  klass->render = kGuarded<render>;
}

} // namespace

void haptic::set_clock(GstHapticSink *sink, LoopClock &clock) {
  sink->state->session.set_clock(clock);
}

static void gst_haptic_sink_class_init(GstHapticSinkClass *klass) {
  GstElementClass *element_class = GST_ELEMENT_CLASS(klass);
  gst_element_class_add_pad_template(element_class, haptic::relief_pad_template());
  element_class->request_new_pad = kGuarded<request_pad>;
  element_class->release_pad = kGuarded<release_pad>;
  element_class->send_event = kGuarded<send_event>;
  haptic::describe(element_class, "hapticsink", "Haptic sink", "Sink/Haptics",
                   "Motion in frames as force on the hand",
                   HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS "; " HAPTIC_RELIEF_CAPS);
  element_class->change_state = kGuarded<change_state>;
  G_OBJECT_CLASS(klass)->finalize =
      haptic::delete_state<GstHapticSink, gst_haptic_sink_parent_class>;
  install_properties(G_OBJECT_CLASS(klass));
  install_actions(G_OBJECT_CLASS(klass));
  install_sink_functions(GST_BASE_SINK_CLASS(klass));
}

static void gst_haptic_sink_init(GstHapticSink *self) {
  self->state = new State(self);
  // The pipeline's latency is the largest of its sinks': this one must not add to it. Nor may a
  // slow device make the tracker skip frames.
  gst_base_sink_set_processing_deadline(GST_BASE_SINK(self), 0);
  gst_base_sink_set_qos_enabled(GST_BASE_SINK(self), FALSE);
}
