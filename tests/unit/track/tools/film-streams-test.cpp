// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/film-streams.hpp"

#include "film/copied-stream.hpp"
#include "film/pipeline.hpp"
#include "track-pipeline.hpp"
#include "tracks/track-file.hpp"

#include <csignal>
#include <gtest/gtest.h>
#include <string>

// A demuxer that reads all and finds no stream, as some do in damaged files.
struct SilentDemuxer {
  GstElement element;
};
struct SilentDemuxerClass {
  GstElementClass element_class;
};
G_DEFINE_TYPE(SilentDemuxer, silent_demuxer, GST_TYPE_ELEMENT)

static GstStaticPadTemplate silent_sink = GST_STATIC_PAD_TEMPLATE(
    "sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS("application/x-silent"));

static void silent_demuxer_class_init(SilentDemuxerClass *klass) {
  gst_element_class_add_static_pad_template(&klass->element_class, &silent_sink);
  gst_element_class_set_static_metadata(&klass->element_class, "Silent demuxer", "Codec/Demuxer",
                                        "Finds no stream", "tests");
}

static void silent_demuxer_init(SilentDemuxer *demuxer) {
  GstPad *sink = gst_pad_new_from_static_template(&silent_sink, "sink");
  gst_pad_set_chain_function(sink, [](GstPad *, GstObject *, GstBuffer *buffer) {
    gst_buffer_unref(buffer);
    return GST_FLOW_OK;
  });
  gst_pad_set_event_function(sink, [](GstPad *, GstObject *, GstEvent *event) -> gboolean {
    gst_event_unref(event);
    return TRUE;
  });
  gst_element_add_pad(&demuxer->element, sink);
}

namespace film_streams_test {

void find_silent(GstTypeFind *find, gpointer) {
  const guint8 *head = gst_type_find_peek(find, 0, 6);
  if (head && std::string_view(reinterpret_cast<const char *>(head), 6) == "silent")
    gst_type_find_suggest_simple(find, GST_TYPE_FIND_MAXIMUM, "application/x-silent", nullptr,
                                 nullptr);
}

// Returns what the work throws.
template <typename Work>
std::string error_of(const Work &work) {
  try {
    work();
  } catch (const haptic::TrackFileError &error) {
    return error.what();
  }
  return "nothing";
}

// A film that is read at once, and whose frames then take half a second each.
void play_slowly(bool watched) {
  const test::ScratchFolder folder;
  const std::string path = folder.file("film.mkv");
  test::run("videotestsrc num-buffers=10 ! video/x-raw,width=64,height=48,framerate=10/1 "
            "! jpegenc ! matroskamux ! filesink location=" +
            path);
  haptic::FilmStreams film(path, haptic::FilmUse::decode);
  GstElement *queue = haptic::add_queue(film.pipeline(), 1 << 20);
  GstElement *slow = haptic::add_element(film.pipeline(), "identity");
  GstElement *sink = haptic::add_element(film.pipeline(), "fakesink");
  g_object_set(slow, "sleep-time", 500'000, nullptr); // us
  g_object_set(sink, "sync", FALSE, "async", FALSE, nullptr);
  haptic::link_elements(queue, slow);
  haptic::link_elements(slow, sink);
  haptic::link_pad(film.video(), queue);
  const haptic::PadPtr end(gst_element_get_static_pad(sink, "sink"));
  if (watched)
    film.watch(end.get());
  film.play(2 * GST_SECOND);
}

TEST(FilmStreams, WorkThatGoesOnWhenAllIsReadIsProgress) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"jpegenc", "matroskamux"}))
    GTEST_SKIP() << "an element is missing";
  EXPECT_THROW(play_slowly(false), haptic::TrackFileError);
  EXPECT_NO_THROW(play_slowly(true));
}

TEST(FilmStreams, AFileFromWhichNothingComesIsRefused) {
  gst_init(nullptr, nullptr);
  gst_type_find_register(nullptr, "silent", GST_RANK_PRIMARY, find_silent, nullptr, nullptr,
                         nullptr, nullptr);
  gst_element_register(nullptr, "silentdemux", GST_RANK_PRIMARY, silent_demuxer_get_type());
  const test::ScratchFolder folder;
  const std::string path = folder.file("film.silent");
  std::ofstream(path) << "silent" << std::string(10'000, 'x');
  EXPECT_EQ(error_of([&] { haptic::FilmStreams(path, haptic::FilmUse::copy, GST_SECOND); }),
            haptic::format_text(haptic::messages::kFileStandsStill, 1));
}

// The last one: the process stays interrupted.
TEST(FilmStreams, AnInterruptionEndsTheReadingOfFilmsAndTracks) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"jpegenc", "matroskamux"}))
    GTEST_SKIP() << "an element is missing";
  const test::ScratchFolder folder;
  const std::string path = folder.file("film.mkv");
  test::run("videotestsrc num-buffers=1 ! jpegenc ! matroskamux ! filesink location=" + path);
  haptic::stop_when_interrupted();
  ASSERT_EQ(std::raise(SIGTERM), 0);
  EXPECT_EQ(error_of([&] { haptic::FilmStreams(path, haptic::FilmUse::copy); }),
            haptic::messages::kWorkIsInterrupted);
  EXPECT_EQ(error_of([&] { haptic::read_track_file(path); }), haptic::messages::kWorkIsInterrupted);
}

} // namespace film_streams_test
