// SPDX-License-Identifier: LGPL-2.1-or-later
// How long hapticsink keeps a live stream, and how fast a stream that waits for its time ends. Run
// by hand on an idle machine:
//   meson devenv -C BUILD tests/measure/benchmarks/hapticsink-element
// Targets: a live push p50 <= 2 ms; a waiting stream ends within 0.2 s.
#include "hapticsink-fixture.hpp"
#include "processor.hpp"

#include <cstdio>
#include <unistd.h>

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { // ms
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

struct Times {
  double median = 0; // ms
  double largest = 0;
};

Times times_of(std::vector<double> durations) {
  std::ranges::sort(durations);
  return {durations[durations.size() / 2], durations.back()};
}

// A push of a sample stamped with the present, in a live pipeline.
Times live_push() {
  constexpr GstClockTime kLatency = 100 * GST_MSECOND;
  const test::HarnessPtr harness(gst_harness_new_parse("hapticsink device=sim"));
  gst_harness_set_live(harness.get(), TRUE);
  gst_harness_set_upstream_latency(harness.get(), kLatency);
  gst_harness_set_src_caps_str(harness.get(), test::kCaps);
  gst_harness_use_systemclock(harness.get());
  const test::ElementPtr sink(gst_harness_find_element(harness.get(), "hapticsink"));
  g_object_set(sink.get(), "sync", TRUE, nullptr); // the harness has turned it off
  gst_harness_play(harness.get());
  gst_element_send_event(sink.get(), gst_event_new_latency(kLatency));
  GstClock *clock = gst_element_get_clock(sink.get());
  std::vector<double> durations;
  for (int i = 0; i < 201; ++i) {
    const GstClockTime now = gst_clock_get_time(clock) - gst_element_get_base_time(sink.get());
    const auto begin = Clock::now();
    gst_harness_push(harness.get(), test::packed(test::moving(100, 0), now));
    durations.push_back(since(begin));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  gst_object_unref(clock);
  return times_of(durations);
}

// From PLAYING to NULL while the sink waits for a sample that is due in an hour, under a force.
Times waiting_stream() {
  std::vector<double> durations;
  for (int i = 0; i < 11; ++i) {
    const std::string line = "appsrc name=source format=time caps=\"" + std::string(test::kCaps) +
                             "\" ! hapticsink device=sim";
    const test::ElementPtr pipeline(gst_parse_launch(line.c_str(), nullptr));
    const test::ElementPtr source(gst_bin_get_by_name(GST_BIN(pipeline.get()), "source"));
    for (GstClockTime pts = 0; pts < GST_SECOND; pts += test::kFrame)
      gst_app_src_push_buffer(GST_APP_SRC(source.get()), test::packed(test::moving(1000, 0), pts));
    gst_app_src_push_buffer(GST_APP_SRC(source.get()),
                            test::packed(test::moving(1000, 0), 3600 * GST_SECOND));
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    gst_element_get_state(pipeline.get(), nullptr, nullptr, 5 * GST_SECOND);
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    const auto begin = Clock::now();
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
    durations.push_back(since(begin));
  }
  return times_of(durations);
}

} // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  const Times push = live_push();
  const Times ended = waiting_stream();
  std::printf("%s, %ld processors, compiler %s\n", test::processor().c_str(),
              sysconf(_SC_NPROCESSORS_ONLN), __VERSION__);
  std::printf("live push             p50 %8.3f ms  max %8.3f ms\n", push.median, push.largest);
  std::printf("waiting stream to end p50 %8.3f ms  max %8.3f ms\n", ended.median, ended.largest);
  return push.median <= 2 && ended.largest <= 200 ? EXIT_SUCCESS : EXIT_FAILURE;
}
