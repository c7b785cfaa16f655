// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/film-streams.hpp"

#include "film/copied-stream.hpp"
#include "film/pipeline.hpp"
#include "track-pipeline.hpp"

#include <gtest/gtest.h>

namespace {

// A film that is read at once, and whose frames then take half a second each.
void play_slowly(bool watched) {
  const test::ScratchFolder folder;
  const std::string path = folder.file("film.mkv");
  test::run("videotestsrc num-buffers=10 ! video/x-raw,width=64,height=48,framerate=10/1 "
            "! jpegenc ! matroskamux ! filesink location=" +
            path);
  haptic::FilmStreams film(path, haptic::FilmUse::decode, [] {});
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
  film.play([] {}, 2 * GST_SECOND);
}

TEST(FilmStreams, WorkThatGoesOnWhenAllIsReadIsProgress) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"jpegenc", "matroskamux"}))
    GTEST_SKIP() << "an element is missing";
  EXPECT_THROW(play_slowly(false), haptic::TrackFileError);
  EXPECT_NO_THROW(play_slowly(true));
}

} // namespace
