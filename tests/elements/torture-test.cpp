// SPDX-License-Identifier: LGPL-2.1-or-later
// Threads push caps, segments, frames and rubbish into an element, send it events from both sides,
// query it, set its properties, request its pads and start and stop it, all at the same time.
// G_DEBUG=fatal-criticals and the sanitizers judge. FEELING_WIND_TORTURE: state changes of a run
// (20); FEELING_WIND_SEEDS: runs (1), each with a seed of its own.
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"
#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <functional>
#include <gst/base/gstbaseparse.h>
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <semaphore>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace torture_test {

using Random = std::mt19937;

struct Victim {
  const char *factory;
  std::vector<const char *> input;  // caps
  std::vector<const char *> output; // caps, one a seed; any if there are none
  const char *sink = "sink";
  const char *control = nullptr; // what it shows, if it is of GStreamer itself
};

#define HAPTICS HAPTIC_MOTION_CAPS, HAPTIC_FIELD_CAPS, HAPTIC_RELIEF_CAPS
constexpr const char *kSmall = "video/x-raw, format=I420, width=64, height=48, framerate=30/1";
constexpr const char *kLarge = "video/x-raw, format=GRAY8, width=161, height=97, framerate=25/1";
constexpr const char *kColour = "video/x-raw, format=RGB, width=67, height=48, framerate=30/1";
constexpr const char *kDepth = "video/x-raw, format=GRAY16_LE, width=64, height=48, framerate=30/1";
constexpr const char *kKlv = "meta/x-klv, parsed=true";
constexpr const char *kText = "text/x-raw, format=utf8";
constexpr const char *kUnits = "haptics/hmpg, stream-format=mihs, alignment=unit, rate=8000";
constexpr const char *kRtp =
    "application/x-rtp, media=haptics, encoding-name=HMPG, clock-rate=8000, payload=96";

const Victim kVictims[] = {
    {"roitracker", {kSmall, kLarge, kColour}, {}},
    {"velocityavg", {kSmall, kColour}, {}},
    {"motionfield", {kSmall, kLarge}, {}},
    {"depthfield", {kDepth, kLarge}, {}},
    {"reliefmap", {kColour}, {}},
    {"hapticoverlay", {kSmall, kColour}, {}},
    {"hapticconvert", {HAPTICS, kKlv, kText, kUnits}, {kKlv, kText, kUnits, HAPTIC_MOTION_CAPS}},
    {"hapticmark", {"video/mpegts, systemstream=true, packetsize=188", "video/x-matroska"}, {}},
    {"hmpgparse", {"haptics/hmpg"}, {}},
    {"pointerextract", {kSmall, HAPTIC_MOTION_CAPS}, {}},
    {"pointerinject", {kSmall, HAPTIC_MOTION_CAPS}, {}},
    {"rtphmpgpay", {kUnits}, {}},
    {"rtphmpgdepay", {kRtp}, {}},
    {"hapticarray", {HAPTIC_MOTION_CAPS, HAPTIC_FIELD_CAPS}, {}},
    {"hapticsink", {HAPTICS}, {}},
};

// The same with elements of GStreamer: the control run of each exception that the test makes for a
// base class of GStreamer 1.22. tests/referees/thread-sanitizer.sh runs them.
constexpr const char *kRtpAudio =
    "application/x-rtp, media=audio, encoding-name=L16, clock-rate=8000, channels=1, payload=96";
const Victim kControls[] = {
    {"mpegtsmux", {kKlv}, {}, "sink_%d", "ClipsByASegmentInBytes"},
    {"mpegtsmux", {kKlv}, {}, "sink_%d", "WaitsForEver"},
    {"rtpL16depay", {kRtpAudio}, {}, "sink", "TakesASegmentInBytesForTime"},
};

constexpr std::size_t kThreads = 28; // four of each of the seven ways to attack

int from_environment(const char *name, int usual) {
  const char *value = std::getenv(name);
  return value ? std::atoi(value) : usual;
}

guint below(Random &random, guint count) {
  return std::uniform_int_distribution<guint>(0, count - 1)(random);
}

std::vector<std::uint8_t> noise(Random &random, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (auto &byte : bytes)
    byte = static_cast<std::uint8_t>(random());
  return bytes;
}

// What these caps announce, and now and then something else.
std::vector<std::uint8_t> content(GstCaps *caps, Random &random) {
  if (below(random, 16) == 0)
    return noise(random, 1 + below(random, 400));
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  if (gst_structure_has_name(structure, "video/x-raw")) {
    GstVideoInfo info;
    gst_video_info_from_caps(&info, caps);
    return noise(random, GST_VIDEO_INFO_SIZE(&info));
  }
  if (gst_structure_has_name(structure, "haptics/x-field")) {
    haptic::ReliefField relief;
    relief.frame_width = relief.frame_height = 64;
    relief.columns = relief.rows = 4;
    relief.interval = GST_SECOND / 30;
    relief.cells.assign(16, {0.001F * static_cast<float>(below(random, 10)), 300, 0.1F, 1});
    std::vector<std::uint8_t> bytes(haptic::packed_size(relief));
    haptic::pack_relief_field(relief, bytes);
    return bytes;
  }
  if (g_strcmp0(gst_structure_get_string(structure, "layout"), "field") == 0) {
    haptic::MotionField field;
    field.frame_width = field.frame_height = 64;
    field.columns = field.rows = 4;
    field.interval = GST_SECOND / 30;
    field.cells.assign(16, {static_cast<float>(below(random, 300)), 1, 1});
    std::vector<std::uint8_t> bytes(haptic::packed_size(field));
    haptic::pack_motion_field(field, bytes);
    return bytes;
  }
  if (gst_structure_has_name(structure, "haptics/x-raw")) {
    haptic::MotionSample sample;
    sample.frame_width = sample.frame_height = 64;
    sample.velocity_x = static_cast<float>(below(random, 300));
    sample.confidence = 1;
    sample.interval = GST_SECOND / 30;
    sample.held.state = static_cast<haptic::HoldState>(static_cast<int>(sample.velocity_x) % 6);
    const auto packed = haptic::pack_motion_sample(sample);
    return {packed.begin(), packed.end()};
  }
  return noise(random, 1 + below(random, 400));
}

struct Teardown {
  void operator()(GstHarness *harness) const { gst_harness_teardown(harness); }
};
using HarnessPtr = std::unique_ptr<GstHarness, Teardown>;

// While it lives, an element changes no state and nothing flows into it.
class Alone {
public:
  explicit Alone(GstElement *element) : element_(element) {
    if (!element_)
      return;
    GST_STATE_LOCK(element_);
    sink_.reset(gst_element_get_static_pad(element_, "sink"));
    GST_PAD_STREAM_LOCK(sink_.get());
  }
  ~Alone() {
    if (!element_)
      return;
    GST_PAD_STREAM_UNLOCK(sink_.get());
    GST_STATE_UNLOCK(element_);
  }
  Alone(const Alone &) = delete;
  Alone &operator=(const Alone &) = delete;

private:
  GstElement *element_;
  haptic::PadPtr sink_;
};

class Torture : public testing::TestWithParam<Victim> {
protected:
  static void SetUpTestSuite() {
    gst_init(nullptr, nullptr);
    g_log_set_always_fatal(static_cast<GLogLevelFlags>(G_LOG_FATAL_MASK | G_LOG_LEVEL_CRITICAL));
  }
  void TearDown() override { g_test_log_set_fatal_handler(nullptr, nullptr); }

  // Whether this base class of GStreamer is spared what it cannot bear; a control is not.
  bool spares(const char *base) const {
    return !GetParam().control &&
           g_type_is_a(G_OBJECT_TYPE(element()), g_type_from_name(base)) != FALSE;
  }
  bool spares_aggregator() const { return spares("GstAggregator"); }

  // The critical warnings of its base class that an element survives: GstAggregator clips a gap
  // event by every segment, and in one of twenty runs sends an event with a sequence number that it
  // does not have yet (no element here sets one); GstRTPBaseDepayload takes every segment for one
  // of time, also when none has come; GstBaseParse leaves a segment in bytes without an end, also
  // backwards.
  std::vector<std::string_view> forgiven() const {
    if (spares_aggregator())
      return {"gst_segment_clip: assertion 'segment->format == format' failed",
              "gst_event_set_seqnum: assertion 'seqnum != GST_SEQNUM_INVALID' failed"};
    if (spares("GstRTPBaseDepayload"))
      return {"gst_segment_to_running_time: assertion 'segment->format == format' failed"};
    if (spares("GstBaseParse"))
      return {"gst_segment_to_running_time_full: assertion 'stop != -1' failed"};
    return {};
  }

  void judge_critical_warnings() {
    forgiven_ = forgiven();
    const GTestLogFatalFunc is_fatal = [](const char *, GLogLevelFlags, const char *message,
                                          gpointer test) -> gboolean {
      const auto &self = *static_cast<const Torture *>(test);
      return !GetParam().control &&
             std::ranges::find(self.forgiven_, std::string_view(message)) == self.forgiven_.end();
    };
    g_test_log_set_fatal_handler(is_fatal, this);
  }

  // One attacker: a function that a thread calls again and again.
  struct Attack {
    std::function<void(Random &)> act;
    Random random;
    std::atomic<guint> *acts;
  };

  void attack(std::function<void(Random &)> act) {
    attacks_.push_back(std::make_unique<Attack>(
        Attack{std::move(act), Random(seed_ * 100 + attacks_.size()), &acts_}));
    const GFunc call = [](gpointer, gpointer data) {
      auto &attack = *static_cast<Attack *>(data);
      attack.act(attack.random);
      ++*attack.acts;
    };
    threads_.push_back(
        gst_harness_stress_custom_start(harness_.get(), nullptr, call, attacks_.back().get(), 0));
  }

  void push_stream(GstPad *from, const std::vector<const char *> &input, Random &random) const {
    const haptic::CapsPtr caps(
        gst_caps_from_string(input[below(random, static_cast<guint>(input.size()))]));
    gst_pad_push_event(from, gst_event_new_stream_start("torture"));
    gst_pad_push_event(from, gst_event_new_caps(caps.get()));
    GstSegment segment;
    gst_segment_init(&segment, below(random, 4) == 0 ? GST_FORMAT_BYTES : GST_FORMAT_TIME);
    if (below(random, 4) == 0)
      segment.rate = below(random, 2) == 0 ? -0.5 : 2;
    segment.stop = 4 * GST_SECOND; // backwards there must be one
    gst_pad_push_event(from, gst_event_new_segment(&segment));
    for (guint i = 0; i < 5; ++i) {
      const auto bytes = content(caps.get(), random);
      GstBuffer *buffer = gst_buffer_new_memdup(bytes.data(), bytes.size());
      if (below(random, 8) != 0) {
        GST_BUFFER_PTS(buffer) = i * GST_SECOND / 30;
        GST_BUFFER_DURATION(buffer) = GST_SECOND / 30;
      }
      if (below(random, 8) == 0)
        GST_BUFFER_FLAG_SET(buffer,
                            below(random, 2) ? GST_BUFFER_FLAG_GAP : GST_BUFFER_FLAG_DISCONT);
      gst_pad_push(from, buffer);
    }
  }

  // If a flush ends amid a deactivation, a thread may wait for ever in GstAggregator. A seek holds
  // the lock of the state while it flushes.
  void flush(GstPad *from) const {
    const bool as_a_seek = spares_aggregator();
    if (as_a_seek)
      GST_STATE_LOCK(element());
    gst_pad_push_event(from, gst_event_new_flush_start());
    gst_pad_push_event(from, gst_event_new_flush_stop(TRUE));
    if (as_a_seek)
      GST_STATE_UNLOCK(element());
  }

  void push_event(GstPad *from, Random &random) const {
    switch (below(random, 5)) {
    case 0:
      flush(from);
      break;
    case 1:
      gst_pad_push_event(from, gst_event_new_gap(GST_SECOND, GST_SECOND / 30));
      break;
    case 2:
      gst_pad_push_event(from, gst_event_new_eos());
      break;
    case 3:
      gst_pad_push_event(from, gst_event_new_tag(gst_tag_list_new_empty()));
      break;
    default:
      gst_pad_push_event(from, gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM,
                                                    gst_structure_new_empty("torture")));
    }
  }

  void send_upstream(Random &random) const {
    haptic::EventPtr event;
    switch (below(random, 4)) {
    case 0:
      event.reset(gst_event_new_seek(below(random, 2) ? -0.5 : 1, GST_FORMAT_TIME,
                                     below(random, 2) ? GST_SEEK_FLAG_FLUSH : GST_SEEK_FLAG_NONE,
                                     GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, 4 * GST_SECOND));
      break;
    case 1:
      event.reset(gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 1.5, 1, GST_SECOND));
      break;
    case 2:
      event.reset(gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM,
                                       gst_structure_new_empty("GstForceKeyUnit")));
      break;
    default:
      haptic::PointerPosition position;
      position.x = 0.1 * below(random, 10);
      event = haptic::make_pointer_event(position);
    }
    // GstBaseParse frees a seek when a segment answers it, and again when upstream refuses it.
    const bool alone = spares("GstBaseParse") && GST_EVENT_TYPE(event.get()) == GST_EVENT_SEEK;
    const Alone guard(alone ? element() : nullptr);
    gst_element_send_event(element(), event.release());
  }

  void query(Random &random) const {
    const haptic::CapsPtr caps(gst_caps_from_string(GetParam().input.front()));
    std::vector<std::function<GstQuery *()>> makers{
        [] { return gst_query_new_latency(); },
        [] { return gst_query_new_seeking(GST_FORMAT_TIME); },
        [] { return gst_query_new_caps(nullptr); },
        [] { return gst_query_new_convert(GST_FORMAT_TIME, GST_SECOND / 30, GST_FORMAT_BYTES); },
        [&] { return gst_query_new_accept_caps(caps.get()); }};
    // GstBaseTransform reads its segment for the position without a lock.
    if (!spares("GstBaseTransform"))
      makers.emplace_back([] { return gst_query_new_position(GST_FORMAT_TIME); });
    // GstAggregator uses a serialised query on when a flush has given it back.
    if (!spares_aggregator()) {
      makers.emplace_back([&] { return gst_query_new_allocation(caps.get(), TRUE); });
      makers.emplace_back([] { return gst_query_new_drain(); });
    }
    const haptic::QueryPtr query(makers[below(random, static_cast<guint>(makers.size()))]());
    const GstQueryType type = GST_QUERY_TYPE(query.get());
    if (below(random, 2) || type == GST_QUERY_DRAIN) {
      gst_pad_peer_query(harness_->srcpad, query.get());
      return;
    }
    // GstPad answers with the fixed caps of a source pad, which it no longer holds.
    const bool alone = (type == GST_QUERY_CAPS || type == GST_QUERY_ACCEPT_CAPS) &&
                       (spares("GstBaseParse") || spares("GstRTPBaseDepayload"));
    const Alone guard(alone ? element() : nullptr);
    gst_element_query(element(), query.get());
  }

  void set_property(Random &random) const {
    guint count = 0;
    const std::unique_ptr<GParamSpec *, decltype(&g_free)> list(
        g_object_class_list_properties(G_OBJECT_GET_CLASS(element()), &count), g_free);
    GParamSpec *spec = list.get()[below(random, count)];
    if (spec->owner_type != G_OBJECT_TYPE(element()))
      return;
    GValue value = G_VALUE_INIT;
    if (spec->flags & G_PARAM_READABLE) {
      g_object_get_property(G_OBJECT(element()), spec->name, &value);
      g_value_unset(&value);
    }
    if (!(spec->flags & G_PARAM_WRITABLE) || G_IS_PARAM_SPEC_STRING(spec) ||
        g_str_equal(spec->name, "dead-man")) // device=none has no button, and would not open
      return;
    g_value_init(&value, spec->value_type);
    g_param_value_set_default(spec, &value);
    if (G_IS_PARAM_SPEC_ENUM(spec) && below(random, 2)) {
      const auto *kind = G_PARAM_SPEC_ENUM(spec)->enum_class;
      g_value_set_enum(&value, kind->values[below(random, kind->n_values)].value);
    } else if (G_IS_PARAM_SPEC_DOUBLE(spec) && below(random, 2)) {
      g_value_set_double(&value, G_PARAM_SPEC_DOUBLE(spec)->minimum);
    } else if (G_IS_PARAM_SPEC_BOOLEAN(spec)) {
      g_value_set_boolean(&value, below(random, 2) != 0);
    }
    g_object_set_property(G_OBJECT(element()), spec->name, &value);
    g_value_unset(&value);
  }

  void emit(Random &random) const {
    static constexpr const char *kSignals[] = {"arm", "release", "calibrate"};
    const char *signal = kSignals[below(random, std::size(kSignals))];
    if (g_signal_lookup(signal, G_OBJECT_TYPE(element())) != 0)
      g_signal_emit_by_name(element(), signal);
  }

  void use_request_pad(GstPadTemplate *of, Random &random) const {
    const haptic::PadPtr pad(gst_element_request_pad(element(), of, nullptr, nullptr));
    if (!pad)
      return;
    const haptic::PadPtr source(gst_pad_new("source", GST_PAD_SRC));
    gst_pad_set_active(source.get(), TRUE);
    if (gst_pad_link(source.get(), pad.get()) == GST_PAD_LINK_OK) {
      push_stream(source.get(), {HAPTIC_RELIEF_CAPS}, random);
      push_event(source.get(), random);
    }
    gst_element_release_request_pad(element(), pad.get());
  }

  // A state that waits for data gets it while the others go on.
  void change_states(int changes) {
    Random random(static_cast<Random::result_type>(seed_));
    static constexpr GstState kStates[] = {GST_STATE_NULL, GST_STATE_READY, GST_STATE_PAUSED,
                                           GST_STATE_PLAYING, GST_STATE_PLAYING};
    for (int change = 0; change < changes; ++change) {
      gst_element_set_state(element(), kStates[below(random, std::size(kStates))]);
      for (const guint before = acts_; acts_ - before < 4 * attacks_.size();)
        std::this_thread::yield();
    }
  }

  GstElement *element() const { return harness_->element; }

  std::size_t seed_ = 0;
  std::vector<std::string_view> forgiven_;
  HarnessPtr harness_;
  std::vector<std::unique_ptr<Attack>> attacks_;
  std::vector<GstHarnessThread *> threads_;
  std::atomic<guint> acts_ = 0;
};

TEST_P(Torture, AnElementSurvivesAllAtOnce) {
  const Victim &victim = GetParam();
  const haptic::ElementPtr made(gst_element_factory_make(victim.factory, nullptr));
  if (!made)
    GTEST_SKIP() << victim.factory << " is not built";
  g_object_set(made.get(), g_str_equal(victim.factory, "hapticsink") ? "device" : "name",
               g_str_equal(victim.factory, "hapticsink") ? "none" : "victim", nullptr);
  const int seeds = from_environment("FEELING_WIND_SEEDS", 1);
  for (seed_ = 1; seed_ <= static_cast<std::size_t>(seeds); ++seed_) {
    std::printf("%s, seed %zu\n", victim.factory, seed_);
    std::fflush(stdout); // before it crashes
    const bool is_sink = GST_OBJECT_FLAG_IS_SET(made.get(), GST_ELEMENT_FLAG_SINK);
    harness_.reset(
        gst_harness_new_with_element(made.get(), victim.sink, is_sink ? nullptr : "src"));
    const haptic::BusPtr bus(gst_bus_new());
    gst_bus_set_sync_handler(
        bus.get(), [](GstBus *, GstMessage *, gpointer) { return GST_BUS_DROP; }, nullptr, nullptr);
    gst_element_set_bus(element(), bus.get());
    judge_critical_warnings();
    if (is_sink)
      g_object_set(element(), "sync", FALSE, nullptr);
    else
      gst_harness_set_drop_buffers(harness_.get(), TRUE);
    if (!victim.output.empty())
      gst_harness_set_sink_caps_str(harness_.get(), victim.output[seed_ % victim.output.size()]);
    GstPadTemplate *relief = gst_element_get_pad_template(element(), "relief");

    std::vector<std::function<void(Random &)>> ways{
        [&](Random &random) { push_stream(harness_->srcpad, victim.input, random); },
        [&](Random &random) { push_event(harness_->srcpad, random); },
        [&](Random &random) { send_upstream(random); },
        [&](Random &random) { query(random); },
        [&](Random &random) { set_property(random); },
        [&](Random &random) { emit(random); }};
    if (g_strcmp0(victim.control, "WaitsForEver") == 0)
      ways.resize(2); // it does within seconds
    if (relief)
      ways.emplace_back([&, relief](Random &random) { use_request_pad(relief, random); });
    // Names get their place in GLib's table, whose lock ThreadSanitizer does not see.
    if (Random names(0); seed_ == 1)
      for (const auto &way : ways)
        for (int i = 0; i < 50; ++i)
          way(names);
    while (attacks_.size() < kThreads)
      attack(ways[attacks_.size() % ways.size()]);
    change_states(from_environment("FEELING_WIND_TORTURE", 20));
    gst_element_set_state(element(), GST_STATE_NULL); // and nothing waits any longer
    for (GstHarnessThread *thread : std::exchange(threads_, {}))
      gst_harness_stress_thread_stop(thread);
    attacks_.clear();
    EXPECT_EQ(gst_element_set_state(element(), GST_STATE_READY), GST_STATE_CHANGE_SUCCESS);
    EXPECT_EQ(gst_element_set_state(element(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
    gst_element_set_bus(element(), nullptr);
    harness_.reset();
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, Torture, testing::ValuesIn(kVictims),
                         [](const auto &victim) { return std::string(victim.param.factory); });
INSTANTIATE_TEST_SUITE_P(DISABLED_Controls, Torture, testing::ValuesIn(kControls),
                         [](const auto &control) { return std::string(control.param.control); });

// The controls of the exceptions that need no chance.

// Holds a thread inside GStreamer until another one goes on: for 5 s, if that one waits.
class Hold {
public:
  void stay() {
    is_inside_ = true;
    came_.release();
    (void)may_go_.try_acquire_for(std::chrono::seconds(5));
    is_inside_ = false;
  }
  void await() { came_.acquire(); }
  void release() { may_go_.release(); }
  bool is_inside() const { return is_inside_; }

private:
  std::binary_semaphore came_{0}, may_go_{0};
  std::atomic<bool> is_inside_ = false;
};

std::atomic<Hold *> hold_of_stream_time;

struct DISABLED_Controls : testing::Test {
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
};

TEST_F(DISABLED_Controls, ASegmentIsReplacedWhileItIsReadForThePosition) {
  const HarnessPtr harness(gst_harness_new("capsfilter"));
  gst_harness_set_src_caps_str(harness.get(), kSmall); // and a segment of time
  Hold hold;
  hold_of_stream_time = &hold;
  const std::jthread replaces([&] {
    hold.await();
    GstSegment bytes;
    gst_segment_init(&bytes, GST_FORMAT_BYTES);
    gst_pad_push_event(harness->srcpad, gst_event_new_segment(&bytes));
    hold.release();
  });
  g_test_expect_message("GStreamer", G_LOG_LEVEL_CRITICAL, "*segment->format == format*");
  const haptic::QueryPtr position(gst_query_new_position(GST_FORMAT_TIME));
  gst_pad_peer_query(harness->srcpad, position.get());
  hold_of_stream_time = nullptr;
  g_test_assert_expected_messages();
}

TEST_F(DISABLED_Controls, ASegmentInBytesBackwardsHasNoEnd) {
  const HarnessPtr harness(gst_harness_new("mpegaudioparse"));
  gst_harness_set_src_caps_str(harness.get(), "audio/mpeg, mpegversion=1");
  gst_pad_set_event_function(harness->srcpad,
                             [](GstPad *, GstObject *, GstEvent *event) -> gboolean {
                               gst_event_unref(event);
                               return FALSE; // so that the parser seeks
                             });
  GstSegment bytes;
  gst_segment_init(&bytes, GST_FORMAT_BYTES);
  bytes.rate = -0.5;
  bytes.stop = 4 * GST_SECOND;
  gst_pad_push_event(harness->srcpad, gst_event_new_segment(&bytes));
  g_test_expect_message("GStreamer", G_LOG_LEVEL_CRITICAL, "*stop != -1*");
  gst_element_send_event(harness->element,
                         gst_event_new_seek(1, GST_FORMAT_TIME, GST_SEEK_FLAG_NONE,
                                            GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, GST_SECOND));
  g_test_assert_expected_messages();
}

// A flush comes while the task sends its first event: it then sends neither the segment, which
// would have a number, nor waits, and the end of the stream gets the number that was never set.
TEST_F(DISABLED_Controls, TheEndOfAStreamHasNoNumberAmidAFlush) {
  const HarnessPtr harness(gst_harness_new_with_padnames("mpegtsmux", "sink_%d", "src"));
  Hold hold;
  gst_pad_set_event_function_full(
      harness->sinkpad,
      [](GstPad *pad, GstObject *, GstEvent *event) -> gboolean {
        auto &of_task = *static_cast<Hold *>(pad->eventdata);
        if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START)
          of_task.stay();
        if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START)
          of_task.release();
        gst_event_unref(event);
        return TRUE;
      },
      &hold, nullptr);
  g_test_expect_message("GStreamer", G_LOG_LEVEL_CRITICAL, "*seqnum != GST_SEQNUM_INVALID*");
  gst_harness_play(harness.get());
  gst_pad_push_event(harness->srcpad, gst_event_new_stream_start("control"));
  gst_pad_push_event(harness->srcpad, gst_event_new_eos());
  hold.await();
  gst_pad_push_event(harness->srcpad, gst_event_new_flush_start()); // until the task has stopped
  g_test_assert_expected_messages();
}

// A segment answers a seek that is refused all the same. glibc ends the program there; the
// allocator of ThreadSanitizer does not, and gives the block to two owners.
TEST_F(DISABLED_Controls, ASeekIsFreedTwice) {
  const HarnessPtr harness(gst_harness_new("mpegaudioparse"));
  gst_harness_set_src_caps_str(harness.get(), "audio/mpeg, mpegversion=1");
  gst_pad_set_event_function(harness->srcpad,
                             [](GstPad *pad, GstObject *, GstEvent *event) -> gboolean {
                               GstFormat format = GST_FORMAT_UNDEFINED;
                               if (GST_EVENT_TYPE(event) == GST_EVENT_SEEK)
                                 gst_event_parse_seek(event, nullptr, &format, nullptr, nullptr,
                                                      nullptr, nullptr, nullptr);
                               gst_event_unref(event);
                               if (format == GST_FORMAT_BYTES) {
                                 GstSegment bytes;
                                 gst_segment_init(&bytes, format);
                                 gst_pad_push_event(pad, gst_event_new_segment(&bytes));
                               }
                               return FALSE;
                             });
  gst_element_send_event(harness->element,
                         gst_event_new_seek(1, GST_FORMAT_TIME, GST_SEEK_FLAG_NONE,
                                            GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, GST_SECOND));
  struct Seek { // as in gstbaseparse.c
    GstSegment segment;
    gboolean accurate;
    gint64 offset;
    GstClockTime start;
  };
  const std::unique_ptr<Seek, decltype(&g_free)> one(g_new(Seek, 1), g_free);
  EXPECT_EQ(one.get(), g_new(Seek, 1));
}

// The pad gives its lock back before it takes a reference to the caps: its message in between tells
// when. Without the reference of this test, they were freed there.
TEST_F(DISABLED_Controls, AQueryUsesCapsThatItDoesNotHold) {
  struct Watched {
    haptic::PadPtr pad{gst_pad_new("src", GST_PAD_SRC)};
    haptic::CapsPtr caps{gst_caps_new_empty_simple("audio/x-raw")};
    int references = 0; // to the caps, when the pad has given its own back
  } watched;
  gst_pad_use_fixed_caps(watched.pad.get());
  gst_pad_set_active(watched.pad.get(), TRUE);
  gst_pad_push_event(watched.pad.get(), gst_event_new_stream_start("control"));
  gst_pad_push_event(watched.pad.get(), gst_event_new_caps(watched.caps.get()));
  const GstLogFunction watch = [](GstDebugCategory *, GstDebugLevel, const gchar *, const gchar *,
                                  gint, GObject *, GstDebugMessage *message, gpointer data) {
    auto &it = *static_cast<Watched *>(data);
    if (!g_str_has_prefix(gst_debug_message_get(message), "using caps") || it.references != 0)
      return;
    gst_pad_set_active(it.pad.get(), FALSE);
    it.references = GST_CAPS_REFCOUNT_VALUE(it.caps.get());
  };
  gst_debug_remove_log_function(gst_debug_log_default);
  gst_debug_add_log_function(watch, &watched, nullptr);
  gst_debug_set_threshold_for_name("GST_CAPS", GST_LEVEL_DEBUG);
  const haptic::QueryPtr query(gst_query_new_caps(nullptr));
  gst_pad_query(watched.pad.get(), query.get());
  gst_debug_remove_log_function(watch);
  EXPECT_EQ(watched.references, 1);
}

// The controls of tests/suppressions/tsan.supp: nothing orders the threads but what GLib and
// GStreamer do.
void do_in_two_threads(const std::function<void()> &act) {
  const std::jthread one(act);
  const std::jthread other(act);
}

TEST_F(DISABLED_Controls, TwoThreadsWarn) {
  do_in_two_threads([] {
    for (int i = 0; i < 10; ++i)
      g_warning("this is a control");
  });
}

TEST_F(DISABLED_Controls, TwoThreadsUseTheSameNewNames) {
  do_in_two_threads([] {
    for (int i = 0; i < 100; ++i)
      gst_structure_free(gst_structure_new_empty(("control-" + std::to_string(i)).c_str()));
  });
}

TEST_F(DISABLED_Controls, TwoThreadsMakeErrors) {
  do_in_two_threads([] {
    for (int i = 0; i < 10; ++i)
      g_error_free(g_error_new_literal(GST_CORE_ERROR, GST_CORE_ERROR_FAILED, "this is a control"));
  });
}

TEST_F(DISABLED_Controls, ATaskBeginsAgainInAThreadThatWasKept) {
  const HarnessPtr harness(gst_harness_new("queue"));
  for (int i = 0; i < 100; ++i) {
    gst_element_set_state(harness->element, GST_STATE_PLAYING);
    gst_element_set_state(harness->element, GST_STATE_NULL);
  }
}

TEST_F(DISABLED_Controls, CapsAreFreedByAnotherThreadThanTheOneThatReadThem) {
  HarnessPtr harness(gst_harness_new("identity"));
  std::atomic<bool> was_read = false; // relaxed: it orders nothing
  const std::jthread reads([&, pad = harness->srcpad] {
    {
      const haptic::CapsPtr caps(gst_caps_from_string(kSmall));
      gst_pad_push_event(pad, gst_event_new_stream_start("control"));
      gst_pad_push_event(pad, gst_event_new_caps(caps.get()));
      GstVideoInfo info;
      gst_video_info_from_caps(&info, caps.get());
    }
    was_read.store(true, std::memory_order_relaxed);
  });
  while (!was_read.load(std::memory_order_relaxed))
    std::this_thread::yield();
  harness.reset();
}

TEST_F(DISABLED_Controls, AQueryIsGivenBackWhileItIsUsed) {
  const HarnessPtr harness(gst_harness_new_with_padnames("mpegtsmux", "sink_%d", "src"));
  Hold hold;
  gst_pad_set_query_function_full(
      harness->sinkpad,
      [](GstPad *pad, GstObject *parent, GstQuery *query) -> gboolean {
        if (GST_QUERY_TYPE(query) != GST_QUERY_DRAIN)
          return gst_pad_query_default(pad, parent, query);
        static_cast<Hold *>(pad->querydata)->stay();
        return TRUE;
      },
      &hold, nullptr);
  gst_harness_play(harness.get());
  gst_pad_push_event(harness->srcpad, gst_event_new_stream_start("control"));
  const std::jthread flushes([&] {
    hold.await();
    gst_pad_push_event(harness->srcpad, gst_event_new_flush_start());
  });
  const haptic::QueryPtr drain(gst_query_new_drain());
  gst_pad_peer_query(harness->srcpad, drain.get());
  EXPECT_TRUE(hold.is_inside());
  hold.release();
}

} // namespace torture_test

// GstBaseTransform calls this one. (A program's functions come before those of the libraries.)
guint64 gst_segment_to_stream_time(const GstSegment *segment, GstFormat format, guint64 position) {
  if (torture_test::Hold *hold = torture_test::hold_of_stream_time)
    hold->stay();
  static const auto next = reinterpret_cast<decltype(&gst_segment_to_stream_time)>(
      dlsym(RTLD_NEXT, "gst_segment_to_stream_time"));
  return next(segment, format, position);
}
