// SPDX-License-Identifier: LGPL-2.1-or-later
// The request pad `relief` of elements that take reliefs beside what comes to their pad `sink`.
#pragma once

#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "samples/relief-field.hpp"

#include <atomic>
#include <memory>
#include <mutex>

namespace haptic {

inline GstPadTemplate *relief_pad_template() {
  static GstStaticPadTemplate relief = GST_STATIC_PAD_TEMPLATE(
      "relief", GST_PAD_SINK, GST_PAD_REQUEST, GST_STATIC_CAPS(HAPTIC_RELIEF_CAPS));
  return gst_static_pad_template_get(&relief);
}

/// Adds the pad. Behind the barrier it calls `stream`, which lives as long: chain(parent, buffer)
/// and handle(event) in the streaming thread, set_active(active) in any.
template <typename Stream>
GstPad *add_stream_pad(GstElement *element, GstPadTemplate *of, std::unique_ptr<Stream> stream) {
  GstPad *pad = gst_pad_new_from_template(of, "relief");
  gst_pad_set_element_private(pad, stream.get());
  g_object_set_data_full(G_OBJECT(pad), "stream", stream.release(),
                         [](gpointer data) { delete static_cast<Stream *>(data); });
  static constexpr auto kStreamOf = [](GstPad *of_pad) -> Stream & {
    return *static_cast<Stream *>(gst_pad_get_element_private(of_pad));
  };
  gst_pad_set_chain_function(pad, [](GstPad *self, GstObject *parent, GstBuffer *taken) {
    const BufferPtr buffer(taken);
    return guarded(parent, GST_FLOW_ERROR,
                   [&] { return kStreamOf(self).chain(parent, buffer.get()); });
  });
  gst_pad_set_event_function(pad, [](GstPad *self, GstObject *parent, GstEvent *taken) -> gboolean {
    const EventPtr event(taken); // the end of the stream is that of the pad `sink`
    guarded(parent, [&] { kStreamOf(self).handle(event.get()); });
    return TRUE;
  });
  gst_pad_set_activatemode_function(
      pad, [](GstPad *self, GstObject *parent, GstPadMode mode, gboolean active) -> gboolean {
        guarded(parent, [&] { kStreamOf(self).set_active(active != FALSE); });
        return mode == GST_PAD_MODE_PUSH;
      });
  gst_pad_set_active(pad, TRUE); // GStreamer complains of another one on an element that runs
  return gst_element_add_pad(element, pad) ? pad : nullptr;
}

/// A pad of which an element has one at most, requested and released by any thread, also while the
/// state changes. It is active while the element runs, whatever the state is called meanwhile.
class RequestedPad {
public:
  /// Returns what `add` returns, or null while there is a pad.
  template <typename Add>
  GstPad *request(GstElement *element, const Add &add) {
    if (there_.exchange(true))
      return nullptr;
    GstPad *pad = guarded(element, static_cast<GstPad *>(nullptr), add);
    there_ = pad != nullptr;
    if (!pad)
      return nullptr;
    const std::lock_guard lock(mutex_);
    gst_pad_set_active(pad, running_);
    return pad;
  }
  /// After the pad was removed.
  void released() { there_ = false; }

  /// Before the pads are activated, and before they are deactivated.
  void set_running(bool running) {
    const std::lock_guard lock(mutex_);
    running_ = running;
  }

private:
  std::atomic<bool> there_ = false;
  std::mutex mutex_;
  bool running_ = false; // mutex_
};

} // namespace haptic
