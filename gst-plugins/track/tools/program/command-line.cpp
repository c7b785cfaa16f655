// SPDX-License-Identifier: LGPL-2.1-or-later
#include "program/command-line.hpp"

#include "glue/gst-raii.hpp"
#include "samples/motion-field.hpp"
#include "track-error.hpp"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string_view>
#include <type_traits>

namespace haptic {
namespace {

constexpr unsigned kMostSpans = 1'000'000; // of a plan

// Takes the text of an option; that of a flag is empty. Throws TrackFileError.
using Setter = std::function<void(const std::string &option, const std::string &text)>;

Setter flag(bool &value) {
  return [&value](auto &, auto &) { value = true; };
}

Setter word(std::string &value) {
  return [&value](auto &, auto &text) { value = text; };
}

// Takes as many numbers from `least` to `most` as there are values, as in 0.5,0.25 or 5x3.
template <typename Number, typename... Values>
Setter numbers(Number least, Number most, Values &...values) {
  return [=, &values...](auto &option, auto &text) {
    const char *at = text.data();
    const char *const end = at + text.size();
    const auto take = [&](auto &value) {
      Number number = 0;
      const auto read = std::from_chars(at, end, number);
      value = number;
      at = read.ptr + 1; // at the end, a zero stands there
      return read.ec == std::errc() && number >= least && number <= most &&
             (read.ptr == end || *read.ptr == ',' || *read.ptr == 'x');
    };
    if (!((at <= end && take(values)) && ...) || at != end + 1)
      throw_error(messages::kOptionNeedsNumbers, option.c_str(),
                  sizeof...(values) == 2       ? "two numbers"
                  : std::is_integral_v<Number> ? "a whole number"
                                               : "a number",
                  static_cast<double>(least), static_cast<double>(most), text.c_str());
  };
}

void read_hold(const std::string &text, HoldOptions &hold) {
  if (text == "auto") {
    hold.chooses = true;
    return;
  }
  const auto point = read_hold_point(text);
  if (!point || hold.points.size() == kMostFieldThings)
    throw_error(messages::kHoldIsWrong, text.c_str(), kMostFieldThings);
  hold.points.push_back(*point);
}

Carriage parse_carriage(const std::string &text) {
  if (text != "ts" && text != "mp4" && text != "cmaf") // the name of mp4 before
    throw_error(messages::kCarriageIsUnknown, text.c_str());
  return text == "ts" ? Carriage::transport_stream : Carriage::fragments;
}

struct Option {
  const char *name;
  const char *value; // what the help calls it; null: a flag
  const char *text;
  Setter set;
};

std::vector<Option> options_of(Arguments &all) {
  const Setter nothing = [](auto &, auto &) {}; // it chose the verb
  return {
      {G_OPTION_REMAINING, "", "", [&](auto &, auto &text) { all.files.push_back(text); }},
      {"version", nullptr, "prints the version",
       [](auto &, auto &) {
         std::puts("haptic-track " VERSION);
         std::exit(EXIT_SUCCESS);
       }},
      {"plan", nullptr, "prints a plan for many machines", nothing},
      {"chunk", "K", "measures this chunk of a plan, counted from 0",
       numbers(0U, kMostSpans, all.chunk)},
      {"merge", nullptr, "makes the copies from all chunks of a plan", nothing},
      {"single", nullptr, "the MP4 as it is, its track as one file, and a page", nothing},
      {"output", "FOLDER",
       "where the files go; the folder is made (default of author: beside each video)",
       word(all.author.folder)},
      {"carriage", "FORMAT", "format of the segments: mp4 or ts, which is MPEG-TS (default: mp4)",
       [&](auto &, auto &text) { all.carriage = parse_carriage(text); }},
      {"columns", "N", "columns of the motion field, 4 to 96 (default: 32)",
       numbers(kFewestColumns, kMostColumns, all.author.columns)},
      {"hold", "PLACE", "lets a hand hold a thing: X,Y or X,Y@SECONDS, or auto; up to 32 times",
       [&](auto &, auto &text) { read_hold(text, all.author.hold); }},
      {"jobs", "N", "videos at a time, 1 to 1024 (default: one for each processor core)",
       numbers(1U, 1024U, all.jobs)},
      {"chunks", "N", "about so many chunks (default: one for each minute)",
       numbers(1U, kMostSpans, all.chunks)},
      {"from", "S", "begins here, in seconds of FILE or A (default: at its beginning)",
       numbers(0.0, 1e9, all.compare.range.from)},
      {"to", "S", "ends here, in seconds of FILE or A (default: at its end)",
       numbers(0.0, 1e9, all.compare.range.to)},
      {"with-video", nullptr,
       "also cuts video and sound (.ts, .mkv), at the key frames around the part",
       flag(all.with_video)},
      {"place", "X,Y",
       "for reliefs: draws the height here, 0 to 1 from the top left (default: 0.5,0.5)",
       numbers(0.0, 1.0, all.plot.x, all.plot.y)},
      {"places", "CxR", "for fields, reliefs: columns and rows of places, 1 to 32 (default: 5x3)",
       numbers(1U, 32U, all.compare.columns, all.compare.rows)},
      {"hand", "LOG", "the hand of this log of hapticsink (.csv) feels the track",
       word(all.compare.hand)},
      {"layout", "NAME", "for .wav: layout of hapticarray, by name or path (default: back-3x4)",
       word(all.vibration.layout)},
      {"map", "MAP", "for .wav: stroke, field or point (default: stroke)", word(all.vibration.map)},
      {"alpha", "S/PX", "steepness of the force law, 0.0001 to 10 s/px (default: 0.01)",
       numbers(0.0001, 10.0, all.compare.law.alpha)},
      {"max-force", "N", "force of the fastest motion, 0.01 to 5 N (default: 1 N)",
       numbers(0.01, kHighestForce, all.compare.law.max_force)},
      {"at-most", "PERCENT",
       "exit status 1 above this share of the time, 0 to 100 % (default: never)",
       numbers(0.0, 100.0, all.compare.at_most)},
      {"offset", "S", "seconds that are added to the times of B (default: 0)",
       numbers(-1e6, 1e6, all.compare.offset)},
      {"shift", "S", "how late B is, -2 to 2 s (default: what fits best)",
       numbers(-2.0, 2.0, all.compare.shift)},
      {"plot", "FILE.png", "draws both forces", word(all.compare.plot)},
      {"json", nullptr, "prints JSON", flag(all.json)},
      {"stream", "NAME", "the track with this name (default: the first one; info names the others)",
       word(all.compare.stream)},
      {"force", nullptr, "overwrites a file that exists", flag(all.overwrites)},
  };
}

gboolean read_option(const gchar *name, const gchar *text, gpointer options, GError **error) {
  try {
    const std::string option = name; // with two dashes; empty: a file
    for (const Option &one : *static_cast<std::vector<Option> *>(options))
      if (option.empty() ? !*one.name : option.substr(2) == one.name)
        one.set(option, text ? text : "");
    return TRUE;
  } catch (const TrackFileError &failure) {
    g_set_error_literal(error, G_OPTION_ERROR, G_OPTION_ERROR_FAILED, failure.what());
    return FALSE;
  }
}

// Whether only files follow.
bool is_end(std::string_view word) {
  return word == "--";
}

// Returns the verb that begins the command line; one with a flag if that is given, too.
const Verb *verb_of(std::span<const Verb> verbs, std::span<char *> words) {
  const Verb *found = nullptr;
  for (const Verb &verb : verbs) {
    const std::string_view name = verb.name;
    const std::size_t end = std::min(name.find(' '), name.size());
    const auto is_flag = [&](std::string_view word) {
      return word.substr(0, word.find('=')) == name.substr(end + 1);
    };
    const auto files = std::ranges::find_if(words, is_end);
    if (words.size() > 0 && name.substr(0, end) == words[0] &&
        (end == name.size() || std::any_of(words.begin(), files, is_flag)))
      found = &verb;
  }
  return found;
}

// Reads the words behind the first one. Prints the help and ends the process if they ask for it.
void parse(const Verb &verb, std::span<char *> words, std::vector<Option> &options) {
  const auto files = std::ranges::find_if(words, is_end);
  std::vector<GOptionEntry> entries;
  for (const Option &option : options) {
    const std::string between = ' ' + std::string(option.name) + ' ';
    if (*option.name && between != " version " &&
        std::string_view(verb.options).find(between) == std::string_view::npos)
      continue;
    const bool is_flag = !option.value;
    for (auto text = words.begin(); text != files; ++text) // GLib would leave the value out
      if (is_flag && std::string_view(*text).starts_with("--" + std::string(option.name) + '='))
        throw_error(messages::kOptionIsWrong, verb.name,
                    format_text("--%s takes no value", option.name).c_str());
    entries.push_back({option.name, 0, is_flag ? G_OPTION_FLAG_NO_ARG : G_OPTION_FLAG_FILENAME,
                       G_OPTION_ARG_CALLBACK, reinterpret_cast<gpointer>(read_option), option.text,
                       *option.name ? option.value : verb.parameters});
  }
  entries.push_back({});
  GOptionGroup *group = g_option_group_new("", "", "", &options, nullptr);
  g_option_group_add_entries(group, entries.data());
  const std::unique_ptr<GOptionContext, decltype(&g_option_context_free)> context(
      g_option_context_new(nullptr), g_option_context_free);
  g_option_context_set_main_group(context.get(), group);
  // Without a verb, the first word is told that is none, whatever its options.
  g_option_context_set_strict_posix(context.get(), !verb.run);
  g_option_context_set_summary(context.get(), verb.summary);
  g_option_context_set_description(context.get(),
                                   ("Example: haptic-track " + std::string(verb.example)).c_str());
  g_set_prgname(("haptic-track " + std::string(verb.name)).c_str());
  for (auto text = words.begin(); text != files; ++text) // also in the place of a value
    if (std::string_view(*text) == "--help" || std::string_view(*text) == "-h") {
      const GCharPtr help(g_option_context_get_help(context.get(), TRUE, nullptr));
      // help2man knows a synopsis by its line.
      std::printf("Usage: %s", help.get() + std::string_view("Usage:\n  ").size());
      std::exit(EXIT_SUCCESS);
    }
  int count = static_cast<int>(words.size());
  char **rest = words.data();
  GError *wrong = nullptr;
  g_option_context_parse(context.get(), &count, &rest, &wrong);
  const ErrorPtr error(wrong);
  if (g_error_matches(wrong, G_OPTION_ERROR, G_OPTION_ERROR_FAILED))
    throw TrackFileError(error->message);
  if (error)
    throw_error(messages::kOptionIsWrong, verb.run ? verb.name : "before the verb", error->message);
}

} // namespace

int run_verb(std::span<const Verb> verbs, int argc, char **argv) {
  const std::span<char *> words(argv, static_cast<std::size_t>(argc));
  Arguments all;
  std::vector<Option> options = options_of(all);
  const Verb *verb = argc > 1 ? verb_of(verbs, words.subspan(1)) : nullptr;
  if (!verb) {
    std::string list =
        "Shows, converts, cuts, draws, compares and makes haptic tracks: files that say "
        "how a video moves.\n\nVerbs:\n";
    for (const auto &one : verbs)
      list += format_text("  %-16s  %.*s\n", one.name,
                          static_cast<int>(std::string_view(one.summary).find('\n')), one.summary);
    list +=
        "\nhaptic-track VERB --help explains a verb and its options. A file is a recording (.ts, "
        ".mkv, .mp4),\na track (.klv, .txt) or MPEG haptics (.hmpg, .hjif).";
    parse({.name = "VERB",
           .parameters = "FILE...",
           .options = "",
           .summary = list.c_str(),
           .example = "author in.mp4"},
          words, options);
    if (all.files.empty())
      throw_error(messages::kCommandIsMissing);
    throw_error(messages::kCommandIsUnknown, all.files[0].c_str());
  }
  parse(*verb, words.subspan(1), options);
  all.vibration.alpha = all.compare.law.alpha;
  if (all.files.size() < verb->least || all.files.size() > verb->most)
    throw_error(messages::kCommandNeedsFiles, verb->name, verb->needs);
  if (!verb->forks)
    gst_init(nullptr, nullptr);
  return verb->run(all);
}

} // namespace haptic
