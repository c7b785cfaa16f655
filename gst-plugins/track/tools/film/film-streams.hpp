// SPDX-License-Identifier: LGPL-2.1-or-later
// The coded streams of a film, held in a pipeline until each has its place.
#pragma once

#include "film/pipeline.hpp"

#include <atomic>
#include <gst/gst.h>
#include <string>
#include <utility>
#include <vector>

namespace haptic {

/// What the streams are for. A decoder may begin at any key frame: the parameter sets are repeated
/// there.
enum class FilmUse { copy, decode };

class FilmStreams {
public:
  /// Opens the film and waits until all its streams are known. None flows before play(). Throws
  /// TrackFileError, also where nothing is read for so long. Initializes GStreamer.
  FilmStreams(const std::string &path, FilmUse use,
              GstClockTime longest_standstill = kLongestStandstill);

  GstElement *pipeline() const noexcept { return file_.get(); }
  GstPad *video() const noexcept { return video_; } ///< the first one
  /// In the order of the file.
  const std::vector<GstPad *> &all() const noexcept { return all_; }
  const std::vector<GstPad *> &audio() const noexcept { return audio_; }
  const std::vector<GstPad *> &others() const noexcept { return others_; }

  /// What passes this pad is progress, too: decoding goes on when all is read.
  void watch(GstPad *pad) { file_.watch(pad); }
  /// Lets the streams flow, each of which is linked, to their end or until an application message.
  /// Nothing flows after it, also if it throws TrackFileError with the error of the pipeline, or
  /// because nothing flowed for so long.
  void play(GstClockTime longest_standstill = kLongestStandstill);

private:
  static void block(GstElement *, GstPad *pad, gpointer data);
  void wait_for_streams(GstClockTime longest);
  void sort();

  // The source's streaming thread until all streams are known, then the main thread.
  std::vector<std::pair<PadPtr, gulong>> streams_; // each held by a probe
  std::atomic<std::size_t> shown_ = 0;
  std::string unknown_; // caps of a stream that no parser knows
  GstPad *video_ = nullptr;
  std::vector<GstPad *> all_;
  std::vector<GstPad *> audio_;
  std::vector<GstPad *> others_;
  FilePipeline file_; // ends first: its threads use the rest
};

/// Links a stream of a pipeline, which ends when each of its sinks has an end, to one. Throws
/// nothing. Returns the sink.
GstElement *read_to_end(GstElement *pipeline, GstPad *pad);

/// Drops what comes from the pad. A sink would hold the thread of the demuxer until the decoder has
/// a frame, which waits for that thread.
void discard_stream(GstPad *pad);

} // namespace haptic
