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
GstPadProbeReturn complete_time(GstPad *, GstPadProbeInfo *info, gpointer) {
  GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  if (GST_BUFFER_PTS_IS_VALID(buffer) || !GST_BUFFER_DTS_IS_VALID(buffer))
    return GST_PAD_PROBE_OK;
  buffer = gst_buffer_make_writable(buffer);
  GST_BUFFER_PTS(buffer) = GST_BUFFER_DTS(buffer);
  GST_PAD_PROBE_INFO_DATA(info) = buffer;
  return GST_PAD_PROBE_OK;
}

// qtdemux of GStreamer 1.22 cuts the head of AV1's codec data off, and a decoder refuses the rest.
// Each key frame has the same data. Returns the caps without them, or nothing if they are whole.
CapsPtr without_cut_data(const GstCaps *caps) {
  CapsPtr form(gst_caps_copy(caps));
  GstStructure *structure = gst_caps_get_structure(form.get(), 0);
  const GValue *value =
      g_str_equal(name_of(caps), kAv1) ? gst_structure_get_value(structure, "codec_data") : nullptr;
  guint8 marker = 0;
  if (!value || gst_buffer_extract(gst_value_get_buffer(value), 0, &marker, 1) != 1 ||
      marker == kAv1Marker)
    return nullptr;
  gst_structure_remove_field(structure, "codec_data");
  return form;
}

GstPadProbeReturn leave_cut_data_out(GstPad *, GstPadProbeInfo *info, gpointer) {
  GstEvent *event = GST_PAD_PROBE_INFO_EVENT(info);
  const GstCaps *caps = caps_in(event);
  if (const CapsPtr whole = caps ? without_cut_data(caps) : nullptr) {
    GST_PAD_PROBE_INFO_DATA(info) = gst_event_new_caps(whole.get());
    gst_event_unref(event);
  }
  return GST_PAD_PROBE_OK;
}

// matroskademux names the text of subtitles Pango's markup and escapes what would be none. They go
// back as they were.
GstPadProbeReturn unescape(GstPad *, GstPadProbeInfo *info, gpointer) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};
  edit_buffer<std::string>(info, [&](std::string &text) {
    for (std::size_t at = text.find('&'); at != text.npos; at = text.find('&', at + 1))
      for (const auto &[entity, character] : kEntities)
        if (text.compare(at, entity.size(), entity) == 0) {
          text.replace(at, entity.size(), 1, character);
          break;
        }
  });
  return GST_PAD_PROBE_OK;
}

// Before its first frame, aacparse knows neither rate nor profile, and a muxer needs them.
bool is_unknown_aac(const GstCaps *caps) {
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  gint version = 0;
  return g_str_equal(name_of(caps), "audio/mpeg") &&
         gst_structure_get_int(structure, "mpegversion", &version) && version > 1 &&
         !gst_structure_has_field(structure, "rate");
}

// tsdemux sends gaps until a stream begins, in GStreamer 1.22 the first one before a segment.
// The muxer gets nothing that it cannot place, and waits for the first frame instead.
GstPadProbeReturn drop_early(GstPad *pad, GstPadProbeInfo *info, gpointer) {
  GstEvent *event = GST_PAD_PROBE_INFO_EVENT(info);
  if (const GstCaps *caps = caps_in(event))
    return is_unknown_aac(caps) ? GST_PAD_PROBE_DROP : GST_PAD_PROBE_OK;
  if (GST_EVENT_TYPE(event) != GST_EVENT_GAP)
    return GST_PAD_PROBE_OK;
  const EventPtr segment(gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0));
  return segment && !is_unknown_aac(caps_of(pad).get()) ? GST_PAD_PROBE_OK : GST_PAD_PROBE_DROP;
}

// matroskamux has no name for DNxHD. It writes such a stream as HuffYUV, and this puts the name
// there by which others know DNxHD in V_MS/VFW/FOURCC.
GstPadProbeReturn name_dnxhd(GstPad *, GstPadProbeInfo *info, gpointer) {
  std::size_t at = 0;
  edit_buffer<std::string>(info, [&](std::string &bytes) {
    at = bytes.find("HFYU");
    if (at != bytes.npos)
      bytes.replace(at, 4, "AVdn");
  });
  return at == std::string::npos ? GST_PAD_PROBE_OK : GST_PAD_PROBE_REMOVE;
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

gboolean is_parsed_further(GstElement *, GstPad *, GstCaps *caps, gpointer) {
  constexpr std::string_view kWhole[] = {"application/x-ass", "application/x-ssa"};
  return std::ranges::find(kWhole, name_of(caps)) == std::end(kWhole);
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
      gst_pad_add_probe(PadPtr(gst_element_get_static_pad(mux, "src")).get(),
                        GST_PAD_PROBE_TYPE_BUFFER, name_dnxhd, nullptr, nullptr);
  }
  if (last != queue)
    link_elements(queue, last);
  // A receiver may begin at any IDR frame.
  if (!is_matroska && g_object_class_find_property(G_OBJECT_GET_CLASS(last), "config-interval"))
    g_object_set(last, "config-interval", -1, nullptr);
  PadPtr from_pad(gst_element_get_static_pad(last, "src"));
  if (is_matroska)
    gst_pad_add_probe(from_pad.get(), GST_PAD_PROBE_TYPE_BUFFER, complete_time, nullptr, nullptr);
  const char *format = gst_structure_get_string(gst_caps_get_structure(caps, 0), "format");
  if (is_text && g_strcmp0(format, "pango-markup") == 0)
    gst_pad_add_probe(from_pad.get(), GST_PAD_PROBE_TYPE_BUFFER, unescape, nullptr, nullptr);
  gst_pad_add_probe(from_pad.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, drop_early, nullptr,
                    nullptr);
  const PadPtr to_pad(gst_element_get_compatible_pad(mux, from_pad.get(), form.get()));
  if (to_pad && is_matroska)
    gst_pad_add_probe(to_pad.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, leave_cut_data_out,
                      nullptr, nullptr);
  if (!to_pad || GST_PAD_LINK_FAILED(gst_pad_link(from_pad.get(), to_pad.get())))
    throw_error(messages::kMuxerHasNoPlace, name_of(caps));
  link_pad(pad, queue);
  return from_pad;
}

} // namespace haptic
