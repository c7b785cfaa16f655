// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-pointerinject
 *
 * Sends pointers that come as a stream upstream as events. See docs/elements/pointerinject.md.
 *
 *     gst-launch-1.0 videotestsrc is-live=true ! roitracker ! pointerinject name=p ! velocityavg
 *         ! ... udpsrc port=5005 caps=... ! rtpklvdepay ! p.pointer
 *
 * Standard: SMPTE ST 336 (the local set of docs/formats/klv.md).
 */
#include "core/track-caps.hpp"
#include "elements/pad-pair.hpp"
#include "forms/klv.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"
#include "messages.hpp"
#include "network/pointer-order.hpp"

#include <chrono>
#include <gst/gst.h>
#include <utility>

G_DECLARE_FINAL_TYPE(GstPointerInject, gst_pointer_inject, GST, POINTER_INJECT, GstElement)

GST_DEBUG_CATEGORY_STATIC(pointer_inject_debug);
#define GST_CAT_DEFAULT pointer_inject_debug

namespace {

using haptic::BufferPtr;
using haptic::guarded;
using haptic::kGuarded;

struct State {
  // Set once.
  GstPad *sink = nullptr; // owned by the element

  // Streaming thread of the pad `pointer`, or while it is stopped.
  haptic::PointerOrder order;
  bool warned = false;
};

} // namespace

struct _GstPointerInject {
  GstElement parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate pointer_template = GST_STATIC_PAD_TEMPLATE(
    "pointer", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_KLV_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstPointerInject, gst_pointer_inject, GST_TYPE_ELEMENT,
                        GST_DEBUG_CATEGORY_INIT(pointer_inject_debug, "pointerinject", 0,
                                                "pointers from a stream"))
GST_ELEMENT_REGISTER_DEFINE(pointerinject, "pointerinject", GST_RANK_NONE,
                            gst_pointer_inject_get_type())

namespace {

State &state_of(gpointer object) {
  return *GST_POINTER_INJECT(object)->state;
}

void send_pointer(GstPointerInject *self, std::span<const std::uint8_t> bytes) {
  State &state = *self->state;
  const auto pointer = haptic::read_klv_pointer(bytes);
  if (!pointer) {
    if (!std::exchange(state.warned, true))
      GST_ELEMENT_WARNING(self, STREAM, FORMAT, ("%s", haptic::messages::kPointerIsDamaged),
                          ("%" G_GSIZE_FORMAT " bytes", bytes.size()));
    return;
  }
  if (!state.order.accept(pointer->sequence, std::chrono::steady_clock::now()))
    return;
  haptic::PointerPosition position;
  position.x = pointer->x;
  position.y = pointer->y;
  position.z = pointer->z;
  position.pressed = pointer->pressed;
  if (g_utf8_validate(pointer->device.data(), static_cast<gssize>(pointer->device.size()), nullptr))
    position.device = pointer->device;
  const bool handled =
      gst_pad_push_event(state.sink, haptic::make_pointer_event(position).release());
  GST_LOG_OBJECT(self, "pointer at %.3f, %.3f%s", position.x, position.y,
                 handled ? "" : ", which nobody wanted");
}

GstFlowReturn chain_pointer(GstPad *, GstObject *parent, GstBuffer *raw) {
  const BufferPtr buffer(raw);
  if (const haptic::ReadableBuffer readable(buffer.get()); readable)
    send_pointer(GST_POINTER_INJECT(parent), readable.bytes());
  return GST_FLOW_OK;
}

// The end of the pointer, or its flushing, is not that of the stream beside it.
gboolean drop_event(GstPad *, GstObject *, GstEvent *event) {
  gst_event_unref(event);
  return TRUE;
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
    State &state = state_of(element);
    state.order = {};
    state.warned = false;
  }
  return GST_ELEMENT_CLASS(gst_pointer_inject_parent_class)->change_state(element, transition);
}

void add_pads(GstPointerInject *self) {
  self->state = new State;
  self->state->sink = haptic::add_pad_pair(GST_ELEMENT(self)).sink;
  GstPad *pointer = haptic::add_lone_pad(GST_ELEMENT(self), &pointer_template);
  gst_pad_set_chain_function(pointer, kGuarded<chain_pointer>);
  gst_pad_set_event_function(pointer, kGuarded<drop_event>);
}

} // namespace

static void gst_pointer_inject_init(GstPointerInject *self) {
  guarded(self, [&] { add_pads(self); });
}

static void gst_pointer_inject_class_init(GstPointerInjectClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  G_OBJECT_CLASS(klass)->finalize =
      haptic::delete_state<GstPointerInject, gst_pointer_inject_parent_class>;
  haptic::describe(element_class, "pointerinject", "Pointer injector", "Generic/Haptics",
                   "Sends pointers that come as a stream upstream as events");
  haptic::add_pad_templates(element_class, &pointer_template);
  element_class->change_state = kGuarded<change_state>;
}
