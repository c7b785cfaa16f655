// SPDX-License-Identifier: LGPL-2.1-or-later
// The pointer on its way over a network: pointerextract at the hand, pointerinject at the tracker.
#include "eventually.hpp"
#include "forms/klv.hpp"
#include "glue/pointer-event.hpp"
#include "track-pipeline.hpp"

#include <cstring>
#include <gst/app/gstappsink.h>
#include <gst/check/gstharness.h>
#include <gtest/gtest.h>
#include <memory>

namespace pointer_test {

using haptic::BufferPtr;
using haptic::PointerPosition;
using haptic::TrackPointer;

struct Teardown {
  void operator()(GstHarness *harness) const { gst_harness_teardown(harness); }
};
using Harness = std::unique_ptr<GstHarness, Teardown>;

PointerPosition position(double x, double y) {
  PointerPosition p;
  p.x = x;
  p.y = y;
  p.z = -0.25;
  p.pressed = true;
  p.device = "test";
  return p;
}

BufferPtr buffer_of(const TrackPointer &pointer) {
  const auto bytes = write_klv(pointer);
  BufferPtr buffer(gst_buffer_new_allocate(nullptr, bytes.size(), nullptr));
  gst_buffer_fill(buffer.get(), 0, bytes.data(), bytes.size());
  return buffer;
}

class PointerTravel : public testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  PointerTravel()
      : extract(gst_harness_new_with_padnames("pointerextract", "sink", "src")),
        extracted(gst_harness_new_with_element(extract->element, nullptr, "pointer")),
        inject(gst_harness_new_with_padnames("pointerinject", "sink", "src")),
        injected(gst_harness_new_with_element(inject->element, "pointer", nullptr)) {
    gst_harness_set_src_caps_str(extract.get(), "haptics/x-raw");
    gst_harness_set_src_caps_str(inject.get(), "video/x-raw");
    gst_harness_set_src_caps_str(injected.get(), "meta/x-klv, parsed=true");
  }

  // The next pointer event that leaves pointerinject towards the tracker.
  std::optional<PointerPosition> arrived() {
    while (GstEvent *event = gst_harness_try_pull_upstream_event(inject.get())) {
      const haptic::EventPtr owned(event);
      if (const auto p = haptic::parse_pointer_event(event))
        return p;
    }
    return std::nullopt;
  }

  Harness extract, extracted, inject, injected;
};

TEST_F(PointerTravel, WhatTheHandDoesArrivesAtTheTracker) {
  for (int i = 0; i < 50; ++i) {
    PointerPosition sent = position(i / 50.0, 1 - i / 60.0);
    sent.pressed = i % 3 == 0; // a button that is released has to arrive, too
    ASSERT_TRUE(gst_harness_push_upstream_event(extract.get(), make_pointer_event(sent).release()));
    gst_harness_push(injected.get(), gst_harness_pull(extracted.get()));
    const auto got = arrived();
    ASSERT_TRUE(got);
    EXPECT_EQ(got->x, sent.x);
    EXPECT_EQ(got->y, sent.y);
    EXPECT_EQ(got->z, sent.z);
    EXPECT_EQ(got->pressed, sent.pressed);
    EXPECT_EQ(got->device, sent.device);
  }
}

TEST_F(PointerTravel, NewerNumbersArriveAlsoWhenTheyGoRound) {
  for (const std::uint32_t sequence : {0xFFFFFFFEU, 0xFFFFFFFFU, 0U, 5U}) {
    gst_harness_push(injected.get(), buffer_of({sequence, 0.5, 0.5, 0, false, ""}).release());
    EXPECT_TRUE(arrived()) << sequence;
  }
}

TEST_F(PointerTravel, WhatIsNoPointerIsPassedOver) {
  for (const char *text : {"", "x", "\x06\x0e\x2b\x34 nonsense that begins like KLV"}) {
    BufferPtr buffer(gst_buffer_new_wrapped(g_strdup(text), std::strlen(text)));
    EXPECT_EQ(gst_harness_push(injected.get(), buffer.release()), GST_FLOW_OK);
  }
  EXPECT_FALSE(arrived());
}

TEST_F(PointerTravel, TheStreamBesideItPassesUntouched) {
  for (const auto &harness : {&extract, &inject}) {
    GstBuffer *sent = gst_buffer_new_allocate(nullptr, 10, nullptr);
    GST_BUFFER_PTS(sent) = 5;
    EXPECT_EQ(gst_harness_push(harness->get(), sent), GST_FLOW_OK);
    const BufferPtr got(gst_harness_pull(harness->get()));
    EXPECT_EQ(got.get(), sent);
  }
  const auto *other = "other";
  gst_harness_push_upstream_event(
      extract.get(),
      gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM, gst_structure_new_empty(other)));
  bool passed = false;
  while (GstEvent *event = gst_harness_try_pull_upstream_event(extract.get())) {
    passed = passed || gst_event_has_name(event, other);
    gst_event_unref(event);
  }
  EXPECT_TRUE(passed) << "only pointers are taken";
}

TEST_F(PointerTravel, TheEndOfThePointerIsNotTheEndOfTheVideo) {
  gst_harness_push_event(injected.get(), gst_event_new_eos());
  EXPECT_EQ(gst_harness_push(inject.get(), gst_buffer_new()), GST_FLOW_OK);
}

TEST_F(PointerTravel, TheEndOfTheTrackEndsThePointer) {
  gst_harness_push_event(extract.get(), gst_event_new_eos());
  bool ended = false;
  while (!ended) {
    GstEvent *event = gst_harness_pull_event(extracted.get()); // none after a minute
    ASSERT_NE(event, nullptr);
    ended = GST_EVENT_TYPE(event) == GST_EVENT_EOS;
    gst_event_unref(event);
  }
}

// After a seek, or when another stream follows.
TEST_F(PointerTravel, PointersComeAgainAfterTheEnd) {
  const auto sent = position(0.25, 0.5);
  const auto ends = [&] {
    gst_harness_push_event(extract.get(), gst_event_new_eos());
    while (const haptic::EventPtr event{gst_harness_pull_event(extracted.get())})
      if (GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS)
        return true;
    return false;
  };
  const auto arrives = [&] {
    gst_harness_push_upstream_event(extract.get(), make_pointer_event(sent).release());
    const BufferPtr buffer(gst_harness_pull(extracted.get())); // none after a minute
    return buffer != nullptr;
  };
  ASSERT_TRUE(ends());
  gst_harness_push_event(extract.get(), gst_event_new_flush_start());
  gst_harness_push_event(extract.get(), gst_event_new_flush_stop(TRUE));
  EXPECT_TRUE(arrives()) << "after a flushing seek";
  ASSERT_TRUE(ends());
  gst_harness_push_event(extract.get(), gst_event_new_stream_start("another"));
  EXPECT_TRUE(arrives()) << "of another stream";
}

TEST(PointerElements, AfterTheEndASeekLetsASinkHavePointersAgain) {
  gst_init(nullptr, nullptr);
  const test::Pipeline pipeline("videotestsrc ! pointerextract name=p ! fakesink name=main "
                                "p.pointer ! appsink name=pointers async=false sync=false");
  const auto element = [&](const char *name) {
    return haptic::ElementPtr(gst_bin_get_by_name(GST_BIN(pipeline.get()), name));
  };
  const haptic::PadPtr main(gst_element_get_static_pad(element("main").get(), "sink"));
  const haptic::ElementPtr pointers = element("pointers");
  const auto seek = [&](GstClockTime end) {
    return gst_element_seek(pipeline.get(), 1, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH,
                            GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, static_cast<gint64>(end));
  };
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  gst_element_get_state(pipeline.get(), nullptr, nullptr, 10 * GST_SECOND);
  EXPECT_TRUE(seek(GST_SECOND));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const haptic::BusPtr bus(gst_element_get_bus(pipeline.get()));
  const haptic::MessagePtr end(
      gst_bus_timed_pop_filtered(bus.get(), 10 * GST_SECOND, GST_MESSAGE_EOS));
  ASSERT_NE(end, nullptr);
  EXPECT_TRUE(seek(GST_CLOCK_TIME_NONE));
  EXPECT_TRUE(test::eventually([&] {
    gst_pad_push_event(main.get(), make_pointer_event(position(0.25, 0.5)).release());
    GstSample *sample =
        gst_app_sink_try_pull_sample(GST_APP_SINK(pointers.get()), 10 * GST_MSECOND);
    if (sample)
      gst_sample_unref(sample);
    return sample != nullptr;
  }));
  const haptic::MessagePtr error(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  EXPECT_EQ(error, nullptr);
}

TEST(PointerElements, StartAndStopAtOnceManyTimes) {
  gst_init(nullptr, nullptr);
  for (int i = 0; i < 200; ++i) {
    GstElement *pipeline = gst_parse_launch(
        "fakesrc num-buffers=3 ! pointerextract name=p ! fakesink p.pointer ! fakesink async=false",
        nullptr);
    ASSERT_NE(pipeline, nullptr);
    gst_element_set_state(pipeline, i % 2 ? GST_STATE_PLAYING : GST_STATE_PAUSED);
    EXPECT_EQ(gst_element_set_state(pipeline, GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
    gst_object_unref(pipeline);
  }
}

TEST(PointerElements, OfferNoPullingOfTheFileBehindThem) {
  gst_init(nullptr, nullptr);
  for (const std::string name : {"pointerextract", "pointerinject"}) {
    const test::Pipeline pipeline("filesrc location=" SOURCE_ROOT "/tests/data/golden.hmpg ! " +
                                  name + " name=e ! fakesink");
    gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
    gst_element_get_state(pipeline.get(), nullptr, nullptr, 10 * GST_SECOND);
    const haptic::ElementPtr element(gst_bin_get_by_name(GST_BIN(pipeline.get()), "e"));
    const haptic::PadPtr pad(gst_element_get_static_pad(element.get(), "src"));
    const haptic::QueryPtr query(gst_query_new_scheduling());
    EXPECT_FALSE(gst_pad_query(pad.get(), query.get()) &&
                 gst_query_has_scheduling_mode(query.get(), GST_PAD_MODE_PULL))
        << name;
  }
}

// The message comes when all sinks have a stream. It has a group if all are of one.
TEST(PointerElements, APipelineBeginsBeforeAHandPoints) {
  gst_init(nullptr, nullptr);
  const test::Pipeline pipeline("appsrc ! pointerextract name=p ! fakesink async=false "
                                "p.pointer ! fakesink async=false");
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const haptic::BusPtr bus(gst_element_get_bus(pipeline.get()));
  const haptic::MessagePtr begin(
      gst_bus_timed_pop_filtered(bus.get(), 10 * GST_SECOND, GST_MESSAGE_STREAM_START));
  ASSERT_NE(begin, nullptr);
  guint group = GST_GROUP_ID_INVALID;
  EXPECT_TRUE(gst_message_parse_group_id(begin.get(), &group));
}

} // namespace pointer_test
