// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads and writes haptic tracks as files of every form.
#pragma once

#include "core/track-sample.hpp"
#include "glue/gst-raii.hpp"
#include "track-error.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <gst/gst.h>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haptic {

/// EBML header: what a Matroska file begins with.
inline constexpr std::string_view kMatroskaMagic = "\x1a\x45\xdf\xa3";

struct TrackFile {
  std::string form;                   ///< for people to read
  std::string stream;                 ///< name of its pad at the demuxer; of a bare track empty
  std::vector<std::string> others;    ///< names of further haptic tracks
  std::vector<std::string> surfaces;  ///< those of `others` that hold reliefs
  std::vector<std::string> beside;    ///< caps of the other streams in the file
  std::uint64_t film_begin = kNoTime; ///< ns, of the first frame of the video beside it
  std::vector<std::string> remarks;   ///< what is remarkable and ends nothing
  bool is_untied = false;             ///< nothing ties its times to the video
  std::vector<TrackSample> samples;   ///< with times; or else
  std::vector<CodedField> fields;     ///< of motion, with times
  std::vector<CodedField> reliefs;    ///< with times

  /// Whether there is no motion.
  bool empty() const noexcept { return samples.empty() && fields.empty(); }
  /// The fields, or the reliefs of a track without motion.
  const std::vector<CodedField> &coded() const noexcept { return empty() ? reliefs : fields; }
  bool holds_nothing() const noexcept { return empty() && reliefs.empty(); }
  /// Calls `call` with each sample, field and relief.
  template <typename Call>
  void for_each(const Call &call) {
    std::ranges::for_each(samples, call);
    std::ranges::for_each(fields, call);
    std::ranges::for_each(reliefs, call);
  }
};

/// Reads a file by its content, whatever its name. Of several haptic tracks in a container the
/// first one, or `stream`. Throws TrackFileError.
TrackFile read_track_file(const std::string &path, const std::string &stream = {});

/// The same without reliefs beside motion. Prints the remarks on the standard error.
TrackFile read_one_kind(const std::string &path, const std::string &stream);

/// s, of the first frame of the video beside the track; nothing if the track does not say it.
std::optional<double> film_begin_of(const TrackFile &track);

/// ns; of a track that holds nothing as they stand here.
struct TrackTimes {
  std::uint64_t first = kNoTime;
  std::uint64_t last = 0;
};
TrackTimes times_of(const TrackFile &track);

/// Adds so many ns to all times, none of which becomes negative.
void move_times(TrackFile &track, std::int64_t by);

/// Writes the form that the ending names: .ts, .mkv, .klv, .txt, .hmpg, .hjif. The file appears
/// under its name when it is whole. Throws TrackFileError.
void write_track_file(const std::string &path, const TrackFile &track);

/// Lets the elements of `line`, in the syntax of gst-launch-1.0, take the track to its end.
/// `prepare` gets the pipeline before it starts. `path` is of errors. Throws TrackFileError, also
/// when the process was interrupted.
void play_track(const std::string &path, const TrackFile &track, const std::string &line,
                const std::function<void(GstElement *pipeline)> &prepare);

/// Writes what such elements make of the track. The file appears under its name when it is whole.
void write_container(const std::string &path, const TrackFile &track, const std::string &line,
                     const std::function<void(GstElement *pipeline)> &prepare = {});

/// Removes what is not within [from, to) (ns). What is left begins at 0.
void cut_track(TrackFile &track, std::uint64_t from, std::uint64_t to);

/// Writes a part of the film `path`, whose track is `track`, as .ts or .mkv, nothing encoded anew.
/// It begins with the last key frame of the first video that is not behind `from` (ns), ends before
/// the first one that is not before `to`, and its times begin at 0, or later by as much as a key
/// frame is decoded before it is shown. Where that key frame is hidden by an edit list, the part
/// shows it and what follows. Says on the standard error what is left out.
/// Throws TrackFileError, which leaves nothing behind.
void cut_film(const std::string &path, TrackFile track, std::int64_t from, std::int64_t to,
              const std::string &output);

/// Returns whether the buffer begins with a sample or field of this project.
bool is_own_track(GstBuffer *buffer);

/// Returns a field as KLV.
BufferPtr make_field_buffer(const CodedField &field, GstClockTime time, GstClockTime duration);

/// Pushes the track into an appsrc that runs, and its end.
void push_track(GstElement *in, const TrackFile &track);

struct TrackSource {
  GstElement *in;    ///< an appsrc
  GstElement *coded; ///< its source pad has what the muxer gets
};

/// Adds an appsrc for a track of samples, or of fields or reliefs as KLV, and links it to the
/// muxer. Throws TrackFileError.
TrackSource add_track_source(GstElement *pipeline, bool is_coded, GstElement *mux,
                             bool is_matroska);

} // namespace haptic
