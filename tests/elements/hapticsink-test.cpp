// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink in small pipelines, with the simulated device; what it did is read from its log.
#include "virtual-sink.hpp"

#include "glue/pointer-event.hpp"

#include <array>
#include <gst/check/gstharness.h>
#include <gst/controller/gstdirectcontrolbinding.h>
#include <gst/controller/gstinterpolationcontrolsource.h>
#include <limits>
#include <random>
#include <thread>

namespace hapticsink_test {

using namespace std::chrono_literals;
using namespace test;

constexpr std::int64_t kMs = 1'000'000; // ns

class HapticSink : public VirtualSink {};

// ---- what is felt -------------------------------------------------------------------------------

TEST_F(HapticSink, TheForceOnTheLogIsEquation5OfTheVelocity) {
  build_logging();
  const std::array<double, 3> speeds = {20, 100, 400};
  for (double v : speeds)
    push_motion(v, 0, 0.5);
  push_motion(0, -100, 0.5); // up
  push_motion(-60, 80, 0.5); // left and down
  const auto rows = play_and_read_log();
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const Row row = row_at(rows, 0.5 * static_cast<double>(i) + 0.4);
    EXPECT_EQ(row.vx, speeds[i]);
    EXPECT_NEAR(row.fx, equation5(speeds[i]), 0.02) << speeds[i] << " px/s";
    EXPECT_EQ(row.fy, 0);
  }
  EXPECT_NEAR(row_at(rows, 1.9).fx, 0, 1e-9);
  EXPECT_NEAR(row_at(rows, 1.9).fy, 0.5, 0.02); // up on the screen is up in the hand
  EXPECT_NEAR(row_at(rows, 2.4).fx, -0.6 * 0.5, 0.02);
  EXPECT_NEAR(row_at(rows, 2.4).fy, -0.8 * 0.5, 0.02);
}

TEST_F(HapticSink, TheLogIsFiniteOrderedAndWithinEveryLimit) {
  build_logging("max-force=0.7 force-law=arctan-axis");
  for (int i = 0; i < 8; ++i)
    push_motion(i % 2 ? -2000 : 2000, i % 3 ? 2000 : -2000, 0.1);
  const auto rows = play_and_read_log();
  ASSERT_GT(rows.size(), 500U);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Row &before = rows[i - 1];
    const Row &now = rows[i];
    ASSERT_GE(now.time, before.time);
    ASSERT_LE(now.force(), 0.7 + 1e-8);
    const double step = std::hypot(now.fx - before.fx, now.fy - before.fy);
    ASSERT_LE(step, 20 * (now.time - before.time) + 1e-6) << "at " << now.time << " s";
    for (double tension : now.t) {
      ASSERT_GT(tension, 0.2);
      ASSERT_LE(tension, 5.0);
    }
  }
  EXPECT_EQ(rows.back().force(), 0);
}

TEST_F(HapticSink, AStalledSourceFadesToZeroOnceItsLastSampleIsStale) {
  build_logging();
  push_motion(100, 0, 0.5);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") == 15; }));
  ASSERT_TRUE(advance_until([&] {
    const auto row = newest_row();
    return row && row->held(kHeldStale) && row->force() == 0;
  }));
  const auto rows = stop_and_read_log();
  expect_fade(rows, kHeldStale, 0.1);
  const auto stale = std::ranges::find_if(rows, [](const Row &r) { return r.held(kHeldStale); });
  EXPECT_GT(stale->time, 14.0 / 30 + 0.1); // three intervals after the last sample
  EXPECT_NEAR(std::prev(stale)->fx, 0.5, 1e-6);
}

TEST_F(HapticSink, APauseFadesToZeroIn100Milliseconds) {
  build_logging();
  push_motion(100, 0, 3);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 15; }));
  wait_for(GST_STATE_PAUSED);
  ASSERT_TRUE(advance_until([&] { return newest_row()->force() == 0; }));
  const auto rows = stop_and_read_log();
  expect_fade(rows, kHeldPaused, 0.1);
  const double frozen = rows.back().time;
  for (const Row &row : rows)
    if (row.held(kHeldPaused)) {
      ASSERT_NEAR(row.time, frozen, 0.001); // running time stands still
    }
}

TEST_F(HapticSink, APauseWaitsForNoSample) { // the next may be held up behind a paused video sink
  build("device=sim");
  push_motion(100, 0, 0.5);
  wait_for(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") + count("gaps") == 15; }));
  wait_for(GST_STATE_PAUSED);
  push_motion(100, 0, 0.5);
  push_end();
  wait_for(GST_STATE_PLAYING);
  wait_for_end();
}

TEST_F(HapticSink, AfterAPausePlayingWaitsForNoSample) {
  build("device=sim");
  push_motion(100, 0, 0.5);
  wait_for(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") + count("gaps") == 15; }));
  wait_for(GST_STATE_PAUSED);
  wait_for(GST_STATE_PLAYING);
  push_motion(100, 0, 0.5);
  push_end();
  wait_for_end();
}

TEST_F(HapticSink, AfterAPauseTheForceComesBackAndTheTimeGoesOn) {
  build_logging();
  push_motion(100, 0, 2);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 10; }));
  wait_for(GST_STATE_PAUSED);
  advance(400ms);
  const auto rows = play_and_read_log();
  for (std::size_t i = 1; i < rows.size(); ++i)
    ASSERT_GE(rows[i].time, rows[i - 1].time);
  EXPECT_NEAR(rows.back().mono - (rows.back().time - rows.front().time), 0.4, 1e-6); // the pause
  EXPECT_NEAR(last_free_row(rows).fx, 0.5, 1e-6);
}

TEST_F(HapticSink, TheEndFadesToZeroIn100MillisecondsAndBeforeTheMessage) {
  build_logging();
  push_motion(100, 0, 0.5);
  const auto rows = play_and_read_log(); // at once, as gst-launch-1.0 does
  expect_fade(rows, kHeldEnded, 0.1);
  EXPECT_EQ(rows.back().force(), 0);
}

TEST_F(HapticSink, APauseWhileItFadesAtTheEndOnlyDelaysTheEnd) {
  for (const auto pause_at : {440ms, 480ms, 520ms, 560ms, 600ms}) {
    build("device=sim");
    pts_ = 0;
    push_motion(100, 0, 0.5);
    push_end();
    wait_for(GST_STATE_PLAYING);
    advance(pause_at);
    wait_for(GST_STATE_PAUSED);
    advance(20ms);
    set(GST_STATE_PLAYING);
    wait_for_end();
    stop();
  }
}

// The end waits up to 1 s for the handler of hapticsink-stats, but nothing else waits for the end.
TEST_F(HapticSink, AStateChangeAtTheEndWaitsForNoHandler) {
  struct Handler {
    std::atomic<bool> runs = false;
    std::atomic<bool> may_end = false;
  } handler;
  build("device=sim");
  push_motion(100, 0, 0.1);
  push_end();
  set_sync_handler(
      [](GstBus *, GstMessage *message, gpointer data) {
        auto *of = static_cast<Handler *>(data);
        if (gst_message_has_name(message, "hapticsink-stats")) {
          of->runs = true;
          of->may_end.wait(false);
          of->runs = false;
        }
        return GST_BUS_PASS;
      },
      &handler);
  const auto let_it_end = [&] {
    handler.may_end = true;
    handler.may_end.notify_all();
  };
  const AtEnd ends([&] {
    let_it_end();
    stop();
    set_sync_handler(nullptr);
  });
  wait_for(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return handler.runs.load(); }));
  const std::int64_t before = clock_.now();
  for (int i = 0; i < 100; ++i) {
    set(GST_STATE_PAUSED);
    EXPECT_FALSE(message(GST_MESSAGE_EOS, false));
    set(GST_STATE_PLAYING);
    EXPECT_FALSE(message(GST_MESSAGE_EOS, false));
  }
  EXPECT_EQ(clock_.now(), before); // none of them had to wait
  advance(900ms);
  EXPECT_FALSE(message(GST_MESSAGE_EOS, false));
  EXPECT_TRUE(handler.runs);
  let_it_end();
  wait_for_end();
}

// The handler of the first end still runs when the second one comes.
TEST_F(HapticSink, AfterASeekTheEndWaitsForItsOwnHandler) {
  struct Handler {
    std::atomic<int> begun = 0;
    std::atomic<int> ended = 0;
    std::atomic<bool> may_end = false;
    std::atomic<int> ended_before_the_end = 0;
    VirtualClock &clock;
  } handler{.clock = clock_};
  build_logging();
  push_motion(100, 0, 0.1);
  push_end();
  set_sync_handler(
      [](GstBus *, GstMessage *message, gpointer data) {
        auto *of = static_cast<Handler *>(data);
        if (gst_message_has_name(message, "hapticsink-stats")) {
          if (++of->begun == 1)
            of->may_end.wait(false);
          else
            of->clock.wait_until(of->clock.now() + 30 * kMs);
          ++of->ended;
        }
        if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS)
          of->ended_before_the_end = of->ended.load();
        return GST_BUS_PASS;
      },
      &handler);
  const auto let_it_end = [&] {
    handler.may_end = true;
    handler.may_end.notify_all();
  };
  const AtEnd ends([&] {
    let_it_end();
    stop();
    set_sync_handler(nullptr);
  });
  wait_for(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return handler.begun == 1; }));
  flush();
  const haptic::PadPtr pad(gst_element_get_static_pad(sink_.get(), "sink"));
  std::jthread second_end([&] { gst_pad_send_event(pad.get(), gst_event_new_eos()); });
  advance(50ms); // it waits for its handler now
  let_it_end();
  complete([&] { second_end.join(); });
  wait_for_end();
  EXPECT_EQ(handler.ended_before_the_end, 2);
}

TEST_F(HapticSink, AFlushFadesToZeroIn50Milliseconds) {
  build_logging();
  push_motion(100, 0, 3);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 15; }));
  flush();
  const auto rows = stop_and_read_log();
  expect_fade(rows, kHeldFlushing, 0.05);
  EXPECT_EQ(rows.back().force(), 0);
}

TEST_F(HapticSink, GapsAreFeltAsNothing) {
  build_logging();
  push_motion(100, 0, 0.5);
  for (int i = 0; i < 15; ++i, pts_ += kFrame)
    push(gap(pts_));
  play_to_end();
  EXPECT_EQ(count("samples"), 15U);
  EXPECT_EQ(count("gaps"), 15U);
  for (const Row &row : stop_and_read_log())
    if (row.time > 0.5 + 0.12) {
      ASSERT_EQ(row.force(), 0) << row.time;
    }
}

TEST_F(HapticSink, AGapEventIsFeltAsNothing) {
  build_logging();
  push_motion(100, 0, 0.5);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") == 15; }));
  const haptic::PadPtr pad(gst_element_get_static_pad(source_.get(), "src"));
  complete([&] { gst_pad_push_event(pad.get(), gst_event_new_gap(pts_, kFrame)); });
  EXPECT_EQ(count("gaps"), 1U);
  EXPECT_TRUE(advance_until([&] {
    const auto row = newest_row();
    return row && row->held(kHeldGap) && row->force() == 0;
  }));
  const auto rows = stop_and_read_log();
  const Row last = last_free_row(rows);
  EXPECT_GT(last.force(), 0.1);
  for (const Row &row : rows)
    if (row.mono > last.mono) {
      EXPECT_TRUE(row.held(kHeldGap) && !row.held(kHeldStale)) << row.mono;
      break;
    }
}

TEST_F(HapticSink, GarbageIsNeverAForceAndIsWarnedOfOnce) {
  build_logging();
  MotionSample nan = moving(100, 0);
  nan.velocity_y = std::numeric_limits<float>::quiet_NaN();
  MotionSample huge = moving(1e30, -1e30);
  for (int i = 0; i < 10; ++i, pts_ += kFrame)
    push(packed(i % 2 ? nan : huge, pts_));
  GstBuffer *cut = gst_buffer_new_allocate(nullptr, 7, nullptr);
  gst_buffer_memset(cut, 0, 0x55, 7);
  GST_BUFFER_PTS(cut) = pts_;
  push(cut);
  GstBuffer *empty = gst_buffer_new();
  GST_BUFFER_PTS(empty) = pts_ + kFrame;
  push(empty);
  push_end();
  set(GST_STATE_PLAYING);
  int warnings = 0;
  for (;;) {
    const auto found = message(
        static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR | GST_MESSAGE_WARNING));
    ASSERT_TRUE(found);
    ASSERT_NE(GST_MESSAGE_TYPE(found.get()), GST_MESSAGE_ERROR);
    if (GST_MESSAGE_TYPE(found.get()) == GST_MESSAGE_EOS)
      break;
    ++warnings;
  }
  EXPECT_EQ(warnings, 1);
  EXPECT_EQ(count("bad-samples"), 12U);
  EXPECT_EQ(number("force-max"), 0);
  for (const Row &row : stop_and_read_log())
    ASSERT_EQ(row.force(), 0);
}

TEST_F(HapticSink, TheLastChangeOfAPropertyIsFelt) {
  build_logging();
  push_motion(100, 0, 60);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 10; }));
  g_object_set(sink_.get(), "max-force", 2.0, "alpha", 0.02, "reference-width", 176U, nullptr);
  // Half the speed at twice the steepness.
  EXPECT_TRUE(
      advance_until([&] { return std::abs(newest_row()->fx - 2 * equation5(100)) < 1e-6; }));
}

TEST_F(HapticSink, AControllerChangesTheStrengthAlongTheStream) {
  build_logging();
  GstControlSource *source = gst_interpolation_control_source_new();
  auto *timed = GST_TIMED_VALUE_CONTROL_SOURCE(source);
  // Of the range from 0 to 5 N; each value holds until the next.
  gst_timed_value_control_source_set(timed, 0, 0.1);
  gst_timed_value_control_source_set(timed, GST_SECOND, 0.4);
  gst_object_add_control_binding(
      GST_OBJECT(sink_.get()),
      gst_direct_control_binding_new(GST_OBJECT(sink_.get()), "max-force", source));
  gst_object_unref(source);
  push_motion(100, 0, 2);
  play_to_end();
  double strongest = 0;
  for (const Row &row : stop_and_read_log()) {
    strongest = std::max(strongest, row.fx);
    ASSERT_LE(row.fx, (row.time < 0.5 ? 0.5 : 2) * equation5(100) + 1e-6) << row.time << " s";
  }
  EXPECT_NEAR(strongest, 2 * equation5(100), 1e-3);
}

TEST_F(HapticSink, RandomPropertyChangesWhileItRunsBreakNothing) {
  build_logging();
  push_motion(300, -200, 3);
  set(GST_STATE_PLAYING);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (int i = 0; i < 1000; ++i) {
    switch (random() % 6) {
    case 0:
      g_object_set(sink_.get(), "max-force", 5 * fraction(random), nullptr);
      break;
    case 1:
      g_object_set(sink_.get(), "alpha", 10 * fraction(random), nullptr);
      break;
    case 2:
      g_object_set(sink_.get(), "reference-width", static_cast<guint>(random() % 65536), nullptr);
      break;
    case 3:
      g_object_set(sink_.get(), "slew-rate", 0.1 + 100 * fraction(random), nullptr);
      break;
    case 4:
      gst_util_set_object_arg(G_OBJECT(sink_.get()), "force-law",
                              std::to_string(random() % 5).c_str());
      break;
    default:
      gst_util_set_object_arg(G_OBJECT(sink_.get()), "latency-mode",
                              std::to_string(random() % 3).c_str());
    }
    advance(1ms);
  }
  EXPECT_LE(number("force-max"), 5);
  EXPECT_EQ(count("faults"), 0U); // the log has 0 for what is not finite
  for (const Row &row : stop_and_read_log()) {
    ASSERT_LE(row.force(), 5 + 1e-6);
  }
}

// ---- arming -------------------------------------------------------------------------------------

TEST_F(HapticSink, IsArmedWhenItsDeviceIsOpen) {
  build("device=sim");
  EXPECT_FALSE(armed());
  wait_for(GST_STATE_READY);
  EXPECT_TRUE(armed());
  stop();
  EXPECT_FALSE(armed());
}

TEST_F(HapticSink, ReleaseIsZeroUntilArm) {
  build_logging();
  push_motion(100, 0, 60);
  std::atomic<int> notified = 0;
  const gulong handler = g_signal_connect(
      sink_.get(), "notify::armed",
      G_CALLBACK(+[](GObject *, GParamSpec *, std::atomic<int> *n) { ++*n; }), &notified);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 10 && notified >= 1; }));
  EXPECT_EQ(notified, 1);
  g_signal_emit_by_name(sink_.get(), "release");
  EXPECT_FALSE(armed());
  advance(50ms); // several rounds of the pointer thread
  EXPECT_EQ(notified, 2);
  g_signal_handler_disconnect(sink_.get(), handler);
  EXPECT_TRUE(advance_until([&] { return newest_row()->force() == 0; }));
  advance(100ms);
  EXPECT_EQ(newest_row()->force(), 0);
  g_signal_emit_by_name(sink_.get(), "arm");
  EXPECT_TRUE(armed());
  EXPECT_TRUE(advance_until([&] { return newest_row()->fx > 0.5 - 1e-6; }));
  expect_fade(stop_and_read_log(), kHeldReleased, 0.05);
}

TEST_F(HapticSink, AReleaseOutlivesTheNextStart) {
  build("device=sim");
  g_signal_emit_by_name(sink_.get(), "release");
  wait_for(GST_STATE_READY);
  EXPECT_FALSE(armed());
  g_signal_emit_by_name(sink_.get(), "arm");
  EXPECT_TRUE(armed());
}

TEST_F(HapticSink, CalibrateMakesThePresentPositionTheCentre) {
  build_logging("sim-hand=hold:0.5,0,0");
  push_motion(0, 0, 60);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 10; }));
  g_signal_emit_by_name(sink_.get(), "calibrate");
  EXPECT_TRUE(advance_until([&] { return std::abs(newest_row()->x) < 0.0005; }));
  EXPECT_NEAR(stop_and_read_log().front().x, 0.0125, 0.0005);
}

// ---- the pointer --------------------------------------------------------------------------------

class HapticSinkPointer : public HapticSink {
protected:
  void play(const std::string &properties) {
    build(properties);
    const haptic::PadPtr pad(gst_element_get_static_pad(sink_.get(), "sink"));
    gst_pad_add_probe(
        pad.get(), GST_PAD_PROBE_TYPE_EVENT_UPSTREAM,
        [](GstPad *, GstPadProbeInfo *info, gpointer data) {
          if (auto point = haptic::parse_pointer_event(gst_pad_probe_info_get_event(info)))
            static_cast<HapticSinkPointer *>(data)->points_.push_back(*std::move(point));
          return GST_PAD_PROBE_OK;
        },
        this, nullptr);
    set(GST_STATE_PLAYING);
  }
  std::optional<haptic::PointerPosition> next_pointer() {
    points_.clear();
    if (!advance_until([&] { return !points_.empty(); }))
      return std::nullopt;
    return points_.front();
  }

  std::vector<haptic::PointerPosition> points_; // the pointer thread, while time passes
};

TEST_F(HapticSinkPointer, AHandHalfwayToTheRightPointsAtThreeQuarters) {
  play("device=sim sim-hand=hold:0.5,0,0");
  const auto first = next_pointer();
  ASSERT_TRUE(first);
  EXPECT_NEAR(first->x, 0.75, 0.01);
  EXPECT_NEAR(first->y, 0.5, 0.01);
  EXPECT_NEAR(first->z, 0, 0.05);
  EXPECT_FALSE(first->device.empty());
  const auto second = next_pointer(); // a resting hand is sent again
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->x, 0.75, 0.01);
}

TEST_F(HapticSinkPointer, AHandThatIsUpPointsAtTheTop) {
  play("device=sim sim-hand=hold:0,0.8,0.4");
  const auto pointer = next_pointer();
  ASSERT_TRUE(pointer);
  EXPECT_NEAR(pointer->y, 0.1, 0.01);
  EXPECT_NEAR(pointer->z, 0.4, 0.02);
}

TEST_F(HapticSinkPointer, AWanderingHandIsFollowed) {
  play("device=sim sim-hand=circle:0.8,1");
  double lowest = 1;
  double highest = 0;
  for (int i = 0; i < 120; ++i) {
    const auto pointer = next_pointer();
    ASSERT_TRUE(pointer);
    lowest = std::min(lowest, pointer->x);
    highest = std::max(highest, pointer->x);
  }
  EXPECT_LT(lowest, 0.2);
  EXPECT_GT(highest, 0.8);
}

TEST_F(HapticSinkPointer, SaysWhetherTheButtonOfTheHandIsPressed) {
  const auto hand = directory_ / "hand.csv";
  std::ofstream(hand) << "0,0,0,0,1\n0.5,0,0,0,1\n0.501,0,0,0,0\n";
  play("device=sim sim-hand=file:" + hand.string());
  const auto pointer = next_pointer();
  ASSERT_TRUE(pointer);
  EXPECT_TRUE(pointer->pressed);
  EXPECT_TRUE(advance_until([&] { return !points_.empty() && !points_.back().pressed; }));
}

TEST_F(HapticSinkPointer, HasTheForceThatIsCommanded) {
  play("device=sim latency-mode=immediate");
  for (int i = 0; i < 100; ++i) {
    push(packed(moving(100, 0), GST_CLOCK_TIME_NONE));
    advance(15ms);
  }
  ASSERT_FALSE(points_.empty());
  ASSERT_TRUE(points_.back().force);
  const std::array<double, 3> last = *points_.back().force;
  EXPECT_NEAR(last[0], equation5(100), 0.02);
  EXPECT_NEAR(last[1], 0, 0.01);
  EXPECT_NEAR(last[2], 0, 0.01);
}

TEST_F(HapticSinkPointer, WithoutADeviceThereIsNoPointer) {
  play("device=none");
  push_motion(100, 0, 1);
  advance(2s);
  EXPECT_TRUE(points_.empty());
}

// ---- latency ------------------------------------------------------------------------------------

class HapticSinkLatency : public HapticSink {
protected:
  /// The running time until which the sink keeps a sample of 1 s, ns; nothing if it does not wait.
  std::optional<GstClockTime> waits_until(const std::string &properties, bool live) {
    build("device=none " + properties);
    g_object_set(source_.get(), "is-live", live, "min-latency", 100 * GST_MSECOND, nullptr);
    set(GST_STATE_PLAYING);
    push(packed(moving(100, 0), 0)); // to preroll
    advance(200ms);
    gst_element_send_event(sink_.get(), gst_event_new_latency(100 * GST_MSECOND));
    push(packed(moving(100, 0), GST_SECOND));
    advance(0ms);
    const std::optional<GstClockTime> due = clock_.next_of_gstreamer();
    EXPECT_EQ(count("samples"), due ? 1U : 2U);
    const GstClockTime base = gst_element_get_base_time(sink_.get());
    stop();
    return due ? std::optional(*due - base) : std::nullopt;
  }
};

TEST_F(HapticSinkLatency, ALiveSampleIsFeltAtOnce) {
  EXPECT_EQ(waits_until("", true), std::nullopt);
  EXPECT_EQ(waits_until("latency-mode=immediate", false), std::nullopt);
}

TEST_F(HapticSinkLatency, OtherwiseASampleWaitsUntilOneAndAHalfFramesBeforeItsTime) {
  const GstClockTime early = 3 * kFrame / 2;
  for (const bool live : {true, false}) {
    const auto until = waits_until("latency-mode=synchronized", live);
    ASSERT_TRUE(until);
    EXPECT_NEAR(static_cast<double>(*until), 1.1 * GST_SECOND - static_cast<double>(early), 10);
  }
  EXPECT_TRUE(waits_until("", false));
}

TEST_F(HapticSink, ALivePipelineIsNoSlowerForIt) {
  const auto latency = [this](const std::string &branch) {
    const std::string line = "videotestsrc is-live=true ! video/x-raw,framerate=30/1 ! tee name=t "
                             "t. ! queue ! fakesink sync=true " +
                             branch;
    pipeline_.reset(gst_parse_launch(line.c_str(), nullptr));
    set_clock(pipeline_.get());
    set(GST_STATE_PLAYING);
    const haptic::QueryPtr query(gst_query_new_latency());
    GstClockTime least = GST_CLOCK_TIME_NONE;
    EXPECT_TRUE(advance_until([&] {
      gboolean live = FALSE;
      return gst_element_query(pipeline_.get(), query.get()) &&
             (gst_query_parse_latency(query.get(), &live, &least, nullptr), live);
    }));
    stop();
    return least;
  };
  const std::string samples = "appsrc is-live=true format=time do-timestamp=true caps=\"" +
                              std::string(kCaps) + "\" ! queue ! hapticsink name=sink device=sim";
  EXPECT_EQ(latency(samples), latency(""));
}

// ---- life cycle ---------------------------------------------------------------------------------

TEST_F(HapticSink, TwoOfThemWorkSideBySide) {
  build_logging();
  const auto other_log = directory_ / "other.csv";
  const ElementPtr other(
      gst_parse_launch(("appsrc name=source format=time caps=\"" + std::string(kCaps) +
                        "\" ! hapticsink name=sink device=sim log-location=" + other_log.string())
                           .c_str(),
                       nullptr));
  set_clock(other.get());
  const ElementPtr other_source(gst_bin_get_by_name(GST_BIN(other.get()), "source"));
  for (int i = 0; i < 15; ++i)
    gst_app_src_push_buffer(GST_APP_SRC(other_source.get()),
                            packed(moving(-100, 0), static_cast<GstClockTime>(i) * kFrame));
  push_motion(100, 0, 0.5);
  gst_app_src_end_of_stream(GST_APP_SRC(other_source.get()));
  push_end();
  change(other.get(), GST_STATE_PLAYING);
  set(GST_STATE_PLAYING);
  wait_for_end();
  change(other.get(), GST_STATE_NULL);
  const auto rows = stop_and_read_log();
  const auto other_rows = read_log(other_log);
  EXPECT_NEAR(std::ranges::max_element(rows, {}, &Row::fx)->fx, 0.5, 1e-6);
  EXPECT_GE(std::ranges::min_element(rows, {}, &Row::fx)->fx, 0);
  EXPECT_NEAR(std::ranges::min_element(other_rows, {}, &Row::fx)->fx, -0.5, 1e-6);
  EXPECT_LE(std::ranges::max_element(other_rows, {}, &Row::fx)->fx, 0);
}

TEST_F(HapticSink, TheEndMayComeBeforeTheFirstSample) {
  build_logging();
  play_to_end();
  for (const Row &row : stop_and_read_log())
    EXPECT_EQ(row.force(), 0);
}

TEST_F(HapticSink, AChangeOfCapsIsNoInterruption) {
  build_logging();
  push_motion(100, 0, 0.4);
  const haptic::CapsPtr caps(
      gst_caps_from_string(HAPTIC_MOTION_CAPS ", width=704, height=576, framerate=30/1"));
  gst_app_src_set_caps(GST_APP_SRC(source_.get()), caps.get());
  for (int i = 0; i < 12; ++i, pts_ += kFrame) {
    MotionSample sample = moving(200, 0); // the same motion in a frame twice as wide
    sample.frame_width = 704;
    push(packed(sample, pts_));
  }
  const auto rows = undisturbed(play_and_read_log());
  EXPECT_FALSE(rows.empty());
  for (const Row &row : rows)
    ASSERT_NEAR(row.fx, 0.5, 1e-6) << row.time;
}

TEST_F(HapticSink, ASeekIsSilentAndThenGoesOn) {
  build("device=sim log-location=" + log_.string(), "stream-type=seekable");
  std::atomic<int> seeks = 0;
  g_signal_connect(source_.get(), "seek-data",
                   G_CALLBACK(+[](GstAppSrc *, guint64, std::atomic<int> *n) -> gboolean {
                     ++*n;
                     return TRUE;
                   }),
                   &seeks);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return seeks == 1; })); // every source begins with one
  push_motion(100, 0, 1);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 15; }));
  ASSERT_TRUE(gst_element_seek_simple(pipeline_.get(), GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, 0));
  const guint64 before = count("samples");
  pts_ = 0;
  push_motion(100, 0, 1);
  push_end();
  wait_for_end();
  EXPECT_GE(count("samples"), before + 29);
  const auto rows = stop_and_read_log();
  EXPECT_GT(rows.back().time, 1.4); // the log's time went on
  for (std::size_t i = 1; i < rows.size(); ++i)
    ASSERT_GE(rows[i].time, rows[i - 1].time);
  EXPECT_TRUE(std::ranges::any_of(
      rows, [](const Row &row) { return row.held(kHeldFlushing) && row.force() == 0; }));
  EXPECT_NEAR(last_free_row(rows).fx, 0.5, 1e-6);
}

TEST_F(HapticSink, APropertyChangedInReadyCounts) {
  build("device=none");
  wait_for(GST_STATE_READY);
  g_object_set(sink_.get(), "device", "sim", "rate", 500U, "log-location", log_.c_str(), nullptr);
  push_motion(100, 0, 0.5);
  const auto rows = play_and_read_log();
  EXPECT_EQ(rows.size(), std::lround(rows.back().mono * 500) + 1);
  EXPECT_GT(rows.size(), 1U);
  EXPECT_GT(rows.back().t[0], 0.2);
}

// ---- messages -----------------------------------------------------------------------------------

TEST_F(HapticSink, PostsItsStatisticsJustBeforeTheEnd) {
  build("device=sim");
  const auto statistics = statistics_of_film(100);
  ASSERT_TRUE(statistics);
  const GstStructure *s = statistics.get();
  for (const char *name :
       {"ticks", "late-ticks", "missed-ticks", "samples", "bad-samples", "gaps", "faults",
        "log-rows-lost", "samples-lost", "reliefs", "bad-reliefs", "limited-by-fade",
        "limited-by-confidence", "limited-by-force", "limited-by-torque", "limited-by-budget",
        "limited-by-slew", "limited-by-work", "limited-by-energy"})
    EXPECT_TRUE(gst_structure_has_field_typed(s, name, G_TYPE_UINT64)) << name;
  for (const char *name :
       {"jitter-p50", "jitter-p99", "jitter-max", "loop-p50", "loop-p99", "loop-max", "sample-age",
        "sample-age-max", "force-max", "force-rms", "given-up-force", "given-up-torque",
        "carry-stiffness", "carry-distance"})
    EXPECT_TRUE(gst_structure_has_field_typed(s, name, G_TYPE_DOUBLE)) << name;
  EXPECT_STREQ(gst_structure_get_string(s, "state"), "held");
  EXPECT_EQ(gst_structure_n_fields(s), 34);
  EXPECT_EQ(count("samples"), 15U);
  EXPECT_GT(count("ticks"), 500U);
  EXPECT_EQ(count("late-ticks"), 0U);
  EXPECT_EQ(count("log-rows-lost"), 0U);
  EXPECT_EQ(number("jitter-max"), 0);
  EXPECT_NEAR(number("force-max"), 0.5, 1e-6);
  EXPECT_GT(number("sample-age"), 0);
}

TEST_F(HapticSink, AStillFilmHasEndedToo) {
  build("device=sim");
  const auto statistics = statistics_of_film(0);
  ASSERT_TRUE(statistics);
  EXPECT_STREQ(gst_structure_get_string(statistics.get(), "state"), "held");
}

// The device is let go when the force has faded, and the log shows it.
TEST_F(HapticSink, FromPlayingToNullTheForceFades) {
  build_logging();
  push_motion(1000, 0, 5);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return newest_row() && newest_row()->force() > 0.8; }));
  const auto rows = stop_and_read_log();
  EXPECT_EQ(rows.back().force(), 0);
  double before = rows.front().force();
  for (const Row &row : rows) {
    EXPECT_LE(before - row.force(), 0.1); // N in a tick
    before = row.force();
  }
}

TEST_F(HapticSink, PostsItsStateWithTheReasonAndTheDevice) {
  build("device=sim");
  push_motion(100, 0, 0.5);
  push_end();
  set(GST_STATE_PLAYING);
  std::vector<std::string> states;
  std::string reason;
  for (const auto &posted : posted_until_end("haptic-session")) {
    reason = gst_structure_get_string(posted.get(), "reason");
    const std::string device = gst_structure_get_string(posted.get(), "device");
    EXPECT_NE(device.find("simulated SPIDAR-G"), std::string::npos) << device;
    if (const char *state = gst_structure_get_string(posted.get(), "state");
        states.empty() || states.back() != state)
      states.push_back(state);
  }
  ASSERT_GE(states.size(), 4U);
  EXPECT_EQ(states[0], "open");
  EXPECT_EQ(states[1], "homed");
  EXPECT_EQ(states[2], "armed");
  EXPECT_EQ(states.back(), "held");
  EXPECT_NE(reason.find("ended"), std::string::npos) << reason;
}

TEST_F(HapticSink, TheStateIsAPropertyWithNotification) {
  build("device=sim");
  const auto state = [&] {
    gint value = -1;
    g_object_get(sink_.get(), "session-state", &value, nullptr);
    return value;
  };
  std::atomic<int> notified = 0;
  const gulong handler = g_signal_connect(
      sink_.get(), "notify::session-state",
      G_CALLBACK(+[](GObject *, GParamSpec *, std::atomic<int> *n) { ++*n; }), &notified);
  EXPECT_EQ(state(), 0); // closed
  wait_for(GST_STATE_READY);
  EXPECT_EQ(state(), 1); // open
  EXPECT_TRUE(advance_until([&] { return notified == 1; }));
  push_motion(100, 0, 20);
  set(GST_STATE_PLAYING);
  EXPECT_TRUE(advance_until([&] { return state() == 3; })); // armed
  g_signal_emit_by_name(sink_.get(), "release");
  EXPECT_EQ(state(), 2); // homed
  stop();
  EXPECT_EQ(state(), 0);
  EXPECT_TRUE(advance_until([&] { return notified >= 5; }));
  g_signal_handler_disconnect(sink_.get(), handler);
}

TEST_F(HapticSink, WithADeadManSwitchThereIsAForceOnlyWhileTheButtonIsPressed) {
  for (const int pressed : {0, 1}) {
    const auto hand = directory_ / "hand.csv";
    std::ofstream(hand) << "0,0,0,0," << pressed << "\n";
    build("device=sim dead-man=button sim-hand=file:" + hand.string());
    pts_ = 0;
    push_motion(100, 0, 0.6);
    play_to_end();
    if (pressed)
      EXPECT_NEAR(number("force-max"), 0.5, 1e-6);
    else
      EXPECT_EQ(number("force-max"), 0);
    stop();
  }
}

TEST_F(HapticSink, AnnouncesItsThread) {
  build("device=sim");
  std::vector<GstStreamStatusType> posted;
  push_motion(100, 0, 0.2);
  set_sync_handler(
      [](GstBus *, GstMessage *m, gpointer data) {
        if (GST_MESSAGE_TYPE(m) == GST_MESSAGE_STREAM_STATUS) {
          GstStreamStatusType type;
          GstElement *owner = nullptr;
          gst_message_parse_stream_status(m, &type, &owner);
          gchar *name = gst_element_get_name(owner);
          if (std::strcmp(name, "sink") == 0)
            static_cast<std::vector<GstStreamStatusType> *>(data)->push_back(type);
          g_free(name);
        }
        return GST_BUS_PASS;
      },
      &posted);
  {
    const AtEnd ends([&] {
      stop();
      set_sync_handler(nullptr);
    });
    set(GST_STATE_PLAYING);
    ASSERT_TRUE(advance_until([&] { return count("samples") > 0; }));
  }
  EXPECT_EQ(posted, (std::vector{GST_STREAM_STATUS_TYPE_CREATE, GST_STREAM_STATUS_TYPE_ENTER,
                                 GST_STREAM_STATUS_TYPE_LEAVE}));
}

// ---- errors -------------------------------------------------------------------------------------

class HapticSinkErrors : public HapticSink {
protected:
  struct Report {
    GQuark domain = 0;
    int code = 0;
    std::string text;
  };
  Report next_report(GstMessageType type) {
    const auto found = message(type);
    if (!found)
      return {};
    GError *error = nullptr;
    if (type == GST_MESSAGE_ERROR)
      gst_message_parse_error(found.get(), &error, nullptr);
    else
      gst_message_parse_warning(found.get(), &error, nullptr);
    Report t{error->domain, error->code, error->message};
    g_error_free(error);
    return t;
  }
  Report failure(GstState state) {
    EXPECT_EQ(change(pipeline_.get(), state), GST_STATE_CHANGE_FAILURE);
    return next_report(GST_MESSAGE_ERROR);
  }
};

TEST_F(HapticSinkErrors, AnUnknownGeometryNamesIt) {
  build("device=sim geometry=no-such-frame");
  const auto error = failure(GST_STATE_READY);
  EXPECT_EQ(error.domain, GST_RESOURCE_ERROR);
  EXPECT_EQ(error.code, GST_RESOURCE_ERROR_NOT_FOUND);
  EXPECT_NE(error.text.find("no-such-frame"), std::string::npos) << error.text;
}

TEST_F(HapticSinkErrors, AnUnknownDeviceSaysWhatThereIs) {
  build("device=toaster");
  const auto error = failure(GST_STATE_READY);
  EXPECT_EQ(error.code, GST_RESOURCE_ERROR_SETTINGS);
  EXPECT_NE(error.text.find("usb:ID"), std::string::npos) << error.text;
}

TEST_F(HapticSinkErrors, AHandThatIsNotUnderstoodSaysWhatIs) {
  build("device=sim sim-hand=wave");
  const auto error = failure(GST_STATE_READY);
  EXPECT_EQ(error.code, GST_RESOURCE_ERROR_SETTINGS);
  EXPECT_NE(error.text.find("hold:"), std::string::npos) << error.text;
}

TEST_F(HapticSinkErrors, ALogThatCannotBeWrittenNamesTheFile) {
  build("device=sim log-location=" + (directory_ / "missing" / "log.csv").string());
  wait_for(GST_STATE_READY);
  const auto error = failure(GST_STATE_PAUSED);
  EXPECT_EQ(error.domain, GST_RESOURCE_ERROR);
  EXPECT_EQ(error.code, GST_RESOURCE_ERROR_OPEN_WRITE);
  EXPECT_NE(error.text.find("missing/log.csv"), std::string::npos) << error.text;
}

TEST_F(HapticSinkErrors, AfterAnErrorItStartsOnceTheCauseIsGone) {
  build("device=sim geometry=no-such-frame");
  failure(GST_STATE_READY);
  stop();
  g_object_set(sink_.get(), "geometry", "spidar-g6x3r", nullptr);
  wait_for(GST_STATE_READY);
}

// Only where no SPIDAR-G is plugged in.
TEST_F(HapticSinkErrors, WithoutADeviceUsbIsAnErrorAndAutoASimulatedOneWithAWarning) {
  build("device=usb");
  if (change(pipeline_.get(), GST_STATE_READY) != GST_STATE_CHANGE_FAILURE)
    GTEST_SKIP() << "a SPIDAR-G is plugged in";
  const auto error = next_report(GST_MESSAGE_ERROR);
  EXPECT_EQ(error.domain, GST_RESOURCE_ERROR);
  EXPECT_EQ(error.code, GST_RESOURCE_ERROR_NOT_FOUND);
  stop();
  build("");
  wait_for(GST_STATE_READY);
  const auto warning = next_report(GST_MESSAGE_WARNING);
  EXPECT_EQ(warning.code, GST_RESOURCE_ERROR_NOT_FOUND);
  EXPECT_NE(warning.text.find("simulated"), std::string::npos) << warning.text;
}

TEST_F(HapticSinkErrors, OtherCapsAreRefused) {
  const ElementPtr pipeline(
      gst_parse_launch("videotestsrc num-buffers=1 ! hapticsink device=none", nullptr));
  // gst_parse_launch may already refuse to link.
  if (pipeline)
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const HarnessPtr harness(gst_harness_new_parse("hapticsink device=none"));
  gst_harness_set_src_caps_str(harness.get(), "haptics/x-raw, modality=force, layout=point");
  EXPECT_EQ(gst_harness_push(harness.get(), packed(moving(1, 1), 0)), GST_FLOW_NOT_NEGOTIATED);
  if (pipeline)
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

} // namespace hapticsink_test
