// SPDX-License-Identifier: LGPL-2.1-or-later
// Shows, converts, cuts, plots, compares and authors haptic tracks. See docs/haptic-track.md.
#include "author/author.hpp"
#include "felt/force-log.hpp"
#include "forms/klv.hpp"
#include "program/command-line.hpp"
#include "samples/motion-field.hpp"
#include "samples/motion-force.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"
#include "tracks/track-file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace haptic {
namespace {

void info_of_times(std::uint64_t first, std::uint64_t last, std::size_t samples) {
  const double length = seconds(last) - seconds(first);
  std::printf("  time       %.3f to %.3f s", seconds(first), seconds(last));
  if (length > 0)
    std::printf(", %.4g samples a second", static_cast<double>(samples - 1) / length);
  std::printf("\n");
}

void info_of_code(const std::vector<CodedField> &fields) {
  std::size_t keys = 0;
  std::size_t bytes = 0;
  for (const auto &coded : fields) {
    keys += is_key_field(coded.bytes);
    bytes += write_klv(coded).size();
  }
  info_of_times(fields.front().time, fields.back().time, fields.size());
  const double length = seconds(fields.back().time) - seconds(fields.front().time);
  std::printf("  keys       %zu\n", keys);
  if (length > 0)
    std::printf("  size       %.1f kbit/s as KLV\n", 8e-3 * static_cast<double>(bytes) / length);
}

// `known`: what a share of the cells is.
template <typename Cell>
void info_of_grid(const Field<Cell> &field, const char *known, double share) {
  std::printf("  grid       %u x %u cells\n", field.columns, field.rows);
  std::printf("  %-10s %.1f %% of the cells\n", known, 100 * share);
  std::printf("  frame      %u x %u px, pixels %u:%u\n", field.frame_width, field.frame_height,
              field.pixel_aspect_n, field.pixel_aspect_d);
}

// What was measured at some places.
struct Speeds {
  std::size_t count = 0;
  double sum = 0; // px/s
  double fastest = 0;

  void add(double x, double y) {
    const double speed = std::hypot(x, y);
    ++count;
    sum += speed;
    fastest = std::max(fastest, speed);
  }
  void print() const {
    if (count > 0)
      std::printf("  speed      %.1f px/s on average, %.1f at most\n",
                  sum / static_cast<double>(count), fastest);
  }
};

void info_of_reliefs(const std::vector<CodedField> &reliefs) {
  std::printf("  reliefs    %zu\n", reliefs.size());
  info_of_code(reliefs);
  ReliefDecoder decoder;
  double cells = 0;
  double surface = 0;
  ReliefCell least = {kMostReliefHeight, kMostReliefStiffness, kMostReliefFriction, 1};
  ReliefCell most = {-kMostReliefHeight, 0, 0, 0};
  for (const auto &coded : reliefs) {
    if (decoder.push(coded.bytes) != ReliefDecoder::Result::field)
      continue;
    cells += static_cast<double>(decoder.field().cells.size());
    for (const auto &cell : decoder.field().cells) {
      if (!(cell.validity > 0))
        continue;
      ++surface;
      for (auto number : {&ReliefCell::height, &ReliefCell::stiffness, &ReliefCell::friction}) {
        least.*number = std::min(least.*number, cell.*number);
        most.*number = std::max(most.*number, cell.*number);
      }
    }
  }
  if (!(cells > 0))
    return;
  info_of_grid(decoder.field(), "surface", surface / cells);
  if (!(surface > 0))
    return;
  std::printf("  height     %.1f to %.1f mm\n", 1e3 * static_cast<double>(least.height),
              1e3 * static_cast<double>(most.height));
  std::printf("  stiffness  %.0f to %.0f N/m\n", static_cast<double>(least.stiffness),
              static_cast<double>(most.stiffness));
  std::printf("  friction   %.2f to %.2f\n", static_cast<double>(least.friction),
              static_cast<double>(most.friction));
}

void info_of_fields(const std::vector<CodedField> &fields) {
  std::printf("  fields     %zu\n", fields.size());
  info_of_code(fields);
  std::size_t decoded = 0;
  std::set<std::uint16_t> things; // of the field before
  std::size_t things_begun = 0;
  Speeds measured;
  double cells = 0;
  MotionField first;
  for_each_field(fields, [&](const MotionField &field, std::uint64_t) {
    if (decoded++ == 0)
      first = field;
    cells += static_cast<double>(field.cells.size());
    std::set<std::uint16_t> now;
    for (const auto &thing : field.things)
      things_begun += now.insert(thing.id).second && !things.contains(thing.id);
    things = std::move(now);
    for (const auto &cell : field.cells)
      if (cell.confidence > 0)
        measured.add(cell.velocity_x, cell.velocity_y);
  });
  if (decoded == 0)
    return;
  info_of_grid(first, "measured", static_cast<double>(measured.count) / cells);
  if (things_begun > 0)
    std::printf("  things     %zu\n", things_begun);
  measured.print();
}

void info_of_samples(const std::vector<TrackSample> &samples) {
  const auto &first = samples.front();
  Speeds measured;
  double strongest = 0;
  for (const auto &sample : samples) {
    const auto &s = sample.motion;
    if (!(s.confidence > 0))
      continue;
    measured.add(s.velocity_x, s.velocity_y);
    const auto force = force_of_motion(s);
    strongest = std::max(strongest, std::hypot(force.x, force.y));
  }
  info_of_times(first.time, samples.back().time, samples.size());
  std::printf("  measured   %.1f %% of the samples\n",
              100.0 * static_cast<double>(measured.count) / static_cast<double>(samples.size()));
  std::printf("  frame      %u x %u px, pixels %u:%u\n", first.motion.frame_width,
              first.motion.frame_height, first.motion.pixel_aspect_n, first.motion.pixel_aspect_d);
  measured.print();
  std::printf("  force      %.2f of the full one at most, with the usual settings\n", strongest);
}

void print_info(const std::string &path, const std::string &stream) {
  const TrackFile track = read_track_file(path, stream);
  std::printf("%s: %s\n", path.c_str(), track.form.c_str());
  if (!track.stream.empty())
    std::printf("  stream     %s\n", track.stream.c_str());
  for (const auto &other : track.others)
    std::printf("  another    %s%s\n", other.c_str(),
                std::ranges::count(track.surfaces, other) > 0 ? " (reliefs)" : "");
  for (const auto &other : track.beside)
    std::printf("  beside it  %s\n", other.c_str());
  if (!track.reliefs.empty())
    info_of_reliefs(track.reliefs);
  if (!track.fields.empty())
    info_of_fields(track.fields);
  else if (track.reliefs.empty() || !track.samples.empty())
    std::printf("  samples    %zu\n", track.samples.size());
  if (!track.samples.empty())
    info_of_samples(track.samples);
  for (const auto &remark : track.remarks)
    std::printf("  remark     %s\n", remark.c_str());
  if (track.holds_nothing())
    throw_error(messages::kTrackIsEmpty, path.c_str());
}

void check_may_be_written(const Arguments &arguments, const std::string &output) {
  if (!arguments.overwrites && std::filesystem::exists(output))
    throw_error(messages::kOutputExists, output.c_str());
}

int info(const Arguments &arguments) {
  int status = EXIT_SUCCESS;
  for (const auto &file : arguments.files)
    try {
      print_info(file, arguments.compare.stream);
    } catch (const TrackFileError &error) {
      print_error(error.what());
      status = EXIT_FAILURE;
    }
  return status;
}

TrackFile read_some(const Arguments &arguments) {
  TrackFile track = read_one_kind(arguments.files[0], arguments.compare.stream);
  if (track.holds_nothing())
    throw_error(messages::kTrackIsEmpty, arguments.files[0].c_str());
  return track;
}

int write(const std::string &output, const TrackFile &track,
          const VibrationOptions &vibration = {}) {
  stop_when_interrupted();
  if (is_vibration_file(output))
    write_vibration_file(output, track, vibration);
  else
    write_track_file(output, track);
  return EXIT_SUCCESS;
}

int convert(const Arguments &arguments) {
  check_may_be_written(arguments, arguments.files[1]);
  TrackFile track = read_some(arguments);
  if (!arguments.compare.hand.empty() && !track.reliefs.empty())
    throw_error(messages::kHandTouches, arguments.files[0].c_str());
  if (!arguments.compare.hand.empty() && !track.fields.empty()) {
    track.samples = samples_at_hand(
        track.fields, read_hand(arguments.compare.hand, film_begin_of(track).value_or(0)));
    track.fields.clear();
  }
  // The time 0 is the beginning of a sound, or of the video beside the track, which a recording has
  // later.
  const std::string &output = arguments.files[1];
  const std::uint64_t first = times_of(track).first;
  if (is_vibration_file(output))
    move_times(track, -static_cast<std::int64_t>(first));
  else if (track.film_begin != kNoTime)
    move_times(track, -static_cast<std::int64_t>(std::min(track.film_begin, first)));
  return write(output, track, arguments.vibration);
}

int cut(const Arguments &arguments) {
  check_may_be_written(arguments, arguments.files[1]);
  TrackFile track = read_some(arguments);
  const auto ns = [](double s) {
    return static_cast<std::uint64_t>(std::llround(std::clamp(s, 0.0, 1e9) * 1e9));
  };
  const std::uint64_t from = ns(arguments.compare.range.from);
  const std::uint64_t to = ns(arguments.compare.range.to);
  if (arguments.with_video) {
    stop_when_interrupted();
    naming(arguments.files[0],
           [&] { cut_film(arguments.files[0], std::move(track), from, to, arguments.files[1]); });
    return EXIT_SUCCESS;
  }
  cut_track(track, from, to);
  if (track.holds_nothing())
    throw_error(messages::kCutIsEmpty, arguments.files[0].c_str());
  return write(arguments.files[1], track);
}

int plot(const Arguments &arguments) {
  stop_when_interrupted();
  check_may_be_written(arguments, arguments.files[1]);
  const std::string &file = arguments.files[0];
  PlotOptions options = arguments.plot;
  const TrackFile track = read_some(arguments);
  if (!arguments.compare.hand.empty())
    options.hand = read_hand(arguments.compare.hand, film_begin_of(track).value_or(0));
  plot_track(file, track, options, arguments.files[1]);
  return EXIT_SUCCESS;
}

int compare(const Arguments &arguments) {
  stop_when_interrupted();
  check_may_be_written(arguments, arguments.compare.plot);
  return haptic::compare(arguments.files[0], arguments.files[1], arguments.compare, arguments.json);
}

const AuthorOptions &with_folder(const Arguments &arguments) {
  if (arguments.author.folder.empty())
    throw_error(messages::kPackageNeedsFolder);
  return arguments.author;
}

constexpr char kPlanNeeded[] = "a plan, which author --plan prints";
constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();
constexpr Verb kVerbs[] = {
    {"info", info, 1, kAny, "a file", "FILE...", " stream ",
     R"(Prints what files contain

The kind of each track, its times, its size and what it measured. The exit status is 0 if all files
were read.)",
     "info recorded.ts"},
    {"convert", convert, 2, 2, "a file and an output", "FILE OUTPUT",
     " hand layout map alpha stream force ",
     R"(Writes a track in another format, also as sound

A video beside the track is left out. The ending of OUTPUT chooses the format: .klv, .txt, .ts, .mkv,
.hmpg, .hjif, or vibration: .wav (a channel for each actuator of an array), .ahap (a telephone).
--alpha is for .wav and .ahap. --hand makes points of motion fields: the motion under that hand.)",
     "convert recorded.ts track.klv"},
    {"cut", cut, 2, 2, "a file and an output", "FILE OUTPUT", " from to with-video stream force ",
     R"(Writes a part of a track or of a recording

The part begins at 0 s. Without --with-video it is the track alone.)",
     "cut --from 10 --to 20 recorded.ts part.klv"},
    {"plot", plot, 2, 2, "a file and an output", "FILE OUTPUT", " place hand stream force ",
     R"(Draws a track

OUTPUT.png shows velocity and force over time, or motion fields over frames of the video; OUTPUT.gif,
for motion fields only, a moving picture. --place and --hand are for reliefs.)",
     "plot in.haptic.ts fields.png"},
    {"compare", compare, 2, 2, "two files", "A B",
     " at-most json plot from to offset shift places hand alpha max-force stream force ",
     R"(Prints how much of the time a hand could tell two files apart

Each is a track, or a log of hapticsink (.csv). The result comes from a model of perception, not from
people. --hand is for fields and reliefs, --alpha and --max-force are for tracks.)",
     "compare before.klv after.klv"},
    {"author", [](const Arguments &all) { return author(all.files, all.author, all.jobs); }, 1,
     kAny, "a video", "VIDEO...", " output columns hold jobs ",
     R"(Measures videos, and writes copies with a haptic track

A copy has the motion of the whole frame as a track: NAME.haptic.ts or NAME.haptic.mkv. Video and
sound are copied without re-encoding. A copy that exists is kept, so a second run continues where the
first was stopped. The exit status is 0 if all copies exist.

--hold follows a thing, so that a hand can hold it. X and Y are from 0 to 1 from the top left (default
time: 0 s); with auto, the program chooses the things. author --plan, --chunk and --merge do the same
on many machines.)",
     "author --output authored in.mp4", true},
    {"author --plan",
     [](const Arguments &all) { return plan_authoring(all.files, all.author, all.chunks); }, 1,
     kAny, "a video", "VIDEO... > PLAN", " plan chunks output columns hold ",
     R"(Prints a plan to author videos on many machines

author --chunk measures its chunks, in any order. Then author --merge writes the copies.)",
     "author --plan --chunks 8 in.mp4 > plan.json"},
    {"author --chunk", [](const Arguments &all) { return author_chunk(all.files[0], all.chunk); },
     1, 1, kPlanNeeded, "PLAN", " chunk ",
     R"(Measures a chunk of a plan

K is its number. Chunks are measured in any order.)",
     "author --chunk 0 plan.json"},
    {"author --merge", [](const Arguments &all) { return merge_chunks(all.files[0]); }, 1, 1,
     kPlanNeeded, "PLAN", " merge ",
     R"(Writes the copies of a plan from all its chunks

It also writes a manifest beside them, and removes the chunks.)",
     "author --merge plan.json"},
    {"package",
     [](const Arguments &all) {
       return package(all.files, {all.carriage, with_folder(all)});
     },
     1, kAny, "a video", "--output FOLDER VIDEO...", " output carriage columns hold ",
     R"(Makes a folder for a web server: a page where a video is seen and felt

It holds the segments of the video with its haptic track (HLS), and a player. The video is measured
first if it has no track. Further videos are other bitrates of the same film.
package --single is for one short MP4. --hold is that of author.)",
     "package --output film in.mp4"},
    {"package --single",
     [](const Arguments &all) { return package_single(all.files, with_folder(all)); }, 1, kAny,
     "a video", "--output FOLDER VIDEO.mp4", " single output columns hold ",
     R"(Makes a folder for a web server of one short MP4

It holds the MP4 as it is, its track as one file, and a page.)",
     "package --single --output film in.mp4"}};

} // namespace
} // namespace haptic

int main(int argc, char **argv) {
  try {
    return haptic::run_verb(haptic::kVerbs, argc, argv);
  } catch (const std::exception &error) {
    haptic::print_error(error.what());
    return haptic::is_interrupted() ? haptic::kInterrupted : EXIT_FAILURE;
  }
}
