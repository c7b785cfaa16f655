// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/copied-stream.hpp"

#include "film/pipeline.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

namespace haptic {
namespace {

constexpr char kAv1[] = "video/x-av1";
constexpr char kDnxhd[] = "video/x-dnxhd";
constexpr char kHuffyuv[] = "video/x-huffyuv";
constexpr char kText[] = "text/x-raw";
constexpr char kPlainText[] = "text/x-raw,format=utf8";
// MPEG-TS has no registered place for the first two, though mpegtsmux of GStreamer 1.26 has one.
constexpr std::string_view kOnlyInMatroska[] = {kAv1, "video/x-vp9", kDnxhd};
constexpr guint8 kAv1Marker = 0x81; // first byte of an AV1CodecConfigurationRecord

// Returns the parser that converts between the forms of the stream, or nothing.
const char *parser_of(const GstCaps *caps) {
  constexpr std::array<std::pair<const char *, const char *>, 3> kParsers = {
      {{kAv1, "av1parse"}, {"video/x-h264", "h264parse"}, {"video/x-h265", "h265parse"}}};
  for (const auto &[name, parser] : kParsers)
    if (g_str_equal(name_of(caps), name))
      return parser;
  gint version = 0;
  gst_structure_get_int(gst_caps_get_structure(caps, 0), "mpegversion", &version);
  return g_str_equal(name_of(caps), "audio/mpeg") && version > 1 ? "aacparse" : nullptr;
}

// Returns the caps without the fields that a parser can change.
CapsPtr without_form(GstCaps *caps) {
  CapsPtr essence(gst_caps_copy(caps));
  for (guint i = 0; i < gst_caps_get_size(essence.get()); ++i)
    for (const char *field : {"stream-format", "alignment", "codec_data", "framed", "parsed"})
      gst_structure_remove_field(gst_caps_get_structure(essence.get(), i), field);
  return essence;
}

// Matroska has one time for each frame. Where AVI gives only the decoding time, that is the one, as
// in other files of these codecs.
void complete_time(GstPad *, GstBuffer *&buffer) {
  if (GST_BUFFER_PTS_IS_VALID(buffer) || !GST_BUFFER_DTS_IS_VALID(buffer))
    return;
  buffer = gst_buffer_make_writable(buffer);
  GST_BUFFER_PTS(buffer) = GST_BUFFER_DTS(buffer);
}

// qtdemux of GStreamer 1.22 cuts the head of AV1's codec data off, and a decoder refuses the rest.
// Each key frame has the same data.
void leave_cut_data_out(GstPad *, GstEvent *&event) {
  const GstCaps *caps = caps_in(event);
  if (!caps || !g_str_equal(name_of(caps), kAv1))
    return;
  const GValue *value = gst_structure_get_value(gst_caps_get_structure(caps, 0), "codec_data");
  guint8 marker = kAv1Marker;
  if (value)
    gst_buffer_extract(gst_value_get_buffer(value), 0, &marker, 1);
  if (marker == kAv1Marker)
    return;
  const CapsPtr whole(gst_caps_copy(caps));
  gst_structure_remove_field(gst_caps_get_structure(whole.get(), 0), "codec_data");
  gst_event_unref(std::exchange(event, gst_event_new_caps(whole.get())));
}

// matroskademux names the text of subtitles Pango's markup and escapes what would be none. They go
// back as they were.
void unescape(GstPad *, GstBuffer *&buffer) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};
  edit_buffer<std::string>(buffer, [&](std::string &text) {
    for (std::size_t at = text.find('&'); at != text.npos; at = text.find('&', at + 1))
      for (const auto &[entity, character] : kEntities)
        if (text.compare(at, entity.size(), entity) == 0) {
          text.replace(at, entity.size(), 1, character);
          break;
        }
  });
}

// Before its first frame, aacparse knows neither rate nor profile, and a muxer needs them.
bool is_unknown_aac(const GstCaps *caps) {
  return g_strcmp0(parser_of(caps), "aacparse") == 0 &&
         !gst_structure_has_field(gst_caps_get_structure(caps, 0), "rate");
}

// tsdemux sends gaps until a stream begins, in GStreamer 1.22 the first one before a segment.
// The muxer gets nothing that it cannot place, and waits for the first frame instead.
bool has_time_and_form(GstPad *pad, GstEvent *event) {
  if (const GstCaps *caps = caps_in(event))
    return !is_unknown_aac(caps);
  return GST_EVENT_TYPE(event) != GST_EVENT_GAP ||
         (segment_of(pad) && !is_unknown_aac(caps_of(pad).get()));
}

// matroskamux has no name for DNxHD. It writes such a stream as HuffYUV, and this puts the name
// there by which others know DNxHD in V_MS/VFW/FOURCC.
void name_dnxhd(GstElement *mux) {
  const auto name_once = [is_named = false](GstPad *, GstBuffer *&buffer) mutable {
    if (is_named)
      return;
    edit_buffer<std::string>(buffer, [&](std::string &bytes) {
      if (const std::size_t at = bytes.find("HFYU"); at != bytes.npos) {
        bytes.replace(at, 4, "AVdn");
        is_named = true;
      }
    });
  };
  watch_buffers(PadPtr(gst_element_get_static_pad(mux, "src")).get(), name_once);
}

} // namespace

const char *name_of(const GstCaps *caps) {
  return gst_structure_get_name(gst_caps_get_structure(caps, 0));
}

CapsPtr caps_of(GstPad *pad) {
  CapsPtr caps(gst_pad_get_current_caps(pad));
  return caps ? std::move(caps) : CapsPtr(gst_pad_query_caps(pad, nullptr));
}

FrameSize size_in(const GstCaps *caps) {
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  FrameSize size;
  return gst_structure_get_int(structure, "width", &size.width) &&
                 gst_structure_get_int(structure, "height", &size.height)
             ? size
             : FrameSize{};
}

bool has_place(const char *mux, GstPad *pad) {
  const CapsPtr caps = without_form(caps_of(pad).get());
  const std::unique_ptr<GstElementFactory, decltype(&gst_object_unref)> factory(
      gst_element_factory_find(mux), gst_object_unref);
  // matroskamux accepts these caps and then refuses the stream.
  if (g_str_equal(name_of(caps.get()), "application/x-subtitle-unknown"))
    return false;
  if (std::ranges::find(kOnlyInMatroska, name_of(caps.get())) != std::end(kOnlyInMatroska) &&
      !g_str_equal(mux, "matroskamux"))
    return false;
  if (g_str_equal(name_of(caps.get()), kDnxhd))
    gst_structure_set_name(gst_caps_get_structure(caps.get(), 0), kHuffyuv);
  if (g_str_equal(name_of(caps.get()), kText))
    gst_caps_set_simple(caps.get(), "format", G_TYPE_STRING, "utf8", nullptr);
  return factory && gst_element_factory_can_sink_any_caps(factory.get(), caps.get());
}

GstElement *add_queue(GstElement *pipeline, guint bytes) {
  GstElement *queue = add_element(pipeline, "queue");
  g_object_set(queue, "max-size-bytes", bytes, "max-size-buffers", 0, "max-size-time", guint64{0},
               nullptr);
  return queue;
}

GstElement *add_muxer(GstElement *pipeline, const char *factory, const std::string &path) {
  GstElement *mux = add_element(pipeline, factory);
  GstElement *mark = add_element(pipeline, "hapticmark");
  GstElement *sink = add_element(pipeline, "filesink");
  g_object_set(sink, "location", path.c_str(), "async", FALSE, nullptr);
  link_elements(mux, mark);
  link_elements(mark, sink);
  return mux;
}

void link_elements(GstElement *from, GstElement *to) {
  if (!gst_element_link(from, to))
    throw_error(messages::kStreamDoesNotFit, GST_ELEMENT_NAME(from), GST_ELEMENT_NAME(to));
}

void link_pad(GstPad *pad, GstElement *to) {
  const PadPtr sink(gst_element_get_static_pad(to, "sink"));
  if (!gst_pad_link_maybe_ghosting(pad, sink.get()))
    throw_error(messages::kStreamDoesNotFit, GST_PAD_NAME(pad), GST_ELEMENT_NAME(to));
}

PadPtr copy_stream(GstPad *pad, guint queue_bytes, gint64 offset, GstElement *mux,
                   bool is_matroska) {
  const ElementPtr pipeline(GST_ELEMENT(gst_element_get_parent(mux)));
  GstElement *queue = add_queue(pipeline.get(), queue_bytes);
  gst_pad_set_offset(PadPtr(gst_element_get_static_pad(queue, "src")).get(), offset);
  const CapsPtr held = caps_of(pad);
  GstCaps *caps = held.get();
  const char *parser = parser_of(caps);
  GstElement *last = parser ? add_element(pipeline.get(), parser) : queue;
  CapsPtr form(parser ? nullptr : gst_caps_ref(caps));
  const bool is_text = g_str_equal(name_of(caps), kText);
  if (is_text || g_str_equal(name_of(caps), kDnxhd)) { // see name_dnxhd()
    last = add_element(pipeline.get(), "capssetter");
    form.reset(gst_caps_from_string(is_text ? kPlainText : kHuffyuv));
    g_object_set(last, "caps", form.get(), "join", FALSE, nullptr);
    if (!is_text)
      name_dnxhd(mux);
  }
  if (last != queue)
    link_elements(queue, last);
  // A receiver may begin at any IDR frame.
  if (!is_matroska && g_object_class_find_property(G_OBJECT_GET_CLASS(last), "config-interval"))
    g_object_set(last, "config-interval", -1, nullptr);
  PadPtr from_pad(gst_element_get_static_pad(last, "src"));
  if (is_matroska)
    watch_buffers(from_pad.get(), complete_time);
  const char *format = gst_structure_get_string(gst_caps_get_structure(caps, 0), "format");
  if (is_text && g_strcmp0(format, "pango-markup") == 0)
    watch_buffers(from_pad.get(), unescape);
  watch_events(from_pad.get(), has_time_and_form);
  const PadPtr to_pad(gst_element_get_compatible_pad(mux, from_pad.get(), form.get()));
  if (to_pad && is_matroska)
    watch_events(to_pad.get(), leave_cut_data_out);
  if (!to_pad || GST_PAD_LINK_FAILED(gst_pad_link(from_pad.get(), to_pad.get())))
    throw_error(messages::kMuxerHasNoPlace, name_of(caps));
  link_pad(pad, queue);
  return from_pad;
}

void begin_earlier(GstPad *pad, std::uint64_t by) {
  watch_events(PadPtr(gst_pad_get_peer(pad)).get(), [by](GstPad *, GstEvent *&event) {
    if (GST_EVENT_TYPE(event) != GST_EVENT_SEGMENT)
      return;
    GstSegment segment;
    gst_event_copy_segment(event, &segment);
    segment.start -= std::min(segment.start, by);
    const EventPtr before(std::exchange(event, gst_event_new_segment(&segment)));
    gst_event_set_seqnum(event, gst_event_get_seqnum(before.get()));
  });
}

} // namespace haptic
