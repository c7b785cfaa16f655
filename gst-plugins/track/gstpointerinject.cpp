// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-pointerinject
 *
 * Sends pointers that come as a stream upstream as events. See docs/elements/pointerinject.md.
 */
#include "gstpointerinject.h"

#include "exception-barrier.hpp"
#include "gst-raii.hpp"
#include "klv.hpp"
#include "pad-pair.hpp"
#include "pointer-event.hpp"
#include "track-caps.hpp"

#include <chrono>
#include <optional>
#include <utility>

GST_DEBUG_CATEGORY_STATIC(pointer_inject_debug);
#define GST_CAT_DEFAULT pointer_inject_debug

namespace {

using haptic::BufferPtr;
using haptic::guarded;

// The far end sends every 200 ms at least; who was silent for longer may have been started anew.
constexpr std::chrono::seconds kForgotten{1};

struct State {
  // Pads of the element, set once.
  GstPad *sink = nullptr;
  GstPad *src = nullptr;
  GstPad *pointer = nullptr;

  // Streaming thread of the pad `pointer`, or while it is stopped.
  std::optional<std::uint32_t> sequence;
  std::chrono::steady_clock::time_point arrived;
  bool told = false;
};

} // namespace

struct _GstPointerInject {
  GstElement parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
static GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
static GstStaticPadTemplate pointer_template = GST_STATIC_PAD_TEMPLATE(
    "pointer", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_KLV_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstPointerInject, gst_pointer_inject, GST_TYPE_ELEMENT,
                        GST_DEBUG_CATEGORY_INIT(pointer_inject_debug, "pointerinject", 0,
                                                "pointers from a stream"))
GST_ELEMENT_REGISTER_DEFINE(pointerinject, "pointerinject", GST_RANK_NONE, GST_TYPE_POINTER_INJECT)

namespace {

State &state_of(gpointer object) {
  return *GST_POINTER_INJECT(object)->state;
}

// Packets overtake each other; an older pointer must not undo a newer one.
bool is_newer(State &state, std::uint32_t sequence) {
  const auto now = std::chrono::steady_clock::now();
  const bool newer = !state.sequence || now - state.arrived > kForgotten ||
                     static_cast<std::int32_t>(sequence - *state.sequence) > 0;
  if (newer) {
    state.sequence = sequence;
    state.arrived = now;
  }
  return newer;
}

void take_pointer(GstPointerInject *self, std::span<const std::uint8_t> bytes) {
  State &state = *self->state;
  const auto pointer = haptic::read_klv_pointer(bytes);
  if (!pointer) {
    if (!std::exchange(state.told, true))
      GST_ELEMENT_WARNING(self, STREAM, FORMAT,
                          ("A buffer at the pad pointer is not a pointer, or is damaged; it was "
                           "passed over. The pad wants what pointerextract makes."),
                          ("%" G_GSIZE_FORMAT " bytes", bytes.size()));
    return;
  }
  if (!is_newer(state, pointer->sequence))
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
  return guarded(parent, GST_FLOW_ERROR, [&] {
    GstMapInfo map;
    if (gst_buffer_map(buffer.get(), &map, GST_MAP_READ)) {
      take_pointer(GST_POINTER_INJECT(parent), {map.data, map.size});
      gst_buffer_unmap(buffer.get(), &map);
    }
    return GST_FLOW_OK;
  });
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
    State &state = state_of(element);
    state.sequence.reset();
    state.told = false;
  }
  return GST_ELEMENT_CLASS(gst_pointer_inject_parent_class)->change_state(element, transition);
}

} // namespace

static void gst_pointer_inject_finalize(GObject *object) {
  delete GST_POINTER_INJECT(object)->state;
  G_OBJECT_CLASS(gst_pointer_inject_parent_class)->finalize(object);
}

static void gst_pointer_inject_init(GstPointerInject *self) {
  self->state = new State;
  State &state = *self->state;
  state.sink = gst_pad_new_from_static_template(&sink_template, "sink");
  state.src = gst_pad_new_from_static_template(&src_template, "src");
  state.pointer = gst_pad_new_from_static_template(&pointer_template, "pointer");
  gst_pad_set_chain_function(state.sink, [](GstPad *, GstObject *parent, GstBuffer *buffer) {
    return gst_pad_push(state_of(parent).src, buffer);
  });
  gst_pad_set_chain_function(state.pointer, chain_pointer);
  // The end of the pointer, or its flushing, is not that of the stream.
  gst_pad_set_event_function(state.pointer, [](GstPad *, GstObject *, GstEvent *event) -> gboolean {
    gst_event_unref(event);
    return TRUE;
  });
  haptic::link_inside(state.sink, state.src);
  haptic::link_nothing(state.pointer);
  gst_element_add_pad(GST_ELEMENT(self), state.sink);
  gst_element_add_pad(GST_ELEMENT(self), state.src);
  gst_element_add_pad(GST_ELEMENT(self), state.pointer);
}

static void gst_pointer_inject_class_init(GstPointerInjectClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  G_OBJECT_CLASS(klass)->finalize = gst_pointer_inject_finalize;
  gst_element_class_set_static_metadata(element_class, "Pointer injector", "Generic/Haptics",
                                        "Sends pointers that come as a stream upstream as events",
                                        "Feeling Wind project");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);
  gst_element_class_add_static_pad_template(element_class, &pointer_template);
  element_class->change_state = [](GstElement *element, GstStateChange transition) {
    return guarded(element, GST_STATE_CHANGE_FAILURE,
                   [&] { return change_state(element, transition); });
  };
}
