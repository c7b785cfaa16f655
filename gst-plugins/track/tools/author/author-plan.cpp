// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-plan.hpp"

#include "json.hpp"
#include "samples/motion-field.hpp"
#include "track-error.hpp"
#include "tracks/source-mark.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <sys/stat.h>

namespace haptic {
namespace {

namespace fs = std::filesystem;

// What a field depends on beside the film and the columns.
constexpr char kRules[] = "spans 2 columns ";
constexpr char kHoldRules[] = " hold 1 ";

// The fields of a film depend on the film and on this.
std::string settings_of(const AuthorOptions &options) {
  return kRules + std::to_string(options.columns) + settings_of(options.hold);
}

struct FileState {
  std::uint64_t size = 0;
  std::int64_t modified = 0;
};

FileState state_of(const std::string &path) {
  check_readable(path);
  struct stat status = {};
  stat(path.c_str(), &status);
  return {static_cast<std::uint64_t>(status.st_size),
          status.st_mtim.tv_sec * std::int64_t{1'000'000'000} + status.st_mtim.tv_nsec};
}

} // namespace

std::string settings_of(const HoldOptions &hold) {
  if (hold == HoldOptions{})
    return {};
  return kHoldRules + std::string(hold.chooses ? "auto " : "") + write_hold_points(hold.points);
}

PlannedFilm identify(const std::string &path) {
  const FileState state = state_of(path);
  return {fs::absolute(path).lexically_normal().string(),
          state.size,
          state.modified,
          hash_of_file(path),
          {}};
}

void check_unchanged(const PlannedFilm &film, bool wholly) {
  const FileState now = state_of(film.path);
  const bool is_same =
      now.size == film.size &&
      (now.modified == film.modified && !wholly ? true : hash_of_file(film.path) == film.hash);
  if (!is_same)
    throw_error(messages::kFilmHasChanged, film.path.c_str());
}

std::vector<PlannedChunk> divide_films(const std::vector<PlannedFilm> &films, std::size_t count) {
  std::size_t all = 0;
  for (const PlannedFilm &film : films)
    all += film.index.spans.size();
  std::vector<PlannedChunk> chunks;
  for (std::size_t i = 0; i < films.size(); ++i) {
    const std::size_t spans = films[i].index.spans.size();
    const std::size_t own = std::clamp((count * spans + all / 2) / all, std::size_t{1}, spans);
    for (std::size_t k = 0; k < own; ++k)
      chunks.push_back({i, {k * spans / own, (k + 1) * spans / own}});
  }
  return chunks;
}

std::string author_stem(const std::string &path, const AuthorOptions &options) {
  const fs::path video(path);
  const fs::path folder = options.folder.empty() ? video.parent_path() : fs::path(options.folder);
  return (folder / video.stem()).string() + ".haptic";
}

std::string copy_mark(const PlannedFilm &film, const AuthorOptions &options) {
  return mark_of(film.hash, settings_of(options));
}

std::string chunk_path(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options) {
  return author_stem(film.path, options) + ".chunk-" + std::to_string(spans.begin) + "-" +
         std::to_string(spans.end);
}

std::string chunk_mark(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options) {
  const auto &all = film.index.spans;
  std::string settings = "version " VERSION " ";
  settings += settings_of(options);
  for (std::size_t i = spans.begin; i <= spans.end; ++i)
    settings += i < all.size() ? " " + std::to_string(all[i].begin) : " end";
  return mark_of(film.hash, settings);
}

// ---- JSON ---------------------------------------------------------------------------------------

namespace {

Json json_of(const PlannedFilm &film) {
  Json spans = Json::array();
  for (const Span &span : film.index.spans)
    spans.push_back({{"begin", span.begin}, {"decode-from", span.decode_from}});
  return {{"video", film.path},
          {"size", film.size},
          {"modified", film.modified},
          {"sha256", film.hash},
          {"ending", film.index.ending},
          {"rotation", film.index.rotation},
          {"duration", film.index.duration},
          {"lead", film.index.lead},
          {"warnings", film.index.warnings},
          {"spans", spans}};
}

Json json_of(const PlannedChunk &chunk) {
  return {{"input", chunk.film}, {"first-span", chunk.spans.begin}, {"end-span", chunk.spans.end}};
}

// Members of a JSON object. What is missing or of another kind throws an exception of the library.
std::uint64_t number_of(const Json &json, const char *key) {
  return json.at(key).get_ref<const Json::number_unsigned_t &>();
}
const Json::array_t &list_of(const Json &json, const char *key) {
  return json.at(key).get_ref<const Json::array_t &>();
}

HoldOptions hold_of(const Json &json) {
  HoldOptions hold;
  hold.chooses = json.value("hold", "") == "auto";
  std::istringstream words(json.value("hold-points", ""));
  for (std::string word; words >> word;)
    hold.points.push_back(read_hold_point(word).value());
  return hold;
}

PlannedFilm film_of(const Json &json) {
  PlannedFilm film;
  film.path = json.at("video");
  film.size = number_of(json, "size");
  film.modified = json.at("modified").get_ref<const Json::number_integer_t &>();
  film.hash = json.at("sha256");
  film.index.ending = json.at("ending");
  film.index.rotation = json.at("rotation");
  film.index.duration = number_of(json, "duration");
  film.index.lead = number_of(json, "lead");
  film.index.warnings = json.at("warnings");
  for (const Json &span : list_of(json, "spans"))
    film.index.spans.push_back({number_of(span, "begin"), number_of(span, "decode-from")});
  return film;
}

Plan plan_of(const Json &json) {
  Plan plan;
  plan.options.folder = json.at("output");
  plan.options.columns =
      static_cast<unsigned>(std::min<std::uint64_t>(number_of(json, "columns"), kMostColumns + 1));
  plan.options.hold = hold_of(json);
  for (const Json &film : list_of(json, "inputs"))
    plan.films.push_back(film_of(film));
  for (const Json &chunk : list_of(json, "chunks"))
    plan.chunks.push_back({number_of(chunk, "input"),
                           {number_of(chunk, "first-span"), number_of(chunk, "end-span")}});
  return plan;
}

bool is_right(const AuthorOptions &options) {
  return options.hold.points.size() <= kMostFieldThings && options.columns <= kMostColumns &&
         (options.columns == 0 || options.columns >= kFewestColumns);
}

// Whether it can be copied, and the chunks cover each film once, in order.
bool is_right(const Plan &plan) {
  std::size_t film = 0;
  std::size_t span = 0;
  for (const auto &[of, spans] : plan.chunks) {
    if (of != film || film == plan.films.size() || spans.begin != span || spans.end <= span ||
        spans.end > plan.films[film].index.spans.size())
      return false;
    span = spans.end;
    if (span == plan.films[film].index.spans.size()) {
      ++film;
      span = 0;
    }
  }
  return is_right(plan.options) && film == plan.films.size() &&
         std::ranges::all_of(plan.films, [](const PlannedFilm &one) {
           return one.index.ending == kTransportStream || one.index.ending == kMatroska;
         });
}

} // namespace

std::string write_plan(const Plan &plan) {
  Json json = {
      {"version", VERSION}, {"output", plan.options.folder}, {"columns", plan.options.columns}};
  if (plan.options.hold.chooses)
    json["hold"] = "auto";
  if (!plan.options.hold.points.empty())
    json["hold-points"] = write_hold_points(plan.options.hold.points);
  for (Json &films = json["inputs"] = Json::array(); const PlannedFilm &film : plan.films)
    films.push_back(json_of(film));
  for (Json &chunks = json["chunks"] = Json::array(); const PlannedChunk &chunk : plan.chunks)
    chunks.push_back(json_of(chunk));
  return json.dump(1) + "\n"; // a key a line, as schedulers count them
}

Plan read_plan(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw_error(messages::kFileIsMissing, path.c_str());
  try {
    const Json json = Json::parse(file);
    if (const std::string version = json.at("version"); version != VERSION)
      throw_error(messages::kPlanIsOfOtherVersion, path.c_str(), version.c_str(), VERSION);
    Plan plan = plan_of(json);
    if (is_right(plan))
      return plan;
  } catch (const TrackFileError &) {
    throw;
  } catch (const std::exception &) { // what is no plan is refused as a wrong one is
  }
  throw_error(messages::kPlanIsWrong, path.c_str());
}

} // namespace haptic
