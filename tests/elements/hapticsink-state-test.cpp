// SPDX-License-Identifier: LGPL-2.1-or-later
// Every state change from every callback of hapticsink: no abort, no deadlock. Callbacks that only
// GStreamer's base classes make (EOS, ASYNC_DONE, STATE_CHANGED) are theirs.
#include "hapticsink-fixture.hpp"

#include <condition_variable>
#include <cstdio>
#include <list>
#include <mutex>
#include <string>

namespace hapticsink_state_test {

using namespace std::chrono_literals;
using namespace test;

// Ends the program when a case hangs, and names the case and what it was waiting for.
class Watchdog {
public:
  explicit Watchdog(std::string name)
      : thread_([this, name = std::move(name)](const std::stop_token &stop) {
          std::unique_lock lock(mutex_);
          wake_.wait_for(lock, stop, 60s, [] { return false; });
          if (stop.stop_requested())
            return;
          std::fprintf(stderr, "%s: for a minute this did not come: %s\n", name.c_str(),
                       awaited_.load());
          std::_Exit(1);
        }) {}

  void waits_for(const char *what) { awaited_ = what; }

private:
  std::atomic<const char *> awaited_ = "the device's force";
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

enum class Provocation { none, release, damaged, end, ready };

struct Callback {
  const char *name;
  const char *signal = nullptr; // of the element
  bool when_disarmed = false;   // not when the device is opened, which notifies of `armed` too
  const char *structure = nullptr;
  GstMessageType message = GST_MESSAGE_UNKNOWN;
  GstStreamStatusType status = GST_STREAM_STATUS_TYPE_CREATE;
  GstPadProbeType probe = GST_PAD_PROBE_TYPE_INVALID;
  bool by_the_changing_thread = false; // a handler in the thread that changes the state
  Provocation provocation = Provocation::none;
  const char *properties = "device=sim";
};

// The grip flies off: the loop disarms, and the pointer thread finds it.
constexpr const char *kFliesOff = "device=sim sim-hand=free max-force=5 slew-rate=1000 damping=0";

const Callback kCallbacks[] = {
    {.name = "notify::armed when the grip flies off",
     .signal = "notify::armed",
     .when_disarmed = true,
     .properties = kFliesOff},
    {.name = "notify::armed by release",
     .signal = "notify::armed",
     .when_disarmed = true,
     .by_the_changing_thread = true,
     .provocation = Provocation::release},
    {.name = "notify::session-state", .signal = "notify::session-state"},
    {.name = "stream status CREATE",
     .message = GST_MESSAGE_STREAM_STATUS,
     .status = GST_STREAM_STATUS_TYPE_CREATE,
     .by_the_changing_thread = true},
    {.name = "stream status ENTER",
     .message = GST_MESSAGE_STREAM_STATUS,
     .status = GST_STREAM_STATUS_TYPE_ENTER},
    {.name = "stream status LEAVE",
     .message = GST_MESSAGE_STREAM_STATUS,
     .status = GST_STREAM_STATUS_TYPE_LEAVE,
     .by_the_changing_thread = true,
     .provocation = Provocation::ready},
    {.name = "the warning of a fault", .message = GST_MESSAGE_WARNING, .properties = kFliesOff},
    {.name = "the warning of a damaged sample",
     .message = GST_MESSAGE_WARNING,
     .provocation = Provocation::damaged},
    {.name = "the error of a device that cannot be opened",
     .message = GST_MESSAGE_ERROR,
     .by_the_changing_thread = true,
     .properties = "device=toaster"},
    {.name = "hapticsink-stats",
     .structure = "hapticsink-stats",
     .message = GST_MESSAGE_ELEMENT,
     .provocation = Provocation::end},
    {.name = "haptic-session", .structure = "haptic-session", .message = GST_MESSAGE_ELEMENT},
    {.name = "a pointer event",
     .structure = "haptic-pointer",
     .probe = GST_PAD_PROBE_TYPE_EVENT_UPSTREAM},
};

// The state change that a handler makes, once.
class Change {
public:
  Change(const Callback &callback, GstElement *pipeline, GstElement *sink, GstState state,
         bool meanwhile)
      : callback_(callback), pipeline_(pipeline), sink_(sink), state_(state),
        meanwhile_(meanwhile) {}

  void connect() {
    if (callback_.signal)
      handler_ = g_signal_connect(sink_, callback_.signal, G_CALLBACK(on_notify), this);
    if (callback_.message != GST_MESSAGE_UNKNOWN)
      set_sync_handler(on_message);
    if (callback_.probe != GST_PAD_PROBE_TYPE_INVALID) {
      GstPad *pad = gst_element_get_static_pad(sink_, "sink");
      gst_pad_add_probe(pad, callback_.probe, on_event, this, nullptr);
      gst_object_unref(pad);
    }
  }
  void disconnect() {
    if (handler_ != 0)
      g_signal_handler_disconnect(sink_, handler_);
    if (callback_.message != GST_MESSAGE_UNKNOWN)
      set_sync_handler(nullptr);
  }

  std::atomic<bool> begun = false;
  std::atomic<bool> stopping = false; // another thread is about to change the state
  std::atomic<bool> done = false;

private:
  void make() {
    if (begun.exchange(true))
      return;
    if (meanwhile_) {
      stopping.wait(false);
      std::this_thread::sleep_for(20ms); // that thread is in the state change now
    }
    gst_element_set_state(pipeline_, state_);
    done = true;
  }
  bool is_meant(GstMessage *message) const {
    if (GST_MESSAGE_TYPE(message) != callback_.message ||
        GST_MESSAGE_SRC(message) != GST_OBJECT(sink_))
      return false;
    if (callback_.structure)
      return gst_message_has_name(message, callback_.structure);
    if (callback_.message != GST_MESSAGE_STREAM_STATUS)
      return true;
    GstStreamStatusType type;
    gst_message_parse_stream_status(message, &type, nullptr);
    return type == callback_.status;
  }
  void set_sync_handler(GstBusSyncHandler function) {
    GstBus *bus = gst_element_get_bus(pipeline_);
    gst_bus_set_sync_handler(bus, function, this, nullptr);
    gst_object_unref(bus);
  }

  static void on_notify(GObject *sink, GParamSpec * /*property*/, gpointer data) {
    auto *change = static_cast<Change *>(data);
    gboolean armed = FALSE;
    g_object_get(sink, "armed", &armed, nullptr);
    if (!change->callback_.when_disarmed || !armed)
      change->make();
  }
  static GstBusSyncReply on_message(GstBus * /*bus*/, GstMessage *message, gpointer data) {
    auto *change = static_cast<Change *>(data);
    if (change->is_meant(message))
      change->make();
    return GST_BUS_PASS;
  }
  static GstPadProbeReturn on_event(GstPad * /*pad*/, GstPadProbeInfo *info, gpointer data) {
    auto *change = static_cast<Change *>(data);
    if (gst_event_has_name(gst_pad_probe_info_get_event(info), change->callback_.structure))
      change->make();
    return GST_PAD_PROBE_OK;
  }

  const Callback &callback_;
  GstElement *pipeline_;
  GstElement *sink_;
  GstState state_;
  bool meanwhile_;
  gulong handler_ = 0;
};

class StateFromCallback : public HapticSink {
protected:
  void provoke(const Callback &callback) {
    if (callback.provocation == Provocation::damaged) {
      GstBuffer *buffer = gst_buffer_new_allocate(nullptr, 7, nullptr);
      GST_BUFFER_PTS(buffer) = pts_;
      push(buffer);
    }
    // To and fro: a grip that reached its stop while the machine stood still flies off later.
    if (callback.provocation == Provocation::end)
      push_motion(1000, 0, 0.1);
    else
      for (int n = 0; n < 40; ++n)
        push_motion(n % 2 == 0 ? 1000 : -1000, 0, 0.5);
    if (callback.provocation == Provocation::end)
      push_end();
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
    if (callback.provocation == Provocation::release) {
      EXPECT_TRUE(eventually([&] { return armed(); }));
      g_signal_emit_by_name(sink_.get(), "release");
    }
    if (callback.provocation == Provocation::ready)
      gst_element_set_state(pipeline_.get(), GST_STATE_READY);
  }

  /// `meanwhile`: another thread stops the pipeline while the handler is about to change the state.
  void run(const Callback &callback, GstState state, bool meanwhile) {
    const std::string name = std::string(callback.name) + " -> " +
                             gst_element_state_get_name(state) + (meanwhile ? ", meanwhile" : "");
    SCOPED_TRACE(name);
    Watchdog watchdog(name);
    build(callback.properties);
    ASSERT_TRUE(sink_);
    pts_ = 0;
    // Never destroyed: a handler may still be running.
    static std::list<Change> changes;
    Change &change = changes.emplace_back(callback, pipeline_.get(), sink_.get(), state, meanwhile);
    change.connect();
    provoke(callback);
    watchdog.waits_for("the callback");
    EXPECT_TRUE(eventually([&] { return change.begun.load(); }));
    watchdog.waits_for("the end of the changes of state");
    if (meanwhile) {
      change.stopping = true;
      change.stopping.notify_all();
      gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
    }
    EXPECT_TRUE(eventually([&] { return change.done.load(); }));
    change.disconnect();
    stop();
    EXPECT_FALSE(armed());
    watchdog.waits_for("ticks after the next start");
    expect_usable(callback);
  }

  void expect_usable(const Callback &callback) {
    if (callback.message == GST_MESSAGE_ERROR)
      return;
    g_signal_emit_by_name(sink_.get(), "arm");
    set(GST_STATE_PLAYING);
    EXPECT_TRUE(eventually([&] { return count("ticks") > 0; }));
    stop();
    EXPECT_FALSE(armed());
  }
};

TEST_F(StateFromCallback, EveryChangeFromEveryCallbackEnds) {
  for (const Callback &callback : kCallbacks)
    for (const GstState state : {GST_STATE_PAUSED, GST_STATE_READY, GST_STATE_NULL})
      run(callback, state, false);
}

TEST_F(StateFromCallback, EveryChangeFromEveryCallbackEndsWhileAnotherThreadStops) {
  for (const Callback &callback : kCallbacks)
    for (const GstState state : {GST_STATE_PAUSED, GST_STATE_READY, GST_STATE_NULL})
      if (!callback.by_the_changing_thread)
        run(callback, state, true);
}

} // namespace hapticsink_state_test
