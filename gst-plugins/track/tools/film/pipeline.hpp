// SPDX-License-Identifier: LGPL-2.1-or-later
// Pipelines of haptic-track and their errors. Every film is opened by a FilePipeline.
#pragma once

#include "glue/gst-raii.hpp"
#include "track-error.hpp"

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <gst/gst.h>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace haptic {

/// Called some times a second while a pipeline runs. What it throws ends the work.
using Poll = std::function<void()>;

inline constexpr GstClockTime kPollTime = 200 * GST_MSECOND;
inline constexpr GstClockTime kLongestStandstill = 30 * GST_SECOND;

/// The pipeline owns the element. Throws TrackFileError if there is no such one.
GstElement *add_element(GstElement *pipeline, const char *factory, const char *name = nullptr);

/// Returns what a line in the syntax of gst-launch-1.0 names. Throws TrackFileError.
ElementPtr make_pipeline(const std::string &line);
/// Adds what a line names as a bin, which the pipeline owns. Throws TrackFileError.
GstElement *add_bin(GstElement *pipeline, const std::string &line);
/// Returns the element of this name, or null.
ElementPtr element_in(GstElement *pipeline, const char *name);

/// The tag image-orientation of an event; empty if the event has none.
std::string rotation_of(GstEvent *event);

/// Returns the segment in which the buffers of the pad are, or nothing before the first one.
std::optional<GstSegment> segment_of(GstPad *pad);

// Both return the time of a frame (ns), or GST_CLOCK_TIME_NONE. In AVI, frames that depend on
// others have a decoding time only.
GstClockTime running_time_of(GstPad *pad, const GstBuffer *buffer);
GstClockTime stream_time_of(GstPad *pad, const GstBuffer *buffer);
/// The same, ns, negative of what an edit list hides before the first shown frame: that one may
/// depend on it. Nothing for a frame without a time, and for one behind the end.
std::optional<std::int64_t> signed_stream_time_of(GstPad *pad, const GstBuffer *buffer);

/// Returns the caps of a caps event, or null.
GstCaps *caps_in(GstEvent *event);

/// Ends the pipeline of the pad with an error of this text, which wait_for() throws.
void fail(GstPad *pad, const char *text);

/// Calls `call` with the pad and what passes it, in the pad's streaming thread, as long as the pad
/// exists. What `call` takes by reference it may put another in place of. What it returns false for
/// is dropped. An exception of `call` ends the pipeline with its text, and drops a buffer.
template <GstPadProbeType type, auto content_of, typename Call>
void add_probe(GstPad *pad, Call call) {
  const auto run = [](GstPad *at, GstPadProbeInfo *info, gpointer data) {
    Call &with = *static_cast<Call *>(data);
    auto *content = content_of(info);
    bool passes = true;
    try {
      if constexpr (std::is_void_v<decltype(with(at, content))>)
        with(at, content);
      else
        passes = with(at, content);
    } catch (const std::exception &error) {
      fail(at, error.what());
      passes = type != GST_PAD_PROBE_TYPE_BUFFER; // without its segment, a pad warns of each buffer
    }
    GST_PAD_PROBE_INFO_DATA(info) = content;
    return passes ? GST_PAD_PROBE_OK : GST_PAD_PROBE_DROP;
  };
  gst_pad_add_probe(pad, type, run, new Call(std::move(call)),
                    [](gpointer data) { delete static_cast<Call *>(data); });
}
template <typename Call>
void watch_buffers(GstPad *pad, Call call) {
  add_probe<GST_PAD_PROBE_TYPE_BUFFER, gst_pad_probe_info_get_buffer>(pad, std::move(call));
}
template <typename Call>
void watch_events(GstPad *pad, Call call) {
  add_probe<GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, gst_pad_probe_info_get_event>(pad,
                                                                               std::move(call));
}

/// Returns the first message of these types. Throws TrackFileError with the error of the pipeline
/// instead, or when the process was interrupted.
MessagePtr wait_for(GstElement *pipeline, GstMessageType wanted, const Poll &poll = {});

/// Notices when nothing flows any more: damaged files let some elements wait for ever.
class Flow {
public:
  /// What passes this pad is progress.
  void watch(GstPad *pad);
  /// To be called by each Poll. Throws the sentence, with the s in it, after so long without
  /// progress. Polls are counted, not seconds: a process that was stopped does not poll.
  void check(const char *sentence, GstClockTime longest = kLongestStandstill);

private:
  std::atomic<std::size_t> flowed_ = 0; // buffers
  std::size_t before_ = 0;
  GstClockTime still_ = 0;
};

/// Lets a pipeline run until this goes.
class Running {
public:
  explicit Running(GstElement *pipeline, GstState state = GST_STATE_PLAYING) : pipeline_(pipeline) {
    gst_element_set_state(pipeline_, state);
  }
  ~Running() { gst_element_set_state(pipeline_, GST_STATE_NULL); }
  Running(const Running &) = delete;
  Running &operator=(const Running &) = delete;

private:
  GstElement *pipeline_;
};

/// The only way in which a film or another container is opened. What its content names is never
/// opened (glue/content-only.hpp).
class FilePipeline {
public:
  /// The file flows to a `reader`: parsebin, decodebin or a demuxer, with its properties; `rest` is
  /// what follows it, " ! " first. Throws TrackFileError. Initializes GStreamer.
  FilePipeline(const std::string &path, const std::string &reader, const std::string &rest = {});
  ~FilePipeline() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  FilePipeline(const FilePipeline &) = delete;
  FilePipeline &operator=(const FilePipeline &) = delete;

  GstElement *get() const noexcept { return pipeline_.get(); }
  GstElement *reader() const noexcept { return reader_; }

  /// What passes this pad is progress, as what is read from the file is.
  void watch(GstPad *pad) { flow_.watch(pad); }
  /// Sets the state, and waits as wait_for() does. Throws the sentence after so long without
  /// progress.
  MessagePtr run(GstState state, GstMessageType wanted, const char *sentence,
                 GstClockTime longest = kLongestStandstill);

private:
  ElementPtr pipeline_;
  GstElement *reader_;
  Flow flow_;
};

} // namespace haptic
