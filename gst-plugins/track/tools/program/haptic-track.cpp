// SPDX-License-Identifier: LGPL-2.1-or-later
// Shows, converts, cuts, plots, compares and authors haptic tracks. See docs/haptic-track.md.
#include "author/author.hpp"
#include "felt/force-log.hpp"
#include "forms/klv.hpp"
#include "package/package.hpp"
#include "plot/track-plot.hpp"
#include "program/compare.hpp"
#include "program/usage.hpp"
#include "samples/motion-field.hpp"
#include "samples/motion-force.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"
#include "tracks/film-cut.hpp"
#include "tracks/track-file.hpp"
#include "vibration/vibration-file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <gst/gst.h>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace {

using haptic::CodedField;
namespace messages = haptic::messages;
using haptic::seconds;
using haptic::throw_error;
using haptic::TrackFile;
using haptic::TrackFileError;
using haptic::TrackSample;

constexpr unsigned kMostSpans = 1'000'000; // of a plan

// With the first of these options a verb takes these alone, else what its help explains.
constexpr std::pair<std::string_view, std::string_view> kModes[] = {
    {"--plan", "--plan --chunks --output --columns --hold"},
    {"--chunk", "--chunk"},
    {"--merge", "--merge"},
    {"--single", "--single --columns --hold --output"}};

struct Arguments {
  std::string command;
  std::vector<std::string> options; // as given, without their values
  std::vector<std::string> files;
  haptic::AuthorOptions author;
  haptic::CompareOptions compare; // with what other verbs take, too
  haptic::PlotOptions plot;
  haptic::VibrationOptions vibration;
  haptic::Carriage carriage = haptic::Carriage::fragments;
  std::optional<unsigned> chunk;
  unsigned chunks = 0;
  unsigned jobs = std::max(1U, std::thread::hardware_concurrency());
  double alpha = haptic::kDefaultAlpha; // s/px

  bool has(std::string_view option) const { return std::ranges::count(options, option) > 0; }
};

// Reads a number from `least` to `most`. Returns false if the text is none.
template <typename Number>
bool read(const std::string &text, Number least, Number most, Number &value) {
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() && end.ptr == text.data() + text.size() && value >= least &&
         value <= most;
}

// Reads two numbers with this character between them. Returns false if the text is none.
template <typename Number>
bool read_pair(const std::string &text, char between, Number least, Number most, Number &first,
               Number &second) {
  const std::size_t middle = std::min(text.find(between), text.size());
  return middle < text.size() && read(text.substr(0, middle), least, most, first) &&
         read(text.substr(middle + 1), least, most, second);
}

void read_hold(const std::string &text, haptic::HoldOptions &hold) {
  if (text == "auto") {
    hold.chooses = true;
    return;
  }
  const auto point = haptic::read_hold_point(text);
  if (!point || hold.points.size() == haptic::kMostFieldThings)
    throw_error(messages::kHoldIsWrong, text.c_str(), haptic::kMostFieldThings);
  hold.points.push_back(*point);
}

haptic::Carriage parse_carriage(const std::string &text) {
  if (text != "ts" && text != "mp4" && text != "cmaf") // the name of mp4 before
    throw_error(messages::kCarriageIsUnknown, text.c_str());
  return text == "ts" ? haptic::Carriage::transport_stream : haptic::Carriage::fragments;
}

// Takes the text of an option. Throws TrackFileError. A flag has none.
using Option = std::function<void(const std::string &option, const std::string &text)>;

Option word(std::string &value) {
  return [&value](auto &, auto &text) { value = text; };
}

template <typename Value, typename Number>
Option number(Value &value, Number least, Number most) {
  return [=, &value](auto &option, auto &text) {
    Number parsed = 0;
    if (read(text, least, most, parsed))
      value = parsed;
    else if constexpr (std::is_integral_v<Number>)
      throw_error(messages::kOptionNeedsCount, option.c_str(), least, most, text.c_str());
    else
      throw_error(messages::kOptionNeedsNumber, option.c_str(), least, most, text.c_str());
  };
}

Option time(std::optional<double> &value) {
  return [&value](auto &option, auto &text) {
    if (!read(text, 0.0, 1e9, value.emplace()))
      throw_error(messages::kOptionNeedsSeconds, option.c_str(), text.c_str());
  };
}

std::map<std::string, Option> options_of(Arguments &all) {
  return {
      {"--plan", {}},
      {"--merge", {}},
      {"--single", {}},
      {"--force", {}},
      {"--json", {}},
      {"--with-video", {}},
      {"--output", word(all.author.folder)},
      {"--stream", word(all.compare.stream)},
      {"--layout", word(all.vibration.layout)},
      {"--map", word(all.vibration.map)},
      {"--hand", word(all.compare.hand)},
      {"--plot", word(all.compare.plot)},
      {"--chunk", number(all.chunk, 0U, kMostSpans)},
      {"--chunks", number(all.chunks, 1U, kMostSpans)},
      {"--jobs", number(all.jobs, 1U, 1024U)},
      {"--columns", number(all.author.columns, haptic::kFewestColumns, haptic::kMostColumns)},
      {"--from", time(all.compare.from)},
      {"--to", time(all.compare.to)},
      {"--at-most", number(all.compare.at_most, 0.0, 100.0)},
      {"--offset", number(all.compare.offset, -1e6, 1e6)},
      {"--shift", number(all.compare.shift, -2.0, 2.0)},
      {"--alpha", number(all.alpha, 0.0001, 10.0)},
      {"--max-force", number(all.compare.law.max_force, 0.01, haptic::kHighestForce)},
      {"--hold", [&](auto &, auto &text) { read_hold(text, all.author.hold); }},
      {"--carriage", [&](auto &, auto &text) { all.carriage = parse_carriage(text); }},
      {"--place",
       [&](auto &option, auto &text) {
         if (!read_pair(text, ',', 0.0, 1.0, all.plot.x, all.plot.y))
           throw_error(messages::kOptionNeedsPlace, option.c_str(), text.c_str());
       }},
      {"--places",
       [&](auto &option, auto &text) {
         if (!read_pair(text, 'x', 1U, 32U, all.compare.columns, all.compare.rows))
           throw_error(messages::kOptionNeedsPlaces, option.c_str(), text.c_str());
       }},
  };
}

// The help of the verb among these words, or else of all.
const char *usage_of(const std::vector<std::string> &words) {
  for (const auto &[verb, text] : haptic::kUsageOfVerbs)
    if (std::ranges::count(words, verb) > 0)
      return text;
  return haptic::kUsage;
}

// Whether the option stands in this help, or in a list of options.
bool explains(std::string_view help, const std::string &option) {
  return option.find(' ') == std::string::npos &&
         (' ' + std::string(help) + ' ').find(' ' + option + ' ') != std::string::npos;
}

void check_options(const Arguments &arguments) {
  std::string verb = arguments.command;
  std::string_view help = usage_of({verb});
  for (const auto &[mode, options] : kModes)
    if (arguments.has(mode) && explains(help, std::string(mode))) {
      verb += ' ' + std::string(mode);
      help = options;
    }
  for (const std::string &option : arguments.options)
    if (!explains(help, option) || (option == "--chunks" && !arguments.has("--plan")))
      throw_error(messages::kOptionIsForeign, option.c_str(), verb.c_str());
}

Arguments parse_arguments(const std::vector<std::string> &words) {
  Arguments arguments;
  const auto options = options_of(arguments);
  bool options_end = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    // "--name=value" is "--name value".
    const std::size_t equals = words[i].starts_with("--") ? words[i].find('=') : std::string::npos;
    const bool has_value = !options_end && equals != std::string::npos;
    const std::string word = has_value ? words[i].substr(0, equals) : words[i];
    if (!options_end && word == "--") {
      options_end = true;
    } else if (options_end || !word.starts_with("-")) {
      if (arguments.command.empty() && !options_end)
        arguments.command = word;
      else
        arguments.files.push_back(word);
    } else {
      const auto found = options.find(word);
      if (found == options.end())
        throw_error(messages::kOptionIsUnknown, word.c_str());
      const Option &set = found->second;
      if (has_value && !set)
        throw_error(messages::kOptionTakesNoValue, word.c_str());
      if (set && !has_value && ++i == words.size())
        throw_error(messages::kOptionNeedsValue, word.c_str());
      if (set)
        set(word, has_value ? words[i].substr(equals + 1) : words[i]);
      arguments.options.push_back(word);
    }
  }
  arguments.vibration.alpha = arguments.compare.law.alpha = arguments.alpha;
  return arguments;
}

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
    keys += haptic::is_key_field(coded.bytes);
    bytes += haptic::write_klv(coded).size();
  }
  info_of_times(fields.front().time, fields.back().time, fields.size());
  const double length = seconds(fields.back().time) - seconds(fields.front().time);
  std::printf("  keys       %zu\n", keys);
  if (length > 0)
    std::printf("  size       %.1f kbit/s as KLV\n", 8e-3 * static_cast<double>(bytes) / length);
}

// `known`: what a share of the cells is.
template <typename Cell>
void info_of_grid(const haptic::Field<Cell> &field, const char *known, double share) {
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
  haptic::ReliefDecoder decoder;
  double cells = 0;
  double surface = 0;
  haptic::ReliefCell least = {haptic::kMostReliefHeight, haptic::kMostReliefStiffness,
                              haptic::kMostReliefFriction, 1};
  haptic::ReliefCell most = {-haptic::kMostReliefHeight, 0, 0, 0};
  for (const auto &coded : reliefs) {
    if (decoder.push(coded.bytes) != haptic::ReliefDecoder::Result::field)
      continue;
    cells += static_cast<double>(decoder.field().cells.size());
    for (const auto &cell : decoder.field().cells) {
      if (!(cell.validity > 0))
        continue;
      ++surface;
      for (auto number : {&haptic::ReliefCell::height, &haptic::ReliefCell::stiffness,
                          &haptic::ReliefCell::friction}) {
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
  haptic::MotionField first;
  haptic::for_each_field(fields, [&](const haptic::MotionField &field, std::uint64_t) {
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
    const auto force = haptic::force_of_motion(s);
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
  const TrackFile track = haptic::read_track_file(path, stream);
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
}

void check_may_be_written(const Arguments &arguments, const std::string &output) {
  if (!arguments.has("--force") && std::filesystem::exists(output))
    throw_error(messages::kOutputExists, output.c_str());
}

int info(const Arguments &arguments) {
  int status = EXIT_SUCCESS;
  for (const auto &file : arguments.files)
    try {
      print_info(file, arguments.compare.stream);
    } catch (const TrackFileError &error) {
      haptic::print_error(error.what());
      status = EXIT_FAILURE;
    }
  return status;
}

TrackFile read_some(const Arguments &arguments) {
  const std::string &path = arguments.files[0];
  TrackFile track = haptic::read_track_file(path, arguments.compare.stream);
  haptic::print_remarks(path, track.remarks);
  if (track.holds_nothing())
    throw_error(messages::kTrackIsEmpty, path.c_str());
  haptic::leave_reliefs_out(path, track);
  return track;
}

int write(const std::string &output, const TrackFile &track,
          const haptic::VibrationOptions &vibration = {}) {
  haptic::stop_when_interrupted();
  if (haptic::is_vibration_file(output))
    haptic::write_vibration_file(output, track, vibration);
  else
    haptic::write_track_file(output, track);
  return EXIT_SUCCESS;
}

int convert(const Arguments &arguments) {
  check_may_be_written(arguments, arguments.files[1]);
  TrackFile track = read_some(arguments);
  if (!arguments.compare.hand.empty() && !track.reliefs.empty())
    throw_error(messages::kHandTouches, arguments.files[0].c_str());
  if (!arguments.compare.hand.empty() && !track.fields.empty()) {
    track.samples =
        haptic::samples_at_hand(track.fields, haptic::read_hand(arguments.compare.hand));
    track.fields.clear();
  }
  // A track beside its video begins with the video, whose copy in a recording begins later.
  const std::string &output = arguments.files[1];
  const bool is_of_video = track.film_begin != haptic::kNoTime;
  if (haptic::is_vibration_file(output) || (is_of_video && output.ends_with(".klv")))
    haptic::move_times(track, -static_cast<std::int64_t>(haptic::times_of(track).first));
  return write(output, track, arguments.vibration);
}

int cut(const Arguments &arguments) {
  check_may_be_written(arguments, arguments.files[1]);
  TrackFile track = read_some(arguments);
  const auto from =
      static_cast<std::uint64_t>(std::llround(arguments.compare.from.value_or(0) * 1e9));
  const auto to =
      static_cast<std::uint64_t>(std::llround(arguments.compare.to.value_or(1e9) * 1e9));
  if (arguments.has("--with-video")) {
    haptic::stop_when_interrupted();
    haptic::naming(arguments.files[0], [&] {
      haptic::cut_film(arguments.files[0], std::move(track), from, to, arguments.files[1]);
    });
    return EXIT_SUCCESS;
  }
  haptic::cut_track(track, from, to);
  if (track.holds_nothing())
    throw_error(messages::kCutIsEmpty, arguments.files[0].c_str());
  return write(arguments.files[1], track);
}

int plot(const Arguments &arguments) {
  check_may_be_written(arguments, arguments.files[1]);
  const std::string &file = arguments.files[0];
  haptic::PlotOptions options = arguments.plot;
  if (!arguments.compare.hand.empty())
    options.hand = haptic::read_hand(arguments.compare.hand);
  haptic::plot_track(file, read_some(arguments), options, arguments.files[1]);
  return EXIT_SUCCESS;
}

int compare(const Arguments &arguments) {
  haptic::CompareOptions options = arguments.compare;
  options.json = arguments.has("--json");
  check_may_be_written(arguments, options.plot);
  return haptic::compare(arguments.files[0], arguments.files[1], options);
}

int author(const Arguments &arguments) {
  const auto &files = arguments.files;
  if ((arguments.chunk || arguments.has("--merge")) && files.size() != 1)
    throw_error(messages::kCommandNeedsPlan, arguments.chunk ? "--chunk" : "--merge");
  if (files.empty())
    throw_error(messages::kCommandNeedsFiles, "author", "a video");
  if (arguments.chunk)
    return haptic::author_chunk(files[0], *arguments.chunk);
  if (arguments.has("--merge"))
    return haptic::merge_chunks(files[0]);
  return arguments.has("--plan") ? haptic::plan_authoring(files, arguments.author, arguments.chunks)
                                 : haptic::author(files, arguments.author, arguments.jobs);
}

int package(const Arguments &arguments) {
  if (arguments.author.folder.empty())
    throw_error(messages::kPackageNeedsFolder);
  if (arguments.has("--single"))
    return haptic::package_single(arguments.files, arguments.author);
  return haptic::package(arguments.files, {arguments.carriage, arguments.author});
}

struct Verb {
  std::string_view name;
  int (*run)(const Arguments &arguments); // returns the exit status
  std::size_t least, most;                // files
  const char *needs;
};
constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();
constexpr Verb kVerbs[] = {
    {"info", info, 1, kAny, "a file"},          {"convert", convert, 2, 2, "a file and an output"},
    {"cut", cut, 2, 2, "a file and an output"}, {"plot", plot, 2, 2, "a file and an output"},
    {"compare", compare, 2, 2, "two files"},    {"author", author, 0, kAny, ""},
    {"package", package, 1, kAny, "a video"}};

int run(const Arguments &arguments) {
  const std::string &name = arguments.command;
  if (name.empty())
    throw_error(messages::kCommandIsMissing);
  const auto *verb = std::ranges::find(kVerbs, name, &Verb::name);
  if (verb == std::end(kVerbs))
    throw_error(messages::kCommandIsUnknown, name.c_str());
  check_options(arguments);
  if (const std::size_t count = arguments.files.size(); count < verb->least || count > verb->most)
    throw_error(messages::kCommandNeedsFiles, name.c_str(), verb->needs);
  if (verb->run != author) // it forks
    gst_init(nullptr, nullptr);
  return verb->run(arguments);
}

} // namespace

int main(int argc, char **argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  for (const std::string &word : words)
    if (word == "--help" || word == "-h" || word == "--version") {
      std::fputs(word == "--version" ? "haptic-track " VERSION "\n" : usage_of(words), stdout);
      return EXIT_SUCCESS;
    }
  try {
    return run(parse_arguments(words));
  } catch (const std::exception &error) {
    haptic::print_error(error.what());
    return haptic::is_interrupted() ? haptic::kInterrupted : EXIT_FAILURE;
  }
}
