// SPDX-License-Identifier: LGPL-2.1-or-later
// What goes wrong around the element, with the limit that must hold (docs/reliability.md has the
// list; the numbers in the names are its).
#include "virtual-sink.hpp"

#include <algorithm>

#include <random>

namespace {

using namespace std::chrono_literals;
using namespace test;

class SinkFaults : public VirtualSink {
protected:
  void build_playing(const std::string &properties = "") {
    build_logging(properties);
    push_motion(1e5, 0, 60);
    set(GST_STATE_PLAYING);
    ASSERT_TRUE(advance_until([&] { return number("force-max") > 0.99; }));
  }
};

TEST_F(SinkFaults, F5_PausesAtRandomTimes) {
  build_playing();
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    wait_for(GST_STATE_PAUSED);
    advance(std::chrono::milliseconds(random() % 150));
    wait_for(GST_STATE_PLAYING);
    advance(std::chrono::milliseconds(random() % 150));
  }
  const auto rows = stop_and_read_log();
  expect_sound(rows);
  EXPECT_TRUE(std::ranges::any_of(rows, [](const Row &row) { return row.held(kHeldPaused); }));
}

TEST_F(SinkFaults, F6_FlushesAtRandomTimesAlsoWhilePrerolling) {
  build_playing();
  std::mt19937 random(6);
  const haptic::PadPtr pad(gst_element_get_static_pad(sink_.get(), "sink"));
  const auto send = [&](GstEvent *event) {
    complete([&] { gst_pad_send_event(pad.get(), event); });
  };
  for (int i = 0; i < 30; ++i) {
    if (i % 3 == 0)
      set(i % 2 ? GST_STATE_PAUSED : GST_STATE_PLAYING);
    send(gst_event_new_flush_start());
    advance(std::chrono::milliseconds(random() % 80));
    send(gst_event_new_flush_stop(FALSE));
    advance(std::chrono::milliseconds(random() % 80));
  }
  const auto rows = stop_and_read_log();
  expect_sound(rows);
  EXPECT_TRUE(std::ranges::any_of(rows, [](const Row &row) { return row.held(kHeldFlushing); }));
}

TEST_F(SinkFaults, F8_MissingFallingAndRepeatedTimeStampsInTheStream) {
  build_logging();
  std::mt19937 random(8);
  for (int i = 0; i < 90; ++i, pts_ += kFrame) {
    GstClockTime pts = pts_;
    switch (random() % 6) {
    case 0:
      pts = GST_CLOCK_TIME_NONE;
      break;
    case 1:
      pts = pts_ > 10 * kFrame ? pts_ - 10 * kFrame : 0;
      break;
    case 2:
      pts = pts_ > kFrame ? pts_ - kFrame : 0;
      break;
    default:
      break;
    }
    push(packed(moving(random() % 2 ? 300 : -300, 100), pts));
  }
  play_to_end();
  expect_sound(stop_and_read_log());
}

TEST_F(SinkFaults, F10_FilmInVideoIsFeltAsEvenAsItMoves) {
  build_logging();
  // 24 frames a second carried in 30: the fourth of each is shown twice.
  GstClockTime film = 0;
  for (int video = 0; video < 90; ++video, pts_ += kFrame) {
    if (video % 5 == 4) {
      MotionSample same = moving(125, 0);
      same.flags = haptic::kMotionDuplicate;
      push(packed(same, pts_));
      continue;
    }
    MotionSample sample = moving(0, 0);
    sample.interval = pts_ > film ? pts_ - film : kFrame;
    sample.velocity_x =
        static_cast<float>(100 / 24.0 / (static_cast<double>(sample.interval) * 1e-9));
    film = pts_;
    push(packed(sample, pts_));
  }
  play_to_end();
  int rows = 0;
  for (const Row &row : undisturbed(stop_and_read_log()))
    if (row.time > 1 && row.time < 2.8) {
      ASSERT_NEAR(row.fx, 0.5, 0.5 * 0.05) << row.time;
      ++rows;
    }
  EXPECT_NEAR(rows, 1800, 2);
}

TEST_F(SinkFaults, F18_EveryDeviceThatCannotBeOpenedSaysWhy) {
  struct {
    const char *properties;
    const char *remedy;
  } const kCases[] = {{"device=toaster", "usb:ID"},
                      {"device=usb:", "usb:ID"},
                      {"device=sim geometry=none-such", "none-such"},
                      {"device=sim sim-hand=wave", "hold:"},
                      {"device=none dead-man=button", "dead-man=none"},
                      {"device=usb:15", "SPIDAR"}};
  for (const auto &[properties, remedy] : kCases) {
    build(properties);
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(change(pipeline_.get(), GST_STATE_READY), GST_STATE_CHANGE_FAILURE) << properties;
    const std::chrono::duration<double, std::milli> refused =
        std::chrono::steady_clock::now() - begin;
    std::printf("%s: refused after %.1f ms\n", properties, refused.count());
    const auto found = message(GST_MESSAGE_ERROR);
    ASSERT_TRUE(found);
    GError *error = nullptr;
    gst_message_parse_error(found.get(), &error, nullptr);
    EXPECT_NE(std::string(error->message).find(remedy), std::string::npos) << error->message;
    g_error_free(error);
    stop();
  }
}

// ---- playback rate ------------------------------------------------------------------------------

class SinkRate : public SinkFaults {
protected:
  /// Plays two seconds of stream at this rate; backwards, the frames come from the end.
  std::vector<Row> play_at(double rate, const std::string &properties = "", guint flags = 0) {
    build("device=sim log-location=" + log_.string() + " " + properties, "stream-type=seekable");
    static std::atomic<int> seeks;
    seeks = 0;
    g_signal_connect(source_.get(), "seek-data",
                     G_CALLBACK(+[](GstAppSrc *, guint64, gpointer) -> gboolean {
                       ++seeks;
                       return TRUE;
                     }),
                     nullptr);
    set(GST_STATE_PAUSED);
    EXPECT_TRUE(advance_until([&] { return seeks == 1; })); // every source begins with one
    push(packed(moving(0, 0), 0));                          // to preroll
    wait_for_change();
    EXPECT_TRUE(gst_element_seek(pipeline_.get(), rate, GST_FORMAT_TIME,
                                 static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | flags),
                                 GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, 2 * GST_SECOND));
    for (int i = 0; i < 60; ++i) {
      const auto n = static_cast<GstClockTime>(rate > 0 ? i : 59 - i);
      push(packed(moving(100, 0), n * kFrame));
    }
    return play_and_read_log();
  }
  /// The force between 60 % and 90 % of the time that it takes.
  static double settled(const std::vector<Row> &rows, double rate) {
    const double duration = 2 / std::abs(rate);
    double sum = 0;
    int n = 0;
    for (const Row &row : undisturbed(rows))
      if (row.time > 0.6 * duration && row.time < 0.9 * duration) {
        sum += row.fx;
        ++n;
      }
    return n > 0 ? sum / n : std::numeric_limits<double>::quiet_NaN();
  }
};

TEST_F(SinkRate, SlowMotionIsFeltAsSeenOrAsFilmed) {
  EXPECT_NEAR(settled(play_at(0.5), 0.5), equation5(50), 0.01);
  EXPECT_NEAR(settled(play_at(0.5, "rate-law=as-filmed"), 0.5), equation5(100), 0.01);
}

TEST_F(SinkRate, TwiceAsFastIsStronger) {
  EXPECT_NEAR(settled(play_at(2), 2), equation5(200), 0.01);
}

TEST_F(SinkRate, BeyondTwiceTheSpeedAndInTrickModesItIsMute) {
  for (const Row &row : play_at(2.5))
    ASSERT_EQ(row.force(), 0) << row.time;
  for (const Row &row : play_at(1, "", GST_SEEK_FLAG_TRICKMODE_KEY_UNITS))
    ASSERT_EQ(row.force(), 0) << row.time;
}

// roitracker measures what is seen, so that the samples are turned round already.
TEST_F(SinkRate, BackwardsTheMotionIsFeltAsItComes) {
  EXPECT_NEAR(settled(play_at(-1), 1), equation5(100), 0.01);
}

TEST_F(SinkRate, SteppingFromFrameToFrameIsZero) {
  build_logging();
  push_motion(100, 0, 3);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 15; }));
  wait_for(GST_STATE_PAUSED);
  advance(150ms);
  const auto paused = newest_row();
  ASSERT_TRUE(paused);
  const auto ticks = count("ticks");
  for (int i = 0; i < 5; ++i) {
    gst_element_send_event(sink_.get(), gst_event_new_step(GST_FORMAT_BUFFERS, 1, 1, TRUE, FALSE));
    advance(50ms);
  }
  EXPECT_TRUE(advance_until([&] { return count("ticks") > ticks + 200; }));
  const auto rows = stop_and_read_log();
  EXPECT_EQ(rows.back().force(), 0);
  for (const Row &row : rows)
    if (row.mono > paused->mono) {
      ASSERT_EQ(row.force(), 0)
          << row.mono; // while paused, rows are only written if there is a force
    }
}

// ---- time ---------------------------------------------------------------------------------------

TEST_F(SinkFaults, TheForceOfAFileComesWithItsFrameWithin20Milliseconds) {
  build_logging();
  const auto velocity = [](double t) { return 150 * std::sin(2 * std::numbers::pi * t); };
  for (int i = 0; i < 150; ++i, pts_ += kFrame)
    push(packed(moving(velocity(i / 30.0 - 0.5 / 30), 0), pts_)); // over the interval before
  const auto rows = play_and_read_log();
  // ms by which the force crosses zero before or after the frame does. The crossing is somewhere
  // between two rows, however far apart they are.
  std::vector<double> skews;
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].time > 0.8 && rows[i].time < 4.8 && rows[i].hold == 0 &&
        rows[i - 1].fx * rows[i].fx <= 0 && rows[i].fx != rows[i - 1].fx) {
      const double frame = std::round(2 * rows[i].time) / 2;
      skews.push_back(1000 * std::max({rows[i - 1].time - frame, frame - rows[i].time, 0.0}));
    }
  ASSERT_EQ(skews.size(), 8U);
  const double largest = std::ranges::max(skews);
  EXPECT_LE(largest, 20);
  std::printf("frame to force: %.1f ms at most\n", largest);
}

} // namespace
