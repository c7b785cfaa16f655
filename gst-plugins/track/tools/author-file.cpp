// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author-file.hpp"

#include "gst-raii.hpp"
#include "klv.hpp"
#include "pipeline.hpp"
#include "text-line.hpp"
#include "track-caps.hpp"
#include "track-file.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gst/pbutils/pbutils.h>
#include <string_view>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr char kTransportStream[] = ".ts";
constexpr char kMatroska[] = ".mkv";

// Limits of the queues. The muxer waits for the track, which waits for what the decoder holds back.
constexpr guint kVideoBytes = 48 << 20;
constexpr guint kAudioBytes = 16 << 20;
// A file ends early if it lacks more than this share of its length and more than this time.
constexpr double kMissingShare = 0.02;
constexpr GstClockTime kMissing = GST_SECOND;
constexpr gint64 kLongestShow =
    gint64{10} * G_USEC_PER_SEC; // us, from the first stream to the last

// ---- the file that is written -------------------------------------------------------------------

// Returns whether motion fields are in the first 16 MiB. A copy has them from the first frame on.
bool holds_fields(const std::string &path) {
  std::string begin(16 << 20, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(file.gcount()));
  const std::string_view key(reinterpret_cast<const char *>(kMotionKey.data()), kMotionKey.size());
  return begin.find(kTextFieldStart) != std::string::npos || begin.find(key) != std::string::npos;
}

// A file under another name, locked against other processes. It is removed unless it is kept.
class PartFile {
public:
  explicit PartFile(std::string path) : path_(std::move(path)) {
    fd_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd_ < 0)
      throw_error(messages::kOutputFails, path_.c_str(), std::strerror(errno));
    if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      close(fd_);
      throw_error(messages::kFileIsBeingWritten, path_.c_str());
    }
  }
  ~PartFile() {
    if (!kept_)
      unlink(path_.c_str());
    close(fd_);
  }
  PartFile(const PartFile &) = delete;
  PartFile &operator=(const PartFile &) = delete;

  const std::string &path() const { return path_; }

  // Writes the content to the disk before it renames the file, and then the name.
  void keep_as(const std::string &path) {
    if (fsync(fd_) != 0 || std::rename(path_.c_str(), path.c_str()) != 0)
      throw_error(messages::kOutputFails, path.c_str(), std::strerror(errno));
    kept_ = true;
    const std::string folder = fs::path(path).parent_path().string();
    if (const int fd = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC); fd >= 0) {
      fsync(fd);
      close(fd);
    }
  }

private:
  std::string path_;
  int fd_ = -1;
  bool kept_ = false;
};

// ---- the pipeline -------------------------------------------------------------------------------

// The state of one video that is authored.
struct Work {
  const std::string &path;
  const AuthorOptions &options;
  std::string part;
  GstElement *pipeline = nullptr;
  GstElement *field = nullptr;

  // The source's streaming thread until all streams are known, then the main thread.
  std::vector<std::pair<PadPtr, gulong>> streams; // each held by a probe
  std::atomic<std::size_t> shown = 0;
  GstPad *video = nullptr;
  std::vector<GstPad *> audio;
  std::string ending;
  std::vector<std::string> remarks;
  std::string unknown; // caps of a stream that no parser knows
  gint width = 0;      // px, of the decoded frames; its streaming thread
  gint height = 0;

  std::atomic<std::uint64_t> frames = 0;
  std::atomic<GstClockTime> measured = 0; // of the frames
  std::atomic<GstClockTime> position = 0; // of the file
  std::atomic<GstClockTime> duration = GST_CLOCK_TIME_NONE;
};

const char *name_of(const GstCaps *caps) {
  return gst_structure_get_name(gst_caps_get_structure(caps, 0));
}

CapsPtr caps_of(GstPad *pad) {
  CapsPtr caps(gst_pad_get_current_caps(pad));
  return caps ? std::move(caps) : CapsPtr(gst_pad_query_caps(pad, nullptr));
}

// Returns the parser that converts between the forms of the stream, or nothing.
const char *parser_of(const GstCaps *caps) {
  constexpr std::array<std::pair<const char *, const char *>, 2> kParsers = {
      {{"video/x-h264", "h264parse"}, {"video/x-h265", "h265parse"}}};
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

bool has_place(const char *mux, GstPad *pad) {
  const CapsPtr caps = without_form(caps_of(pad).get());
  const bool is_known = gst_caps_is_fixed(caps.get());
  const std::unique_ptr<GstElementFactory, decltype(&gst_object_unref)> factory(
      gst_element_factory_find(mux), gst_object_unref);
  bool has = false;
  for (const GList *item = factory ? gst_element_factory_get_static_pad_templates(factory.get())
                                   : nullptr;
       item; item = item->next) {
    auto *pads = static_cast<GstStaticPadTemplate *>(item->data);
    const CapsPtr all(gst_static_pad_template_get_caps(pads));
    const CapsPtr taken = without_form(all.get());
    // The caps of a parser are not fixed before its first frame.
    has = has || (pads->direction == GST_PAD_SINK &&
                  (is_known ? gst_caps_is_subset(caps.get(), taken.get())
                            : gst_caps_can_intersect(caps.get(), taken.get())));
  }
  return has;
}

GstElement *add_queue(GstElement *pipeline, guint bytes) {
  GstElement *queue = add_element(pipeline, "queue");
  g_object_set(queue, "max-size-bytes", bytes, "max-size-buffers", 0, "max-size-time", guint64{0},
               nullptr);
  return queue;
}

void link_elements(GstElement *from, GstElement *to) {
  if (!gst_element_link(from, to))
    throw_error(messages::kStreamDoesNotFit, GST_ELEMENT_NAME(from), GST_ELEMENT_NAME(to));
}

void link_pad(GstPad *pad, GstElement *to) {
  const PadPtr sink(gst_element_get_static_pad(to, "sink"));
  if (GST_PAD_LINK_FAILED(gst_pad_link(pad, sink.get())))
    throw_error(messages::kStreamDoesNotFit, GST_PAD_NAME(pad), GST_ELEMENT_NAME(to));
}

// Links the stream of `from` to the muxer without a change.
void link_untouched(const Work &work, GstElement *from, GstCaps *caps, GstElement *mux) {
  const char *parser = parser_of(caps);
  GstElement *last = parser ? add_element(work.pipeline, parser) : from;
  if (parser)
    link_elements(from, last);
  const PadPtr from_pad(gst_element_get_static_pad(last, "src"));
  const PadPtr to_pad(gst_element_get_compatible_pad(mux, from_pad.get(), parser ? nullptr : caps));
  if (!to_pad || GST_PAD_LINK_FAILED(gst_pad_link(from_pad.get(), to_pad.get())))
    throw_error(messages::kMuxerHasNoPlace, name_of(caps));
}

GstPadProbeReturn watch_size(GstPad *, GstPadProbeInfo *info, gpointer data) {
  Work &work = *static_cast<Work *>(data);
  GstEvent *event = GST_PAD_PROBE_INFO_EVENT(info);
  if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS)
    return GST_PAD_PROBE_OK;
  GstCaps *caps = nullptr;
  gst_event_parse_caps(event, &caps);
  gint width = 0;
  gint height = 0;
  gst_structure_get_int(gst_caps_get_structure(caps, 0), "width", &width);
  gst_structure_get_int(gst_caps_get_structure(caps, 0), "height", &height);
  if (work.width == 0) {
    work.width = width;
    work.height = height;
  }
  if (width == work.width && height == work.height)
    return GST_PAD_PROBE_OK;
  GST_ELEMENT_ERROR(work.pipeline, STREAM, FORMAT,
                    (messages::kFrameSizeChanges, work.width, work.height, width, height,
                     static_cast<double>(work.measured) * 1e-9),
                    (nullptr));
  return GST_PAD_PROBE_DROP;
}

// Moves the position to the end of a buffer, if that is later.
void advance(std::atomic<GstClockTime> &position, GstPadProbeInfo *info) {
  const GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  if (!GST_BUFFER_PTS_IS_VALID(buffer))
    return;
  const GstClockTime duration =
      GST_BUFFER_DURATION_IS_VALID(buffer) ? GST_BUFFER_DURATION(buffer) : 0;
  const GstClockTime end = GST_BUFFER_PTS(buffer) + duration;
  for (GstClockTime before = position; before < end;)
    if (position.compare_exchange_weak(before, end))
      break;
}

void watch_position(Work &work, GstPad *pad) {
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad *, GstPadProbeInfo *info, gpointer data) {
        advance(static_cast<Work *>(data)->position, info);
        return GST_PAD_PROBE_OK;
      },
      &work, nullptr);
}

// Adds frames -> motionfield -> hapticconvert -> muxer. The decoder is linked when it has a pad.
void add_track(Work &work, GstElement *decoder, GstElement *mux) {
  GstElement *convert = add_element(work.pipeline, "videoconvert");
  work.field = add_element(work.pipeline, "motionfield");
  if (work.options.columns > 0)
    g_object_set(work.field, "field-columns", work.options.columns, nullptr);
  GstElement *track = add_element(work.pipeline, "hapticconvert");
  GstElement *form = add_element(work.pipeline, "capsfilter");
  const CapsPtr caps(
      gst_caps_from_string(work.ending == kTransportStream ? HAPTIC_KLV_CAPS : HAPTIC_TEXT_CAPS));
  g_object_set(form, "caps", caps.get(), nullptr);
  GstElement *queue = add_queue(work.pipeline, kAudioBytes);
  link_elements(convert, work.field);
  link_elements(work.field, track);
  link_elements(track, form);
  link_elements(form, queue);
  link_elements(queue, mux);
  const PadPtr in(gst_element_get_static_pad(convert, "sink"));
  gst_pad_add_probe(in.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, watch_size, &work, nullptr);
  const PadPtr out(gst_element_get_static_pad(work.field, "src"));
  gst_pad_add_probe(
      out.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad *, GstPadProbeInfo *info, gpointer data) {
        Work &all = *static_cast<Work *>(data);
        ++all.frames;
        advance(all.measured, info);
        return GST_PAD_PROBE_OK;
      },
      &work, nullptr);
  g_signal_connect(decoder, "pad-added", G_CALLBACK(+[](GstElement *, GstPad *pad, gpointer data) {
                     auto *sink = static_cast<GstElement *>(data);
                     const PadPtr to(gst_element_get_static_pad(sink, "sink"));
                     if (!gst_pad_is_linked(to.get()))
                       gst_pad_link(pad, to.get());
                   }),
                   convert);
}

bool is_matroska(const std::string &path) {
  char head[kMatroskaMagic.size()] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  return std::string_view(head, sizeof head) == kMatroskaMagic;
}

// Returns the muxer: that of MPEG-TS if it has a place for all streams. Streams from Matroska have
// no decoding times and go back into Matroska.
const char *choose_muxer(Work &work) {
  const auto all_fit = [&](const char *mux) {
    return std::ranges::all_of(work.audio, [&](GstPad *pad) { return has_place(mux, pad); });
  };
  if (!is_matroska(work.path) && has_place("mpegtsmux", work.video) && all_fit("mpegtsmux")) {
    work.ending = kTransportStream;
    return "mpegtsmux";
  }
  if (!has_place("matroskamux", work.video))
    throw_error(messages::kNoContainer, name_of(caps_of(work.video).get()));
  work.ending = kMatroska;
  return "matroskamux";
}

// Matroska holds random numbers and the date. With these settings the same video gives the same
// copy.
void make_output_deterministic(const Work &work, GstElement *mux) {
  const std::string name = fs::path(work.path).filename().string();
  g_random_set_seed(g_str_hash(name.c_str()));
  struct stat status = {};
  stat(work.path.c_str(), &status);
  GDateTime *date = g_date_time_new_from_unix_utc(status.st_mtime);
  if (g_object_class_find_property(G_OBJECT_GET_CLASS(mux), "creation-time"))
    g_object_set(mux, "creation-time", date, nullptr);
  g_date_time_unref(date);
}

void leave_out(Work &work, GstPad *pad, const std::string &what) {
  const CapsPtr caps = caps_of(pad);
  work.remarks.push_back(what + " was left out: " + name_of(caps.get()));
  GstElement *sink = add_element(work.pipeline, "fakesink");
  g_object_set(sink, "async", FALSE, nullptr);
  link_pad(pad, sink);
}

void build(Work &work) {
  GstElement *mux = add_element(work.pipeline, choose_muxer(work));
  make_output_deterministic(work, mux);
  GstElement *sink = add_element(work.pipeline, "filesink");
  g_object_set(sink, "location", work.part.c_str(), "async", FALSE, nullptr);
  link_elements(mux, sink);

  gint64 duration = 0;
  if (gst_pad_query_duration(work.video, GST_FORMAT_TIME, &duration) && duration > 0)
    work.duration = static_cast<GstClockTime>(duration);
  const CapsPtr caps = caps_of(work.video);
  GstElement *tee = add_element(work.pipeline, "tee");
  GstElement *untouched = add_queue(work.pipeline, kVideoBytes);
  GstElement *to_decode = add_queue(work.pipeline, kAudioBytes);
  GstElement *decoder = add_element(work.pipeline, "decodebin");
  link_elements(tee, untouched);
  link_elements(tee, to_decode);
  link_untouched(work, untouched, caps.get(), mux);
  for (GstPad *pad : work.audio) {
    if (!has_place(work.ending == kMatroska ? "matroskamux" : "mpegtsmux", pad)) {
      leave_out(work, pad, "the sound");
      continue;
    }
    GstElement *queue = add_queue(work.pipeline, kAudioBytes);
    link_untouched(work, queue, caps_of(pad).get(), mux);
    link_pad(pad, queue);
    watch_position(work, pad);
  }
  add_track(work, decoder, mux);
  link_elements(to_decode, decoder);
  watch_position(work, work.video);
  link_pad(work.video, tee);
  gst_bin_sync_children_states(GST_BIN(work.pipeline));
}

// Blocks a new stream: the muxer must know all streams when it starts.
void block_stream(GstElement *, GstPad *pad, gpointer data) {
  const auto hold = [](GstPad *, GstPadProbeInfo *, gpointer) { return GST_PAD_PROBE_OK; };
  const gulong probe =
      gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BLOCK_DOWNSTREAM, hold, nullptr, nullptr);
  Work &work = *static_cast<Work *>(data);
  work.streams.emplace_back(PadPtr(GST_PAD(gst_object_ref(pad))), probe);
  ++work.shown;
}

void sort_streams(Work &work) {
  for (const auto &[pad, probe] : work.streams) {
    const CapsPtr caps = caps_of(pad.get());
    const std::string_view name = name_of(caps.get());
    if (!work.video && (name.starts_with("video/") || name.starts_with("image/")))
      work.video = pad.get();
    else if (name.starts_with("audio/"))
      work.audio.push_back(pad.get());
    else
      leave_out(work, pad.get(), "a further stream");
  }
  if (!work.video)
    throw_error(messages::kVideoIsMissing,
                work.unknown.empty() ? "" : (" that is understood, only " + work.unknown).c_str());
}

// Limits the memory: a decoder holds frames for each of its threads.
void limit_threads(GstBin *, GstBin *, GstElement *element, gpointer) {
  if (g_object_class_find_property(G_OBJECT_GET_CLASS(element), "max-threads"))
    g_object_set(element, "max-threads", 2, nullptr);
}

// Returns the first message of this type. Throws the error of the pipeline instead.
MessagePtr wait_for(Work &work, GstMessageType wanted,
                    const std::function<void(const AuthorProgress &)> &report) {
  const BusPtr bus(gst_element_get_bus(work.pipeline));
  std::string missing;
  for (;;) {
    const MessagePtr message(gst_bus_timed_pop_filtered(
        bus.get(), 200 * GST_MSECOND,
        static_cast<GstMessageType>(wanted | GST_MESSAGE_ERROR | GST_MESSAGE_ELEMENT)));
    const GstClockTime duration = work.duration;
    const double done = GST_CLOCK_TIME_IS_VALID(duration)
                            ? static_cast<double>(work.measured) / static_cast<double>(duration)
                            : 0;
    report({work.frames, std::min(done, 1.0)});
    if (!message)
      continue;
    const GstMessageType type = GST_MESSAGE_TYPE(message.get());
    if (type == GST_MESSAGE_ERROR)
      throw TrackFileError(missing.empty() ? error_of(message.get()) : missing);
    if (type == wanted)
      return MessagePtr(gst_message_ref(message.get()));
    if (gst_is_missing_plugin_message(message.get())) {
      const GCharPtr what(gst_missing_plugin_message_get_description(message.get()));
      missing = formatted(messages::kDecoderIsMissing, what.get());
    }
  }
}

// parsebin posts the number of streams and then adds a pad for each.
void wait_for_streams(Work &work, const std::function<void(const AuthorProgress &)> &report) {
  const MessagePtr message = wait_for(work, GST_MESSAGE_STREAM_COLLECTION, report);
  GstStreamCollection *collection = nullptr;
  gst_message_parse_stream_collection(message.get(), &collection);
  const std::size_t count = gst_stream_collection_get_size(collection);
  gst_object_unref(collection);
  const gint64 latest = g_get_monotonic_time() + kLongestShow;
  while (work.shown < count && g_get_monotonic_time() < latest)
    g_usleep(1000);
  if (work.shown < count)
    throw_error(messages::kStreamsAreUnclear);
}

void check_whole(const Work &work) {
  if (work.frames == 0)
    throw_error(messages::kNoFrameIsDecoded);
  const GstClockTime duration = work.duration;
  const GstClockTime position = work.position;
  if (GST_CLOCK_TIME_IS_VALID(duration) && position < duration && duration - position > kMissing &&
      static_cast<double>(duration - position) > kMissingShare * static_cast<double>(duration))
    throw_error(messages::kFileEndsEarly, static_cast<double>(position) * 1e-9,
                static_cast<double>(duration) * 1e-9);
}

} // namespace

std::string author_stem(const std::string &path, const AuthorOptions &options) {
  const fs::path video(path);
  const fs::path folder = options.folder.empty() ? video.parent_path() : fs::path(options.folder);
  return (folder / video.stem()).string() + ".haptic";
}

std::string author_part(const std::string &path, const AuthorOptions &options) {
  return author_stem(path, options) + ".part";
}

Authored author_file(const std::string &path, const AuthorOptions &options,
                     const std::function<void(const AuthorProgress &)> &report) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw_error(messages::kFileIsMissing, path.c_str());
  if (!fs::is_regular_file(path, error))
    throw_error(messages::kFileIsNone, path.c_str());
  if (access(path.c_str(), R_OK) != 0)
    throw_error(messages::kFileIsForbidden, path.c_str());
  if (fs::path(path).stem().extension() == ".haptic" && holds_fields(path))
    return {path, true, 0, {}};
  PartFile part(author_part(path, options));
  for (const char *ending : {kTransportStream, kMatroska})
    if (const std::string copy = author_stem(path, options) + ending; fs::exists(copy, error)) {
      if (!holds_fields(copy))
        throw_error(messages::kCopyHoldsNoFields, copy.c_str());
      return {copy, true, 0, {}};
    }

  gst_init(nullptr, nullptr);
  const ElementPtr pipeline = make_pipeline();
  Work work{path, options, part.path()};
  work.pipeline = pipeline.get();
  GstElement *source = add_element(pipeline.get(), "filesrc");
  GstElement *parse = add_element(pipeline.get(), "parsebin");
  g_object_set(source, "location", path.c_str(), nullptr);
  gst_element_link(source, parse);
  g_signal_connect(parse, "pad-added", G_CALLBACK(block_stream), &work);
  g_signal_connect(parse, "unknown-type",
                   G_CALLBACK(+[](GstElement *, GstPad *, GstCaps *caps, gpointer data) {
                     static_cast<Work *>(data)->unknown = name_of(caps);
                   }),
                   &work);
  g_signal_connect(pipeline.get(), "deep-element-added", G_CALLBACK(limit_threads), nullptr);
  try {
    gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
    wait_for_streams(work, report);
    sort_streams(work);
    build(work);
    for (const auto &[pad, probe] : work.streams)
      gst_pad_remove_probe(pad.get(), probe);
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    wait_for(work, GST_MESSAGE_EOS, report);
    check_whole(work);
  } catch (const TrackFileError &wrong) {
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
    throw_error("\"%s\": %s", path.c_str(), wrong.what());
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  const std::string copy = author_stem(path, options) + work.ending;
  part.keep_as(copy);
  return {copy, false, work.frames, work.remarks};
}

} // namespace haptic
