// SPDX-License-Identifier: LGPL-2.1-or-later
// Opens damaged films, playlists and descriptions of sessions in one process, as haptic-track and
// feeling-wind open files: whatever they say, no element is chosen that opens other files or
// addresses, and nothing is connected to.
//
//   open-fuzz [INPUTS [SEED [FILE...]]]      FILE: further whole ones
//   open-fuzz --write FOLDER INPUTS SEED FILE...   writes damaged ones instead
#include "glue/content-only.hpp"
#include "glue/gst-raii.hpp"
#include "mutator.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <gst/gst.h>
#include <iterator>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

namespace {

std::atomic<std::uint64_t> connections = 0;

} // namespace

// Stands before that of the C library, for GStreamer and its plugins too.
extern "C" int connect(int, const sockaddr *, socklen_t) {
  ++connections;
  errno = ECONNREFUSED;
  return -1;
}

namespace {

using test::Bytes;

// Of an input that parsebin neither understands nor refuses: it drops some errors.
constexpr GstClockTime kPatience = 100 * GST_MSECOND;

// Lists of other files or addresses, in every form that an element of GStreamer follows.
constexpr std::string_view kLists[] = {
    R"(#EXTM3U
#EXT-X-VERSION:3
#EXT-X-TARGETDURATION:2
#EXTINF:2,
http://127.0.0.1:9/named.ts
#EXT-X-ENDLIST
)",
    R"(#EXTM3U
#EXT-X-STREAM-INF:BANDWIDTH=100000
file:///named/film.m3u8
)",
    R"(<?xml version="1.0"?>
<MPD xmlns="urn:mpeg:dash:schema:mpd:2011" type="static" mediaPresentationDuration="PT2S"
 minBufferTime="PT1S" profiles="urn:mpeg:dash:profile:isoff-on-demand:2011">
<BaseURL>http://127.0.0.1:9/</BaseURL><Period><AdaptationSet mimeType="video/mp4">
<Representation id="1" bandwidth="1000"><BaseURL>named.mp4</BaseURL></Representation>
</AdaptationSet></Period></MPD>)",
    R"xml(<?xml version="1.0"?>
<SmoothStreamingMedia MajorVersion="2" MinorVersion="0" Duration="20000000"><StreamIndex
 Type="video" Chunks="1" Url="http://127.0.0.1:9/named({bitrate})({start time})"><QualityLevel
 Bitrate="100000" FourCC="H264" CodecPrivateData=""/><c d="20000000"/></StreamIndex>
</SmoothStreamingMedia>)xml",
    R"(v=0
o=- 0 0 IN IP4 127.0.0.1
s=named
c=IN IP4 127.0.0.1
t=0 0
m=video 9 RTP/AVP 96
a=rtpmap:96 H264/90000
)",
    "RTSPtextRTSP://127.0.0.1:9/named\n",
    "[playlist]\nFile1=http://127.0.0.1:9/named.mp4\nNumberOfEntries=1\n",
    R"(<asx version="3.0"><entry><ref href="http://127.0.0.1:9/named.wmv"/></entry></asx>)",
    R"(<smil><body><video src="http://127.0.0.1:9/named.mp4"/></body></smil>)",
    "http://127.0.0.1:9/named.mp4\n"};

// Films, as far as their elements are there.
constexpr const char *kFilms[] = {
    "jpegenc ! matroskamux", "jpegenc ! avimux", "jpegenc ! qtmux",  "mpeg2enc ! mpegtsmux",
    "x264enc ! mpegtsmux",   "x264enc ! mp4mux", "jpegenc ! oggmux", "theoraenc ! oggmux"};

Bytes read_bytes(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string &path, const Bytes &bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char *>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

// A box of QuickTime that names another film (rmra, rmda, rdrf).
Bytes reference_film() {
  constexpr std::string_view kAddress = "http://127.0.0.1:9/named.mp4";
  Bytes all = {0, 0, 0, 8, 'f', 't', 'y', 'p'};
  const auto head = [&](std::size_t size, std::string_view type) {
    for (const unsigned shift : {24U, 16U, 8U, 0U})
      all.push_back(static_cast<std::uint8_t>(size >> shift));
    all.insert(all.end(), type.begin(), type.end());
  };
  const std::size_t size = 8 + 12 + kAddress.size() + 1;
  head(size + 24, "moov");
  head(size + 16, "rmra");
  head(size + 8, "rmda");
  head(size, "rdrf");
  all.insert(all.end(), {0, 0, 0, 0, 'u', 'r', 'l', ' '});
  head(kAddress.size() + 1, kAddress);
  all.push_back(0);
  return all;
}

haptic::MessagePtr play(GstElement *pipeline, GstMessageType until, GstClockTime patience) {
  const haptic::BusPtr bus(gst_element_get_bus(pipeline));
  haptic::MessagePtr message(gst_bus_timed_pop_filtered(bus.get(), patience, until));
  gst_element_set_state(pipeline, GST_STATE_NULL);
  return message;
}

constexpr std::size_t kOpen = 32; // at a time
constexpr auto kEnds = static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR);

std::vector<Bytes> whole_ones(const std::string &scratch, int count, char **files) {
  std::vector<Bytes> all = {reference_film()};
  for (const std::string_view list : kLists)
    all.emplace_back(list.begin(), list.end());
  for (const char *film : kFilms) {
    const std::string line = std::string("videotestsrc num-buffers=3 ! "
                                         "video/x-raw,format=I420,width=32,height=32 ! ") +
                             film + " ! filesink location=" + scratch;
    GError *error = nullptr;
    GstElement *made = gst_parse_launch(line.c_str(), &error);
    if (made && !error) {
      gst_element_set_state(made, GST_STATE_PLAYING);
      const auto end = play(made, kEnds, 10 * GST_SECOND);
      if (end && GST_MESSAGE_TYPE(end.get()) == GST_MESSAGE_EOS)
        all.push_back(read_bytes(scratch));
    }
    g_clear_error(&error);
    if (made)
      gst_object_unref(made);
  }
  for (int i = 0; i < count; ++i)
    all.push_back(read_bytes(files[i]));
  return all;
}

std::atomic<std::uint64_t> chosen = 0; // elements
std::atomic<std::uint64_t> demuxers = 0;
std::atomic<std::uint64_t> followers = 0;

void judge(GstBin *, GstBin *, GstElement *element, gpointer) {
  const GstElementFactory *factory = gst_element_get_factory(element);
  const std::string_view name = factory ? GST_OBJECT_NAME(factory) : "";
  const std::string_view kind =
      factory ? gst_element_factory_get_metadata(const_cast<GstElementFactory *>(factory),
                                                 GST_ELEMENT_METADATA_KLASS)
              : "";
  ++chosen;
  demuxers += kind.find("Demux") != kind.npos;
  for (const std::string_view follower : {"Adaptive", "Network", "Source"})
    if (kind.find(follower) != kind.npos && name != "filesrc") {
      std::printf("%s was chosen\n", GST_OBJECT_NAME(factory));
      ++followers;
    }
}

// Returns the pipeline that opens a file.
GstElement *opening(const std::string &path, const char *autoplugger) {
  GstElement *pipeline = gst_pipeline_new(nullptr);
  GstElement *source = gst_element_factory_make("filesrc", nullptr);
  GstElement *parse = gst_element_factory_make(autoplugger, nullptr);
  g_object_set(source, "location", path.c_str(), nullptr);
  haptic::open_content_only(parse, "a list of other files");
  g_signal_connect(pipeline, "deep-element-added", G_CALLBACK(judge), nullptr);
  g_signal_connect_swapped(parse, "no-more-pads", G_CALLBACK(+[](GstElement *owner) {
                             gst_element_post_message(
                                 owner, gst_message_new_application(
                                            GST_OBJECT(owner), gst_structure_new_empty("known")));
                           }),
                           pipeline);
  gst_bin_add_many(GST_BIN(pipeline), source, parse, nullptr);
  gst_element_link(source, parse);
  gst_element_set_state(pipeline, GST_STATE_PAUSED);
  return pipeline;
}

// Returns whether the file was understood or refused within kPatience.
bool close(GstElement *pipeline) {
  const auto message = play(
      pipeline,
      static_cast<GstMessageType>(kEnds | GST_MESSAGE_APPLICATION | GST_MESSAGE_STREAM_COLLECTION),
      kPatience);
  gst_object_unref(pipeline);
  return message != nullptr;
}

// Returns whether a connection that an element asks for is counted.
bool connections_are_counted() {
  GstElement *pipeline = gst_parse_launch("tcpclientsrc host=127.0.0.1 port=9 ! fakesink", nullptr);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  play(pipeline, GST_MESSAGE_ERROR, 10 * GST_SECOND);
  gst_object_unref(pipeline);
  return connections.exchange(0) > 0;
}

Bytes damaged(std::uint64_t number, unsigned seed, const std::vector<Bytes> &whole) {
  test::Mutator mutator(seed + static_cast<unsigned>(number));
  Bytes bytes = whole[number % whole.size()];
  mutator.mutate(bytes, whole);
  return bytes;
}

} // namespace

int main(int argc, char **argv) {
  gst_init(nullptr, nullptr);
  const bool writes = argc > 4 && argv[1] == std::string_view("--write");
  const int first = writes ? 3 : 1; // word
  const std::uint64_t inputs = argc > first ? std::strtoull(argv[first], nullptr, 10) : 2000;
  const auto seed = argc > first + 1 ? static_cast<unsigned>(std::atoi(argv[first + 1])) : 1U;
  const std::string scratch =
      (std::filesystem::temp_directory_path() / ("open-fuzz." + std::to_string(getpid()))).string();
  const auto whole = whole_ones(scratch, std::max(argc - first - 2, 0), argv + first + 2);
  std::uint64_t silent = 0;
  if (!connections_are_counted()) {
    std::printf("a connection is not counted\n");
    return EXIT_FAILURE;
  }
  // An opening is mostly waiting. Closed at once, parsebin of GStreamer 1.22 may still be choosing,
  // and end the process.
  std::deque<GstElement *> open;
  for (std::uint64_t i = 0; i < inputs; ++i) {
    const std::string name = writes ? std::string(argv[2]) + '/' + std::to_string(i)
                                    : scratch + '.' + std::to_string(i % (kOpen + 1));
    write_bytes(name, damaged(i, seed, whole));
    if (writes)
      continue;
    open.push_back(opening(name, i % 10 == 0 ? "decodebin" : "parsebin"));
    if (open.size() > kOpen) {
      silent += !close(open.front());
      open.pop_front();
    }
  }
  for (GstElement *pipeline : open)
    silent += !close(pipeline);
  for (std::size_t i = 0; i <= kOpen; ++i)
    std::filesystem::remove(scratch + '.' + std::to_string(i));
  std::error_code error;
  std::filesystem::remove(scratch, error);
  std::printf("%zu whole ones, %llu inputs, %llu elements chosen, %llu demuxers, %llu that open "
              "others, %llu connections, %llu without a word\n",
              whole.size(), static_cast<unsigned long long>(inputs),
              static_cast<unsigned long long>(chosen.load()),
              static_cast<unsigned long long>(demuxers.load()),
              static_cast<unsigned long long>(followers.load()),
              static_cast<unsigned long long>(connections.load()),
              static_cast<unsigned long long>(silent));
  return (writes || demuxers > 0) && followers == 0 && connections == 0 ? EXIT_SUCCESS
                                                                        : EXIT_FAILURE;
}
