// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink plays reliefs; what the hand touched is read from its log.
#include "virtual-sink.hpp"

#include "samples/relief-field.hpp"

#include <thread>

namespace hapticsink_touch_test {

using namespace test;

constexpr const char *kReliefCaps = HAPTIC_RELIEF_CAPS ", framerate=30/1";
constexpr double kDepth = 0.003 * 1000 / 1200; // m: 200 N/m against the 1000 N/m of the hand

haptic::ReliefField plane(float height = 0.003F) {
  haptic::ReliefField relief;
  relief.interval = kFrame;
  relief.frame_width = 352;
  relief.frame_height = 288;
  relief.columns = 8;
  relief.rows = 6;
  relief.cells.assign(48, {height, 500, 0, 1});
  return relief;
}

GstBuffer *packed(const haptic::ReliefField &relief, GstClockTime pts) {
  std::vector<std::uint8_t> bytes(haptic::packed_size(relief));
  haptic::pack_relief_field(relief, bytes);
  return test::packed(bytes, pts);
}

class HapticSinkTouch : public VirtualSink {
protected:
  void set_caps(const char *text) {
    const haptic::CapsPtr caps(gst_caps_from_string(text));
    gst_app_src_set_caps(GST_APP_SRC(source_.get()), caps.get());
  }
  void push_reliefs(const haptic::ReliefField &relief, double seconds) {
    for (int n = static_cast<int>(seconds * 30); n > 0; --n, pts_ += kFrame)
      push(packed(relief, pts_));
  }
  // A second source for the pad `relief`.
  void add_relief_source() {
    relief_source_ = gst_element_factory_make("appsrc", "reliefs");
    const haptic::CapsPtr caps(gst_caps_from_string(kReliefCaps));
    g_object_set(relief_source_, "format", GST_FORMAT_TIME, "caps", caps.get(), nullptr);
    gst_bin_add(GST_BIN(pipeline_.get()), relief_source_);
    ASSERT_TRUE(gst_element_link_pads(relief_source_, "src", sink_.get(), "relief"));
  }
  void push_beside(const haptic::ReliefField &relief, double seconds) {
    GstClockTime pts = 0;
    for (int n = static_cast<int>(seconds * 30); n > 0; --n, pts += kFrame)
      ASSERT_EQ(gst_app_src_push_buffer(GST_APP_SRC(relief_source_), packed(relief, pts)),
                GST_FLOW_OK);
    gst_app_src_end_of_stream(GST_APP_SRC(relief_source_));
  }

  GstElement *relief_source_ = nullptr;
};

TEST_F(HapticSinkTouch, AReliefAloneIsTouched) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  push_reliefs(plane(), 0.8);
  const Row row = row_at(play_and_read_log(), 0.7);
  EXPECT_NEAR(row.fz, 200 * kDepth, 0.02);
  EXPECT_NEAR(row.proxy[2], 0.003, 1e-4);
  EXPECT_EQ(row.touch, 1);
}

TEST_F(HapticSinkTouch, ReliefsBesideTheMotionAddTheirForce) {
  build_logging("touch=surface+motion");
  add_relief_source();
  push_motion(100, 0, 0.8);
  push_beside(plane(), 0.8);
  const Row row = row_at(play_and_read_log(), 0.7);
  EXPECT_NEAR(row.fz, 200 * kDepth, 0.02);
  EXPECT_NEAR(row.fx, 0.5, 0.02);
}

TEST_F(HapticSinkTouch, WithoutTouchReliefsAreThrownAway) {
  build_logging("");
  add_relief_source();
  push_motion(100, 0, 0.5);
  push_beside(plane(), 0.5);
  const Row row = row_at(play_and_read_log(), 0.4);
  EXPECT_EQ(row.fz, 0);
  EXPECT_NEAR(row.fx, 0.5, 1e-6);
  EXPECT_EQ(row.touch, 0);
}

TEST_F(HapticSinkTouch, HolesEverywhereAreSilence) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  haptic::ReliefField holes = plane();
  for (auto &cell : holes.cells)
    cell = {};
  push_reliefs(holes, 0.4);
  for (const Row &row : play_and_read_log())
    ASSERT_EQ(row.force(), 0);
}

TEST_F(HapticSinkTouch, ADamagedReliefIsSilenceAndOneWarning) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  push_reliefs(plane(std::numeric_limits<float>::quiet_NaN()), 0.2);
  push_reliefs(plane(1000), 0.2); // millimetres
  push_end();
  set(GST_STATE_PLAYING);
  const auto warning = message(GST_MESSAGE_WARNING);
  ASSERT_TRUE(warning);
  wait_for_end();
  EXPECT_EQ(count("bad-reliefs"), 12U);
  EXPECT_EQ(message(GST_MESSAGE_WARNING, false), nullptr);
  for (const Row &row : stop_and_read_log())
    ASSERT_EQ(row.force(), 0);
}

TEST_F(HapticSinkTouch, StopsWhileReliefsWait) {
  build_logging("touch=surface+motion");
  add_relief_source();
  push_motion(100, 0, 0.3);
  push_beside(plane(), 30);
  wait_for(GST_STATE_PAUSED);
  EXPECT_EQ(change(pipeline_.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
}

// The pad `relief`, fed by the test itself, so that events come where they are meant to.
class ReliefPadOf {
public:
  explicit ReliefPadOf(GstElement *sink)
      : sink_(sink), relief_(gst_element_request_pad_simple(sink, "relief")),
        source_(gst_pad_new("source", GST_PAD_SRC)) {
    gst_pad_set_active(source_, TRUE);
    gst_pad_link(source_, relief_);
    gst_pad_push_event(source_, gst_event_new_stream_start("reliefs"));
    const haptic::CapsPtr caps(gst_caps_from_string(kReliefCaps));
    gst_pad_push_event(source_, gst_event_new_caps(caps.get()));
    begin_segment();
  }
  ~ReliefPadOf() {
    release();
    gst_object_unref(source_);
  }
  ReliefPadOf(const ReliefPadOf &) = delete;
  ReliefPadOf &operator=(const ReliefPadOf &) = delete;

  GstFlowReturn push(const haptic::ReliefField &relief, GstClockTime pts) {
    return gst_pad_push(source_, packed(relief, pts));
  }
  void send(GstEvent *event) { EXPECT_TRUE(gst_pad_push_event(source_, event)); }
  void flush() {
    send(gst_event_new_flush_start());
    send(gst_event_new_flush_stop(FALSE));
    begin_segment();
  }
  void release() {
    if (!relief_)
      return;
    gst_element_release_request_pad(sink_, relief_);
    gst_object_unref(std::exchange(relief_, nullptr));
  }

private:
  void begin_segment() {
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(source_, gst_event_new_segment(&segment));
  }

  GstElement *sink_;
  GstPad *relief_;
  GstPad *source_;
};

constexpr double kSlewRate = 20; // N/s

// Whenever the ticks came. The force of a spring that the hand leaves goes with it.
void expect_within_slew_rate(const std::vector<Row> &rows) {
  constexpr double kStiffest = 200; // N/m
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double way =
        std::hypot(rows[i].x - rows[i - 1].x, rows[i].y - rows[i - 1].y, rows[i].z - rows[i - 1].z);
    const double released = rows[i].force() < rows[i - 1].force() ? kStiffest * way : 0;
    const double step = std::hypot(rows[i].fx - rows[i - 1].fx, rows[i].fy - rows[i - 1].fy,
                                   rows[i].fz - rows[i - 1].fz);
    ASSERT_LE(step, kSlewRate * (rows[i].mono - rows[i - 1].mono) + released + 1e-4)
        << rows[i].time << " s";
  }
}

TEST_F(HapticSinkTouch, AGapEventOnThePadReliefEndsTheSurface) {
  build_logging("touch=surface");
  push_motion(100, 0, 1);
  ReliefPadOf relief(sink_.get());
  set(GST_STATE_PLAYING);
  haptic::ReliefField slow = plane();
  slow.interval = 400'000'000; // is felt for 1.2 s
  complete([&] {
    EXPECT_EQ(relief.push(slow, 0), GST_FLOW_OK);
    relief.send(gst_event_new_gap(400'000'000, 400'000'000));
  });
  play_to_end();
  const auto rows = stop_and_read_log();
  EXPECT_GT(row_at(rows, 0.35).fz, 0.3);
  EXPECT_EQ(row_at(rows, 0.7).force(), 0);
  expect_within_slew_rate(rows);
}

TEST_F(HapticSinkTouch, AFlushOfTheReliefsAloneDiscardsThem) {
  build_logging("touch=surface+motion");
  push_motion(100, 0, 1);
  ReliefPadOf relief(sink_.get());
  set(GST_STATE_PLAYING);
  haptic::ReliefField slow = plane();
  slow.interval = GST_SECOND;
  complete([&] { EXPECT_EQ(relief.push(slow, 0), GST_FLOW_OK); });
  EXPECT_TRUE(advance_until([&] { return newest_row() && newest_row()->fz > 0.3; }));
  relief.flush();
  play_to_end();
  const auto rows = stop_and_read_log();
  const Row row = row_at(rows, 0.9);
  EXPECT_NEAR(row.fz, 0, 1e-6);
  EXPECT_NEAR(row.fx, 0.5, 0.02);
  expect_within_slew_rate(rows);
}

TEST_F(HapticSinkTouch, AfterASeekReliefsWaitUntilTheTimeIsKnown) {
  build_logging("touch=surface+motion");
  push_motion(100, 0, 1);
  ReliefPadOf relief(sink_.get());
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 15; }));
  flush();
  relief.flush();
  std::thread source([&] {
    for (GstClockTime pts = 0; relief.push(plane(), pts) == GST_FLOW_OK;)
      pts += kFrame;
  });
  advance(100ms);
  EXPECT_EQ(count("reliefs"), 0U) << "the clocks are related as before the seek";
  stop();
  source.join();
}

TEST_F(HapticSinkTouch, APadOfReliefsMayFollowARunThatHadThemOnThePadSink) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  push_reliefs(plane(), 0.1);
  play_to_end();
  stop();
  GstPad *pad = gst_element_request_pad_simple(sink_.get(), "relief");
  ASSERT_NE(pad, nullptr);
  gst_element_release_request_pad(sink_.get(), pad);
  gst_object_unref(pad);
}

TEST_F(HapticSinkTouch, ThereIsOnePadForReliefsWhoeverAsks) {
  build("device=none");
  GstPadTemplate *of = gst_element_get_pad_template(sink_.get(), "relief");
  for (int n = 0; n < 200; ++n) {
    std::atomic<GstPad *> got = nullptr;
    std::atomic<int> pads = 0;
    std::atomic<bool> go = false;
    {
      std::vector<std::jthread> threads;
      for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] {
          while (!go) {
          }
          if (GstPad *pad = gst_element_request_pad(sink_.get(), of, nullptr, nullptr)) {
            ++pads;
            got = pad;
          }
        });
      go = true;
    }
    ASSERT_EQ(pads, 1);
    gst_element_release_request_pad(sink_.get(), got);
    gst_object_unref(got.load());
  }
}

TEST_F(HapticSinkTouch, ThePadIsReleasedWhileAReliefWaitsInIt) {
  build("device=sim touch=surface");
  push_motion(100, 0, 1);
  set(GST_STATE_PLAYING);
  for (int n = 0; n < 30; ++n) {
    ReliefPadOf relief(sink_.get());
    std::jthread pusher([&] {
      for (GstClockTime pts = 0; relief.push(plane(), pts) == GST_FLOW_OK; pts += GST_SECOND) {
      }
    });
    advance(std::chrono::milliseconds(n % 7));
    relief.release();
  }
  EXPECT_EQ(change(pipeline_.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
}

TEST_F(HapticSinkTouch, AFilmThatLosesItsDepthInTheMiddleIsFeltBeforeAndAfter) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  push_reliefs(plane(), 0.5);
  for (int n = 0; n < 18; ++n, pts_ += kFrame) {
    GstBuffer *gap = packed(plane(), pts_);
    GST_BUFFER_FLAG_SET(gap, GST_BUFFER_FLAG_GAP);
    push(gap);
  }
  push_reliefs(plane(), 0.6);
  const auto rows = play_and_read_log();
  EXPECT_GT(row_at(rows, 0.45).fz, 0.3);
  EXPECT_EQ(row_at(rows, 1.0).force(), 0);
  EXPECT_GT(row_at(rows, 1.6).fz, 0.3);
  expect_within_slew_rate(rows);
}

TEST_F(HapticSinkTouch, DiscontinuitiesAndCutsKeepTheSlewRate) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  for (int n = 0; n < 60; ++n, pts_ += kFrame) {
    haptic::ReliefField relief = plane(n / 5 % 2 ? 0.015F : 0.002F);
    if (n % 5 == 0)
      relief.flags = n % 10 ? haptic::kMotionCut : haptic::kMotionDiscontinuity;
    push(packed(relief, pts_));
    if (n == 30)
      pts_ += 10 * kFrame;
  }
  expect_within_slew_rate(play_and_read_log());
}

// Motion and reliefs of one film, or reliefs alone.
class HapticSinkSeeks : public VirtualSink, public ::testing::WithParamInterface<bool> {
protected:
  static constexpr const char *kDepth = "depthfield kind=disparity scale=255 near=1 far=255";

  void build_film() {
    for (const char *name : {"depthfield", "motionfield"}) {
      const ElementPtr element(gst_element_factory_make(name, nullptr));
      if (!element)
        GTEST_SKIP() << "no element " << name;
    }
    std::string line = "videotestsrc pattern=gradient ! video/x-raw,format=GRAY8,width=64,"
                       "height=48,framerate=30/1 ! ";
    const std::string sink = " ! hapticsink name=sink device=sim sim-hand=hold:0.1,0,-0.3 "
                             "log-location=" +
                             log_.string();
    if (GetParam())
      line += "tee name=t ! queue ! motionfield" + sink + " touch=surface+motion t. ! queue ! " +
              kDepth + " ! sink.relief";
    else
      line += kDepth + sink + " touch=surface";
    GError *error = nullptr;
    pipeline_.reset(gst_parse_launch(line.c_str(), &error));
    ASSERT_EQ(error, nullptr) << error->message;
    sink_.reset(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "sink"));
    set_clock(pipeline_.get());
  }
};
INSTANTIATE_TEST_SUITE_P(Touch, HapticSinkSeeks, testing::Bool(), [](const auto &of) {
  return of.param ? "MotionAndReliefs" : "ReliefsAlone";
});

TEST_P(HapticSinkSeeks, TwoHundredSeeksKeepTheSlewRate) {
  build_film();
  if (IsSkipped())
    return;
  wait_for(GST_STATE_PLAYING);
  std::mt19937 random(5);
  for (int n = 0; n < 200; ++n) {
    const auto to = static_cast<gint64>(random() % 20'000) * GST_MSECOND;
    ASSERT_TRUE(gst_element_seek_simple(pipeline_.get(), GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, to))
        << n;
    advance(std::chrono::milliseconds(random() % 30));
  }
  wait_for_change();
  EXPECT_TRUE(advance_until([&] { return newest_row() && newest_row()->force() > 0.05; }));
  expect_within_slew_rate(stop_and_read_log());
}

TEST_P(HapticSinkSeeks, EveryChangeOfStateKeepsTheSlewRate) {
  build_film();
  if (IsSkipped())
    return;
  for (const GstState state : {GST_STATE_PLAYING, GST_STATE_PAUSED, GST_STATE_PLAYING,
                               GST_STATE_READY, GST_STATE_PAUSED, GST_STATE_PLAYING}) {
    wait_for(state);
    advance(150ms);
  }
  EXPECT_TRUE(advance_until([&] { return newest_row() && newest_row()->force() > 0.05; }));
  expect_within_slew_rate(stop_and_read_log());
}

// Reliefs may come from a file of their own.
TEST_F(HapticSinkTouch, ASeekReachesBothSources) {
  build("device=none touch=surface");
  std::atomic<int> seeks = 0;
  const auto count_seek = [](GstPad *, GstPadProbeInfo *info, gpointer data) {
    if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_SEEK)
      ++*static_cast<std::atomic<int> *>(data);
    return GST_PAD_PROBE_OK;
  };
  add_relief_source();
  for (GstElement *source : {source_.get(), relief_source_}) {
    GstPad *pad = gst_element_get_static_pad(source, "src");
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_EVENT_UPSTREAM, count_seek, &seeks, nullptr);
    gst_object_unref(pad);
  }
  push_motion(100, 0, 0.2);
  wait_for(GST_STATE_PAUSED);
  gst_element_seek_simple(pipeline_.get(), GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, 0);
  EXPECT_EQ(seeks, 2);
}

TEST_F(HapticSinkTouch, APadForReliefsIsActiveFromThePrerollToTheStop) {
  build("device=none");
  EXPECT_EQ(gst_element_set_state(sink_.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_ASYNC)
      << "nothing has come yet";
  const haptic::PadPtr relief(gst_element_request_pad_simple(sink_.get(), "relief"));
  ASSERT_TRUE(relief);
  EXPECT_TRUE(GST_PAD_IS_ACTIVE(relief.get()));
  EXPECT_EQ(gst_element_request_pad(
                sink_.get(), gst_element_get_pad_template(sink_.get(), "relief"), nullptr, nullptr),
            nullptr)
      << "there is one";
  change(sink_.get(), GST_STATE_READY);
  EXPECT_FALSE(GST_PAD_IS_ACTIVE(relief.get()));
  gst_element_release_request_pad(sink_.get(), relief.get());
}

TEST_F(HapticSinkTouch, AForceThatIsNoNumberIsRefused) {
  build("device=none max-force=0.5");
  // Newer versions of GLib refuse it themselves, with a critical warning.
  const GLogLevelFlags fatal =
      g_log_set_always_fatal(static_cast<GLogLevelFlags>(G_LOG_FATAL_MASK));
  g_object_set(sink_.get(), "max-force", std::numeric_limits<double>::quiet_NaN(), nullptr);
  g_log_set_always_fatal(fatal);
  gdouble force = 0;
  g_object_get(sink_.get(), "max-force", &force, nullptr);
  EXPECT_EQ(force, 0.5);
}

} // namespace hapticsink_touch_test
