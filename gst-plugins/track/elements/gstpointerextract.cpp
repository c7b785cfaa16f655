// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-pointerextract
 *
 * Makes a stream of the pointer events that come upstream. See docs/elements/pointerextract.md.
 *
 *     gst-launch-1.0 udpsrc port=5004 caps=... ! ... ! pointerextract name=p
 *         ! hapticsink device=sim p.pointer ! rtpklvpay ! udpsink port=5005 async=false
 *
 * Standard: SMPTE ST 336 (the local set of docs/formats/klv.md).
 */
#include "core/track-buffer.hpp"
#include "core/track-caps.hpp"
#include "elements/pad-pair.hpp"
#include "forms/klv.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"

#include <condition_variable>
#include <gst/gst.h>
#include <mutex>
#include <optional>
#include <utility>

G_DECLARE_FINAL_TYPE(GstPointerExtract, gst_pointer_extract, GST, POINTER_EXTRACT, GstElement)

GST_DEBUG_CATEGORY_STATIC(pointer_extract_debug);
#define GST_CAT_DEFAULT pointer_extract_debug

namespace {

using haptic::BufferPtr;
using haptic::guarded;
using haptic::kGuarded;
using haptic::PointerPosition;

struct State {
  // Set once.
  GstPad *pointer = nullptr; // owned by the element

  // The mutex. The pointer has a thread of its own: events come from threads that must not wait for
  // a network.
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<PointerPosition> newest;
  guint group = GST_GROUP_ID_INVALID; // of the stream beside the pointer, once it has begun
  bool ended = false;
  bool stopping = false;

  // The pointer's thread, or while it is stopped.
  bool begun = false;
  bool had_end = false;
  std::uint32_t sequence = 0;
};

} // namespace

struct _GstPointerExtract {
  GstElement parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate pointer_template = GST_STATIC_PAD_TEMPLATE(
    "pointer", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_KLV_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstPointerExtract, gst_pointer_extract, GST_TYPE_ELEMENT,
                        GST_DEBUG_CATEGORY_INIT(pointer_extract_debug, "pointerextract", 0,
                                                "pointer events as a stream"))
GST_ELEMENT_REGISTER_DEFINE(pointerextract, "pointerextract", GST_RANK_NONE,
                            gst_pointer_extract_get_type())

namespace {

State &state_of(gpointer object) {
  return *GST_POINTER_EXTRACT(object)->state;
}

void begin_stream(GstPointerExtract *self, guint group) {
  State &state = *self->state;
  if (std::exchange(state.begun, true))
    return;
  // A sink that has had the end takes nothing more before a flush.
  if (std::exchange(state.had_end, false)) {
    gst_pad_push_event(state.pointer, gst_event_new_flush_start());
    gst_pad_push_event(state.pointer, gst_event_new_flush_stop(FALSE));
  }
  const haptic::GCharPtr id(gst_pad_create_stream_id(state.pointer, GST_ELEMENT(self), "pointer"));
  GstEvent *start = gst_event_new_stream_start(id.get());
  gst_event_set_stream_flags(start, GST_STREAM_FLAG_SPARSE);
  gst_event_set_group_id(start, group != GST_GROUP_ID_INVALID ? group : gst_util_group_id_next());
  gst_pad_push_event(state.pointer, start);
  const haptic::CapsPtr caps(gst_caps_from_string(HAPTIC_KLV_CAPS));
  gst_pad_push_event(state.pointer, gst_event_new_caps(caps.get()));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_pad_push_event(state.pointer, gst_event_new_segment(&segment));
}

GstClockTime running_time(GstPointerExtract *self) {
  GstClock *clock = gst_element_get_clock(GST_ELEMENT(self));
  if (!clock)
    return 0;
  const GstClockTime now = gst_clock_get_time(clock);
  const GstClockTime base = gst_element_get_base_time(GST_ELEMENT(self));
  gst_object_unref(clock);
  return GST_CLOCK_TIME_IS_VALID(base) && now > base ? now - base : 0;
}

GstFlowReturn push_pointer(GstPointerExtract *self, const PointerPosition &position) {
  State &state = *self->state;
  const auto bytes = haptic::write_klv(haptic::TrackPointer{
      state.sequence++, position.x, position.y, position.z, position.pressed, position.device});
  BufferPtr buffer = haptic::make_buffer(bytes, running_time(self), GST_CLOCK_TIME_NONE);
  return gst_pad_push(state.pointer, buffer.release());
}

// Sends the newest pointer, or the end, once there is one. The stream begins with the one beside
// it: a pipeline has begun when all its streams have, and a hand may not point for long. The
// pointer's thread.
void send_next(GstPointerExtract *self) {
  State &state = *self->state;
  std::optional<PointerPosition> position;
  guint group = GST_GROUP_ID_INVALID;
  bool ends = false;
  {
    std::unique_lock lock(state.mutex);
    state.changed.wait(lock, [&] {
      return state.newest || state.ended || state.stopping ||
             (!state.begun && state.group != GST_GROUP_ID_INVALID);
    });
    if (state.stopping) {
      gst_pad_pause_task(state.pointer);
      return;
    }
    position = std::exchange(state.newest, std::nullopt);
    group = state.group;
    ends = !position && state.ended;
    if (ends) // before another stream may start the task again
      gst_pad_pause_task(state.pointer);
  }
  begin_stream(self, group);
  if (ends) {
    gst_pad_push_event(state.pointer, gst_event_new_eos());
    state.begun = false; // another stream may follow
    state.had_end = true;
  }
  if (!position)
    return;
  const GstFlowReturn result = push_pointer(self, *position);
  if (result == GST_FLOW_OK || result == GST_FLOW_NOT_LINKED)
    return;
  GST_INFO_OBJECT(self, "the pointer cannot be sent any more: %s", gst_flow_get_name(result));
  gst_pad_pause_task(state.pointer);
  if (result < GST_FLOW_EOS)
    GST_ELEMENT_FLOW_ERROR(self, result);
}

gboolean start_task(GstPad *pointer, GstObject *parent) {
  return gst_pad_start_task(
      pointer,
      [](gpointer data) {
        auto *self = GST_POINTER_EXTRACT(data);
        guarded(self, [&] { send_next(self); });
      },
      parent, nullptr);
}

gboolean activate_pointer(GstPad *pad, GstObject *parent, gboolean active) {
  State &state = state_of(parent);
  {
    const std::lock_guard lock(state.mutex);
    state.stopping = !active;
    if (active) {
      state.newest.reset();
      state.group = GST_GROUP_ID_INVALID;
      state.ended = false;
      state.begun = false;
      state.had_end = false;
      state.sequence = 0;
    }
  }
  state.changed.notify_all();
  if (!active)
    return gst_pad_stop_task(pad);
  return start_task(pad, parent);
}

gboolean src_event(GstPad *pad, GstObject *parent, GstEvent *event) {
  State &state = state_of(parent);
  if (const auto position = haptic::parse_pointer_event(event)) {
    {
      const std::lock_guard lock(state.mutex);
      state.newest = *position;
    }
    state.changed.notify_all();
    gst_event_unref(event);
    return TRUE;
  }
  return gst_pad_event_default(pad, parent, event);
}

gboolean sink_event(GstPad *pad, GstObject *parent, GstEvent *event) {
  State &state = state_of(parent);
  if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) {
    {
      const std::lock_guard lock(state.mutex);
      state.ended = true;
    }
    state.changed.notify_all();
  }
  if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START ||
      GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) {
    std::unique_lock lock(state.mutex);
    if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START &&
        !gst_event_parse_group_id(event, &state.group))
      state.group = gst_util_group_id_next();
    const bool begins_again = std::exchange(state.ended, false);
    lock.unlock();
    state.changed.notify_all();
    if (begins_again)
      start_task(state.pointer, parent);
  }
  return gst_pad_event_default(pad, parent, event);
}

// The latency is 0: the time stamps are those of now, whatever the stream beside it needs.
gboolean pointer_query(GstPad *pad, GstObject *parent, GstQuery *query) {
  if (GST_QUERY_TYPE(query) == GST_QUERY_LATENCY) {
    gst_query_set_latency(query, TRUE, 0, GST_CLOCK_TIME_NONE);
    return TRUE;
  }
  return gst_pad_query_default(pad, parent, query);
}

// Events from downstream end here: nobody upstream makes this stream. A seek of the pipeline is not
// refused: these times are those of now.
gboolean drop_event(GstPad *, GstObject *, GstEvent *event) {
  const bool is_seek = GST_EVENT_TYPE(event) == GST_EVENT_SEEK;
  gst_event_unref(event);
  return is_seek;
}

void add_pads(GstPointerExtract *self) {
  self->state = new State;
  State &state = *self->state;
  const haptic::PadPair pads = haptic::add_pad_pair(GST_ELEMENT(self));
  state.pointer = haptic::add_lone_pad(GST_ELEMENT(self), &pointer_template);
  gst_pad_set_event_function(pads.sink, kGuarded<sink_event>);
  gst_pad_set_event_function(pads.src, kGuarded<src_event>);
  gst_pad_set_query_function(state.pointer, kGuarded<pointer_query>);
  gst_pad_set_event_function(state.pointer, kGuarded<drop_event>);
  gst_pad_set_activatemode_function(
      state.pointer,
      [](GstPad *pad, GstObject *parent, GstPadMode mode, gboolean active) -> gboolean {
        return mode == GST_PAD_MODE_PUSH &&
               guarded(parent, FALSE, [&] { return activate_pointer(pad, parent, active); });
      });
}

} // namespace

static void gst_pointer_extract_init(GstPointerExtract *self) {
  guarded(self, [&] { add_pads(self); });
}

static void gst_pointer_extract_class_init(GstPointerExtractClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  G_OBJECT_CLASS(klass)->finalize =
      haptic::delete_state<GstPointerExtract, gst_pointer_extract_parent_class>;
  haptic::describe(element_class, "pointerextract", "Pointer extractor", "Generic/Haptics",
                   "Makes a stream of the pointer events that come upstream");
  haptic::add_pad_templates(element_class, &pointer_template);
}
