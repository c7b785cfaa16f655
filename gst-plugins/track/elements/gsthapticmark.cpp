// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-hapticmark
 *
 * Marks the haptic track behind a muxer, so that other programs copy and show the file as they
 * should. See docs/elements/hapticmark.md.
 *
 *     gst-launch-1.0 ... ! velocityavg ! hapticconvert ! meta/x-klv ! mpegtsmux ! hapticmark
 *         ! filesink location=session.ts
 *
 * Standards: ISO/IEC 13818-1 (2.4.3.7, stream_id), RFC 9559 (5.1.4.1.5, FlagDefault).
 */
#include "forms/container-mark.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/stream-lock.hpp"

#include <cstdint>
#include <gst/base/gstbasetransform.h>
#include <span>

G_DECLARE_FINAL_TYPE(GstHapticMark, gst_haptic_mark, GST, HAPTIC_MARK, GstBaseTransform)

GST_DEBUG_CATEGORY_STATIC(haptic_mark_debug);
#define GST_CAT_DEFAULT haptic_mark_debug

struct _GstHapticMark {
  GstBaseTransform parent;
  gboolean behind_header; // of Matroska; streaming thread
};

#define CONTAINERS                                                                                 \
  "video/mpegts, systemstream=(boolean)true; video/x-matroska; audio/x-matroska; "                 \
  "application/x-matroska"

G_DEFINE_TYPE_WITH_CODE(GstHapticMark, gst_haptic_mark, GST_TYPE_BASE_TRANSFORM,
                        GST_DEBUG_CATEGORY_INIT(haptic_mark_debug, "hapticmark", 0,
                                                "marks of a haptic track in a container"))
GST_ELEMENT_REGISTER_DEFINE(hapticmark, "hapticmark", GST_RANK_NONE, gst_haptic_mark_get_type())

namespace {

using haptic::kGuarded;

bool is_transport_stream(const GstCaps *caps) {
  return gst_structure_has_name(gst_caps_get_structure(caps, 0), "video/mpegts");
}

// Calls `change` with the bytes of a writable buffer. Returns false if they cannot be mapped.
template <typename Change>
bool change_bytes(GstBuffer *buffer, const Change &change) {
  GstMapInfo map;
  if (!gst_buffer_map(buffer, &map, GST_MAP_READWRITE))
    return false;
  change(std::span<std::uint8_t>(map.data, map.size));
  gst_buffer_unmap(buffer, &map);
  return true;
}

// Servers send the header of Matroska that is in the caps to who comes later.
GstCaps *fixate_caps(GstHapticMark *, GstPadDirection, GstCaps *, GstCaps *othercaps) {
  GstCaps *caps = gst_caps_fixate(othercaps);
  GstStructure *structure = gst_caps_get_structure(caps, 0);
  const GValue *headers = gst_structure_get_value(structure, "streamheader");
  if (!headers || !GST_VALUE_HOLDS_ARRAY(headers) || is_transport_stream(caps))
    return caps;
  GValue marked = G_VALUE_INIT;
  g_value_init(&marked, GST_TYPE_ARRAY);
  for (guint i = 0; i < gst_value_array_get_size(headers); ++i) {
    GstBuffer *header =
        gst_buffer_copy_deep(gst_value_get_buffer(gst_value_array_get_value(headers, i)));
    change_bytes(header, haptic::hide_text_track);
    GValue value = G_VALUE_INIT;
    g_value_init(&value, GST_TYPE_BUFFER);
    gst_value_take_buffer(&value, header);
    gst_value_array_append_and_take_value(&marked, &value);
  }
  gst_structure_take_value(structure, "streamheader", &marked);
  return caps;
}

GstFlowReturn mark(GstHapticMark *self, GstBuffer *buffer) {
  const haptic::CapsPtr caps(
      gst_pad_get_current_caps(GST_BASE_TRANSFORM_SINK_PAD(GST_BASE_TRANSFORM(self))));
  if (!caps)
    return GST_FLOW_NOT_NEGOTIATED;
  const bool is_mapped = change_bytes(buffer, [&](std::span<std::uint8_t> bytes) {
    if (is_transport_stream(caps.get()))
      haptic::keep_times_of_track(bytes);
    else if (!self->behind_header)
      self->behind_header = haptic::hide_text_track(bytes);
  });
  if (is_mapped)
    return GST_FLOW_OK;
  GST_ELEMENT_ERROR(self, RESOURCE, READ, (nullptr), ("a buffer cannot be mapped"));
  return GST_FLOW_ERROR;
}

} // namespace

static void gst_haptic_mark_init(GstHapticMark *) {}

static void gst_haptic_mark_class_init(GstHapticMarkClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "hapticmark", "Haptic track marker", "Codec/Formatter/Haptics",
                   "Marks the haptic track in MPEG-TS and Matroska for other programs", CONTAINERS,
                   CONTAINERS);
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  transform_class->stop = [](GstBaseTransform *trans) -> gboolean {
    const haptic::StreamLock stream(trans);
    GST_HAPTIC_MARK(trans)->behind_header = FALSE;
    return TRUE;
  };
  transform_class->fixate_caps = kGuarded<fixate_caps>;
  transform_class->transform_ip = kGuarded<mark>;
}
