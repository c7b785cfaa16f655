// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink as the plugin has it, by the clock of the machine: what happens when threads get in
// each other's way, or the machine is busy. Only order and the final state are asserted.
#include "hapticsink-fixture.hpp"

namespace hapticsink_realtime_test {

using namespace std::chrono_literals;
using namespace test;

TEST_F(HapticSink, ASampleThatArrivesWhileAPauseEndsDelaysNothing) {
  build("device=sim");
  push_motion(100, 0, 0.1);
  wait_for(GST_STATE_PLAYING);
  for (int i = 0; i < 200 && !HasFatalFailure(); ++i) {
    wait_for(GST_STATE_PAUSED);
    push(packed(moving(100, 0), 0));
    wait_for(GST_STATE_PLAYING);
  }
  push_end();
  wait_for_end();
}

TEST_F(HapticSink, SurvivesTwoHundredStateChanges) {
  build("device=sim");
  std::mt19937 random(6);
  constexpr std::array kStates = {GST_STATE_NULL, GST_STATE_READY, GST_STATE_PAUSED,
                                  GST_STATE_PLAYING};
  for (int i = 0; i < 200; ++i) {
    // The source refuses while it is stopped, and forgets when it stops.
    gst_app_src_push_buffer(GST_APP_SRC(source_.get()), packed(moving(100, 0), 0));
    set(kStates[random() % kStates.size()]);
    if (random() % 4 == 0)
      advance(5ms);
  }
  stop();
  EXPECT_FALSE(message(GST_MESSAGE_ERROR, false));
}

// A program that has set NULL frees the bin: a message that is posted then has no bus.
TEST_F(HapticSink, InNullNoHandlerRunsAnyMore) {
  struct Handler {
    std::atomic<bool> runs = false;
    std::atomic<int> calls = 0;
  } handler;
  build("device=sim");
  const gulong id = g_signal_connect(sink_.get(), "notify::session-state",
                                     G_CALLBACK(+[](GObject *, GParamSpec *, Handler *of) {
                                       of->runs = true;
                                       std::this_thread::sleep_for(20ms);
                                       ++of->calls;
                                       of->runs = false;
                                     }),
                                     &handler);
  for (int i = 1; i <= 10; ++i) {
    set(GST_STATE_READY);
    ASSERT_TRUE(advance_until([&] { return handler.runs || handler.calls == 2 * i - 1; }));
    stop();
    EXPECT_FALSE(handler.runs);
    EXPECT_EQ(handler.calls, 2 * i); // open, closed
  }
  g_signal_handler_disconnect(sink_.get(), id);
}

// What a program shows is the last state that it was told.
TEST_F(HapticSink, HandlersRunOneAfterTheOtherAlsoWhenItStops) {
  struct Handler {
    std::atomic<int> begun = 0;
    std::atomic<int> running = 0;
    std::atomic<bool> overlapped = false;
    std::string state; // the last one
  } handler;
  build("device=sim");
  set_sync_handler(
      [](GstBus *, GstMessage *message, gpointer data) {
        auto *of = static_cast<Handler *>(data);
        if (gst_message_has_name(message, "haptic-session")) {
          if (++of->running > 1)
            of->overlapped = true;
          ++of->begun;
          std::this_thread::sleep_for(5ms);
          of->state = gst_structure_get_string(gst_message_get_structure(message), "state");
          --of->running;
        }
        return GST_BUS_PASS;
      },
      &handler);
  const AtEnd ends([&] {
    stop();
    set_sync_handler(nullptr);
  });
  for (int i = 0; i < 10; ++i) {
    const int before = handler.begun;
    set(GST_STATE_PAUSED);
    ASSERT_TRUE(advance_until([&] { return handler.begun > before; }));
    stop();
    EXPECT_FALSE(handler.overlapped);
    EXPECT_EQ(handler.running, 0);
    EXPECT_EQ(handler.state, "closed");
  }
}

// FEELING_WIND_HOG_SECONDS=60 for all of it.
TEST_F(HapticSink, F19_ABusyMachineIsCountedAndNotFelt) {
  const char *wanted = std::getenv("FEELING_WIND_HOG_SECONDS");
  const double seconds = wanted ? std::atof(wanted) : 2;
  build_logging();
  for (double t = 0; t < seconds; t += 1.0 / 30, pts_ += kFrame)
    push(packed(moving(150 * std::sin(9 * t), 0), pts_));
  push_end();
  {
    std::vector<std::jthread> hogs;
    for (unsigned i = 0; i < 2; ++i)
      hogs.emplace_back([](const std::stop_token &stop) {
        for (volatile double x = 1; !stop.stop_requested();)
          x = x * 1.0000001;
      });
    set(GST_STATE_PLAYING);
    wait_for_end();
  }
  std::printf("%.0f s with two hogs: %lu late ticks, %lu more than 10 ms late\n", seconds,
              count("late-ticks"), count("missed-ticks"));
  const auto rows = stop_and_read_log();
  expect_sound(rows); // no more than the slew rate allows, however late a tick comes
}

// GLib itself refuses numbers that are not finite.
TEST_F(HapticSink, F23_TenThousandPropertyChangesASecond) {
  build_logging();
  push_motion(1e5, 0, 60);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return number("force-max") > 0.99; }));
  std::mt19937 random(23);
  std::uniform_real_distribution<double> fraction(0, 1);
  const char *const kEnums[] = {"force-law", "latency-mode", "rate-law"};
  const std::pair<const char *, double> kNumbers[] = {
      {"max-force", 5},     {"alpha", 10},      {"damping", 10},
      {"smooth-hz", 500},   {"max-push", 5},    {"max-torque", 0.1},
      {"gain-window", 600}, {"spin-half", 100}, {"slew-rate", 20}};
  for (int i = 0; i < 10'000; ++i) {
    if (i % 16 == 0) {
      gst_util_set_object_arg(G_OBJECT(sink_.get()), kEnums[random() % std::size(kEnums)],
                              std::to_string(random() % 5).c_str());
    } else {
      const auto &[name, most] = kNumbers[random() % std::size(kNumbers)];
      g_object_set(sink_.get(), name, std::clamp(most * fraction(random), 0.1, most), nullptr);
    }
    advance(50us);
  }
  EXPECT_EQ(count("faults"), 0U); // the log has 0 for what is not finite
  for (const Row &row : stop_and_read_log()) {
    ASSERT_LE(row.force(), 5 + 1e-6);
  }
}

TEST_F(HapticSink, MeasuresHowLongItsTicksTakeAndHowOldItsSamplesAre) {
  build("device=sim");
  push_motion(100, 0, 0.2);
  play_to_end();
  EXPECT_GT(number("loop-p99"), 0);
  EXPECT_GE(number("loop-max"), number("loop-p50"));
  EXPECT_GT(number("jitter-max"), 0);
  EXPECT_GT(number("sample-age"), 0);
}

} // namespace hapticsink_realtime_test
