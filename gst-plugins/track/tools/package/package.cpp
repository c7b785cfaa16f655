// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/package.hpp"

#include "author/author.hpp"
#include "core/track-buffer.hpp"
#include "film/pipeline.hpp"
#include "forms/klv.hpp"
#include "package/film-segments.hpp"
#include "package/fragment-writer.hpp"
#include "package/package-folder.hpp"
#include "package/transport-stream.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"
#include "tracks/source-mark.hpp"
#include "tracks/track-file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <iterator>
#include <optional>

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kLongSegment = 6'000'000'000; // ns
constexpr double kSameAspect = 0.02;                 // sizes are rounded to even numbers
constexpr char kPlaylist[] = "film.m3u8";            // of a bit rate
constexpr char kPoster[] = "poster.jpg";
constexpr char kHead[] = "head.mp4";
// Of a single film.
constexpr char kSingleFilm[] = "film.mp4";
constexpr char kSingleTrack[] = "film.klv";
constexpr char kBundle[] = "feeling-wind.min.js";
constexpr char kBundleLicence[] = "LICENSE";
constexpr std::size_t kMostTrack = 8 << 20; // bytes: MOST_BYTES of film.js in pipelines/web/player
// Of the names of folders: a change of what is written into them changes it.
constexpr char kForm[] = "package 4";

// A bit rate of the film.
struct Rate {
  std::string path;
  FilmPlan plan;
  std::string name; // of its folder
};

std::string package_settings(const AuthorOptions &options) {
  return std::string(kForm) + " columns " + std::to_string(options.columns) +
         settings_of(options.hold);
}

// ---- the films ----------------------------------------------------------------------------------

Rate plan_rate(const std::string &path) {
  Rate rate{path, plan_film(path), {}};
  for (const std::string &caps : rate.plan.format.left_out)
    if (!caps.starts_with("text/") || !holds_track(path)) // which may be the haptic track
      print_remarks(path, {"a further stream was left out: " + caps});
  if (rate.plan.skipped > 0)
    print_remarks(path, {format_text("%zu frames before the first IDR frame were left out",
                                     rate.plan.skipped)});
  if (rate.plan.longest > kLongSegment)
    print_remarks(path, {format_text(messages::kSegmentsAreLong, seconds(rate.plan.longest))});
  return rate;
}

double aspect_of(const FilmFormat &format) {
  return static_cast<double>(format.width) * format.pixel_aspect_n /
         (static_cast<double>(format.height) * format.pixel_aspect_d);
}

// Throws if the rates are not one film.
void compare_rates(const Rate &first, const Rate &other) {
  const auto differ = [&](const std::string &how) {
    throw_error(messages::kRatesDiffer, first.path.c_str(), other.path.c_str(), how.c_str());
  };
  const auto frame = [](const Rate &rate) {
    return rate.plan.end / static_cast<std::int64_t>(rate.plan.times.size());
  };
  if (std::abs(first.plan.end - other.plan.end) > std::max(frame(first), frame(other)))
    differ(
        format_text("they last %.3f and %.3f s", seconds(first.plan.end), seconds(other.plan.end)));
  const double aspect = aspect_of(first.plan.format);
  if (std::abs(aspect_of(other.plan.format) - aspect) > kSameAspect * aspect)
    differ(format_text("their frames are %d x %d and %d x %d px", first.plan.format.width,
                       first.plan.format.height, other.plan.format.width,
                       other.plan.format.height));
  if (first.plan.format.sound.empty() != other.plan.format.sound.empty())
    differ("one has sound");
  if (first.name == other.name)
    differ("they are the same file");
  if (!std::ranges::equal(first.plan.starts, other.plan.starts,
                          [](auto a, auto b) { return std::abs(a - b) <= kSameTime; }))
    print_remarks(other.path, {messages::kRatesAreNotAligned});
}

// ---- the track ----------------------------------------------------------------------------------

// Returns the fields and reliefs of a recording or a copy, or nothing if it has no haptic track.
std::optional<std::vector<CodedField>> fields_in(const std::string &path) {
  if (!holds_track(path))
    return std::nullopt;
  TrackFile track = read_track_file(path);
  print_remarks(path, track.remarks);
  // Motion and surface may be streams of their own.
  for (const std::string &stream : track.others) {
    TrackFile other = read_track_file(path, stream);
    if (track.empty())
      track.fields = std::move(other.fields);
    if (track.reliefs.empty())
      track.reliefs = std::move(other.reliefs);
  }
  if (track.fields.empty() && (track.reliefs.empty() || !track.samples.empty()))
    throw_error(messages::kFilmHasPoints, path.c_str());
  std::ranges::move(track.reliefs, std::back_inserter(track.fields));
  return std::move(track.fields);
}

// Returns the fields and reliefs with times from the first frame of the film on: those of the first
// video that has some, else they are authored from the first video.
std::vector<CodedField> track_of(const std::vector<Rate> &rates, const PackageOptions &options,
                                 const std::string &work) {
  std::optional<std::vector<CodedField>> fields;
  std::int64_t origin = 0;
  for (const Rate &rate : rates)
    if (!fields) {
      fields = fields_in(rate.path);
      origin = rate.plan.origin;
    }
  if (!fields) {
    AuthorOptions author = options.author;
    author.folder = work;
    naming(rates[0].path, [&] {
      const std::string copy = author_film(rates[0].path, author).copy;
      fields = fields_in(copy);
      origin = plan_film(copy).origin;
      if (!fields)
        throw_error(messages::kNoFieldIsDecoded);
    });
  }
  // Those of frames that are left out may have the key of the first that stays.
  const auto first = static_cast<std::uint64_t>(std::max<std::int64_t>(origin - kSameTime, 0));
  if (std::ranges::any_of(*fields, [&](const CodedField &field) { return field.time < first; }))
    fields = with_keys_at(*fields, std::array{first});
  std::vector<CodedField> track;
  for (CodedField &field : *fields) {
    const std::int64_t time = static_cast<std::int64_t>(field.time) - origin;
    if (time < -kSameTime || time >= rates[0].plan.end + kSameTime)
      continue;
    field.time = static_cast<std::uint64_t>(std::max<std::int64_t>(time, 0));
    track.push_back(std::move(field));
  }
  return track;
}

// ---- the files ----------------------------------------------------------------------------------

std::string segment_name(std::size_t number, Carriage carriage) {
  return format_text("%05zu.%s", number + 1, carriage == Carriage::fragments ? "mp4" : "ts");
}

std::string playlist_of(const FilmPlan &plan, Carriage carriage) {
  const bool is_mp4 = carriage == Carriage::fragments;
  std::string text = format_text("#EXTM3U\n#EXT-X-VERSION:%d\n#EXT-X-TARGETDURATION:%ld\n"
                                 "#EXT-X-MEDIA-SEQUENCE:0\n#EXT-X-PLAYLIST-TYPE:VOD\n"
                                 "#EXT-X-INDEPENDENT-SEGMENTS\n",
                                 is_mp4 ? 7 : 6, std::max(1L, std::lround(seconds(plan.longest))));
  if (is_mp4)
    text += format_text("#EXT-X-MAP:URI=\"%s\"\n", kHead);
  // Frames before 0 are those that an edit list hides.
  if (plan.origin < 0)
    text += format_text("#EXT-X-START:TIME-OFFSET=%.6f,PRECISE=YES\n", -seconds(plan.origin));
  for (std::size_t i = 0; i < plan.starts.size(); ++i)
    text += format_text("#EXTINF:%.6f,\n%s\n", seconds(plan.start_of(i + 1) - plan.start_of(i)),
                        segment_name(i, carriage).c_str());
  return text + "#EXT-X-ENDLIST\n";
}

// Returns an IDR frame as JPEG with square pixels.
std::vector<std::uint8_t> poster_of(const FilmFormat &format, const SegmentFrame &frame) {
  try {
    const ElementPtr pipeline = make_pipeline(
        "appsrc name=in caps=video/x-h264,stream-format=byte-stream,alignment=au ! h264parse"
        " ! decodebin caps=video/x-raw(ANY) expose-all-streams=false ! videoconvert ! videoscale"
        " ! video/x-raw,pixel-aspect-ratio=1/1 ! jpegenc quality=85 ! appsink name=out sync=false");
    const ElementPtr in = element_in(pipeline.get(), "in");
    const ElementPtr out = element_in(pipeline.get(), "out");
    const Running running(pipeline.get(), GST_STATE_PAUSED);
    gst_app_src_push_buffer(GST_APP_SRC(in.get()),
                            make_buffer(byte_stream_of(format, frame), 0, GST_SECOND).release());
    gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
    Flow none;
    wait_for(pipeline.get(), GST_MESSAGE_ASYNC_DONE,
             [&] { none.check(messages::kFileStandsStill); });
    const SamplePtr sample(gst_app_sink_try_pull_preroll(GST_APP_SINK(out.get()), 0));
    if (!sample)
      throw TrackFileError("its frames are damaged");
    const ReadableBuffer readable(gst_sample_get_buffer(sample.get()));
    return {readable.bytes().begin(), readable.bytes().end()};
  } catch (const TrackFileError &failure) {
    throw_error(messages::kPosterFails, failure.what());
  }
}

// Writes the segments, the poster and the playlist of a rate.
template <typename Writer>
void write_segments(const Rate &rate, const PackageOptions &options,
                    std::span<const CodedField> track, const std::string &folder, Writer &writer) {
  std::size_t video = 0; // bytes
  std::size_t fields = 0;
  std::size_t reliefs = 0;
  for_each_segment(rate.path, rate.plan, track, [&](const FilmSegment &segment) {
    if (segment.frames.empty())
      throw_error(messages::kFilmChanges, rate.path.c_str());
    for (const SegmentFrame &frame : segment.frames)
      video += frame.bytes.size();
    for (const SegmentField &field : segment.fields)
      ++(field.kind == FieldKind::relief ? reliefs : fields);
    write_bytes(fs::path(folder) / segment_name(segment.number, options.carriage),
                writer.write(segment));
    // The first frames of many films are black.
    if (segment.number == rate.plan.starts.size() / 3)
      write_bytes(fs::path(folder) / kPoster, poster_of(rate.plan.format, segment.frames[0]));
  });
  write_bytes(fs::path(folder) / kPlaylist, playlist_of(rate.plan, options.carriage));
  const double length = seconds(rate.plan.end);
  const auto kilobits = [&](std::size_t bytes) {
    return 8e-3 * static_cast<double>(bytes) / length;
  };
  const std::string more = reliefs > 0 ? format_text(", %zu reliefs", reliefs) : "";
  std::printf("written: %s (%zu segments, at most %.1f s; video %.0f kbit/s; track %.0f kbit/s, "
              "%.1f %% of it, %zu fields%s)\n",
              rate.name.c_str(), rate.plan.starts.size(), seconds(rate.plan.longest),
              kilobits(video), kilobits(writer.track_bytes()),
              100.0 * static_cast<double>(writer.track_bytes()) / static_cast<double>(video),
              fields, more.c_str());
}

void write_rate(const Rate &rate, const PackageOptions &options, std::span<const CodedField> track,
                PackageFolder &folder) {
  const std::string part = folder.begin(rate.name);
  try {
    if (options.carriage == Carriage::fragments) {
      FragmentWriter writer(rate.plan.format);
      write_bytes(fs::path(part) / kHead, writer.head());
      write_segments(rate, options, track, part, writer);
    } else {
      TransportStreamWriter writer(rate.plan.format, rate.plan.reordering);
      write_segments(rate, options, track, part, writer);
    }
    folder.publish(rate.name);
  } catch (const TrackFileError &) {
    std::error_code error;
    fs::remove_all(part, error);
    throw;
  }
}

// The rate that the film states if its times, which Matroska rounds to ms, fit it. Else between the
// first and the last frame: the last one lasts as long as nobody knows.
double frame_rate_of(const FilmPlan &plan) {
  const auto intervals = static_cast<double>(plan.times.size() - 1);
  const double length = seconds(plan.times.back() - plan.times.front());
  const double stated = plan.format.frame_rate;
  if (stated > 0 && std::abs(intervals / stated - length) <= seconds(kSameTime))
    return stated;
  return intervals > 0 ? intervals / length : 1 / seconds(plan.end);
}

// Returns the lines of a rate in the main playlist (RFC 8216, 4.3.4.2).
std::string entry_of(const Rate &rate, const PackageOptions &options, const std::string &folder) {
  double most = 0;
  double all = 0;
  for (std::size_t i = 0; i < rate.plan.starts.size(); ++i) {
    const auto bits = 8 * static_cast<double>(fs::file_size(fs::path(folder) / rate.name /
                                                            segment_name(i, options.carriage)));
    most = std::max(most, bits / seconds(rate.plan.start_of(i + 1) - rate.plan.start_of(i)));
    all += bits;
  }
  const double length = seconds(rate.plan.end);
  const FilmFormat &format = rate.plan.format;
  return format_text(
      "#EXT-X-STREAM-INF:BANDWIDTH=%.0f,AVERAGE-BANDWIDTH=%.0f,CODECS=\"%s\","
      "RESOLUTION=%.0fx%d,FRAME-RATE=%.3f\n%s/%s\n",
      std::ceil(most), std::ceil(all / length),
      (format.video_codec + (format.sound.empty() ? "" : "," + format.sound_codec)).c_str(),
      aspect_of(format) * format.height, format.height, frame_rate_of(rate.plan), rate.name.c_str(),
      kPlaylist);
}

std::vector<Rate> plan_rates(const std::vector<std::string> &videos,
                             const PackageOptions &options) {
  std::vector<Rate> rates;
  rates.reserve(videos.size());
  for (const std::string &video : videos)
    rates.push_back(plan_rate(video));
  // The fields depend on all videos, of which one has them.
  std::string settings = package_settings(options.author) + ' ';
  for (const std::string &video : videos)
    settings += hash_of_file(video);
  for (Rate &rate : rates) {
    rate.name = (options.carriage == Carriage::fragments ? "mp4-" : "ts-") +
                mark_of(hash_of_file(rate.path), settings);
    if (&rate != rates.data())
      compare_rates(rates[0], rate);
  }
  return rates;
}

// Returns the track as sets of KLV with the times of the video itself: a browser counts from the
// begin of the file, not from the first frame.
std::vector<std::uint8_t> single_track(const Rate &rate, const AuthorOptions &author,
                                       const std::string &work, const std::string &mark) {
  std::vector<std::uint8_t> track;
  for (CodedField &field : track_of({rate}, {Carriage::fragments, author}, work)) {
    const std::int64_t time = static_cast<std::int64_t>(field.time) + rate.plan.origin;
    if (time < 0) // of a frame that an edit list hides
      continue;
    field.time = static_cast<std::uint64_t>(time);
    std::vector<std::uint8_t> set = write_klv(field);
    if (track.empty())
      insert_mark(set, mark);
    std::ranges::copy(set, std::back_inserter(track));
  }
  if (track.size() > kMostTrack)
    throw_error(messages::kTrackIsLarge, rate.path.c_str(),
                1e-6 * static_cast<double>(track.size()));
  return track;
}

} // namespace

int package_single(const std::vector<std::string> &videos, const AuthorOptions &options) {
  stop_when_interrupted();
  if (videos.size() != 1 || !videos[0].ends_with(".mp4"))
    throw_error(messages::kSingleNeedsMp4);
  const std::string player = player_folder();
  const fs::path bundle = fs::path(player) / "player" / kBundle;
  if (std::error_code error; !fs::exists(bundle, error))
    throw_error(messages::kBundleIsMissing, bundle.c_str());
  const Rate rate{videos[0], plan_film(videos[0]), {}};
  const std::vector<PackageFile> files = {
      {kBundle, bundle},
      {kBundleLicence, bundle.parent_path() / kBundleLicence},
      {"index.html", fs::path(player) / kSinglePage},
  };
  std::vector<PackageFile> all = files;
  all.insert(all.end(), {{kSingleFilm, videos[0]}, {kSingleTrack, ""}});
  PackageFolder folder(options.folder, kSingleTrack, all);
  const fs::path path = folder.path();
  const std::string hash = hash_of_file(videos[0]);
  const std::string mark = mark_of(hash, package_settings(options));
  if (folder.has(kSingleTrack) && folder.has(kSingleFilm) && mark_in(path / kSingleTrack) == mark &&
      hash_of_file(path / kSingleFilm) == hash) {
    std::printf("there already: %s\n", kSingleTrack);
  } else {
    const std::vector<std::uint8_t> track = single_track(rate, options, folder.work(), mark);
    folder.copy_in(videos[0], kSingleFilm);
    write_bytes(path / kSingleTrack, track);
    std::printf("written: %s and %s (%zu kB)\n", kSingleFilm, kSingleTrack, track.size() / 1000);
  }
  folder.copy_in(files);
  folder.finish();
  std::printf("Open %s from a web server; docs/web.md says how.\n", (path / "index.html").c_str());
  return EXIT_SUCCESS;
}

int package(const std::vector<std::string> &videos, const PackageOptions &options) {
  stop_when_interrupted();
  const std::string player = player_folder();
  const std::vector<Rate> rates = plan_rates(videos, options);
  const std::vector<PackageFile> files = player_files(player);
  std::vector<PackageFile> all = files;
  all.push_back({kPoster, ""});
  PackageFolder folder(options.author.folder, kMainPlaylist, all);
  const auto is_there = [&](const Rate &rate) { return folder.has(rate.name); };
  std::vector<CodedField> track;
  if (!std::ranges::all_of(rates, is_there))
    track = track_of(rates, options, folder.work());
  std::string playlist = format_text("#EXTM3U\n#EXT-X-VERSION:%d\n#EXT-X-INDEPENDENT-SEGMENTS\n",
                                     options.carriage == Carriage::fragments ? 7 : 6);
  std::vector<std::string> names;
  for (const Rate &rate : rates) {
    if (is_there(rate))
      std::printf("there already: %s\n", rate.name.c_str());
    else
      write_rate(rate, options, track, folder);
    std::fflush(stdout);
    playlist += entry_of(rate, options, folder.path());
    names.push_back(rate.name);
  }
  folder.copy_in(files);
  folder.copy_in(folder.path() / names[0] / kPoster, kPoster);
  folder.finish(playlist, names);
  std::printf("Open %s from a web server; docs/web.md has the configuration.\n",
              (folder.path() / "index.html").c_str());
  return EXIT_SUCCESS;
}

} // namespace haptic
