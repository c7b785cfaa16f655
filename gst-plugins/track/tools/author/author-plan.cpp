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
#include <sys/stat.h>

namespace haptic {
namespace {

namespace fs = std::filesystem;

// What a field depends on beside the film and the columns.
constexpr char kRules[] = "spans 2 columns ";
constexpr char kHoldRules[] = " hold 1 ";
constexpr std::size_t kMadeOf = 12; // digits of a mark

// The fields of a film depend on the film and on this.
std::string settings_of(const AuthorOptions &options) {
  return kRules + std::to_string(options.columns) + settings_of(options.hold);
}

// Without its hash.
PlannedFilm state_of(const std::string &path) {
  check_readable(path);
  struct stat status = {};
  stat(path.c_str(), &status);
  return {fs::absolute(path).lexically_normal(), static_cast<std::uint64_t>(status.st_size),
          status.st_mtim.tv_sec * std::int64_t{1'000'000'000} + status.st_mtim.tv_nsec};
}

// ---- JSON ---------------------------------------------------------------------------------------

HoldOptions hold_of(const Json &json) {
  HoldOptions hold;
  hold.chooses = json.value("hold", "") == "auto";
  std::istringstream words(json.value("hold-points", ""));
  for (std::string word; words >> word;)
    hold.points.push_back(read_hold_point(word).value());
  return hold;
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
  const auto &[folder, columns, hold] = plan.options;
  return hold.points.size() <= kMostFieldThings && columns <= kMostColumns &&
         (columns == 0 || columns >= kFewestColumns) && film == plan.films.size() &&
         std::ranges::all_of(plan.films, [](const PlannedFilm &one) {
           return one.index.ending == kTransportStream || one.index.ending == kMatroska;
         });
}

} // namespace

std::string settings_of(const HoldOptions &hold) {
  if (hold == HoldOptions{})
    return {};
  return kHoldRules + std::string(hold.chooses ? "auto " : "") + write_hold_points(hold.points);
}

PlannedFilm identify(const std::string &path) {
  PlannedFilm film = state_of(path);
  film.hash = hash_of_file(path);
  return film;
}

void check_unchanged(const PlannedFilm &film, bool wholly) {
  const PlannedFilm now = state_of(film.path);
  const bool is_as_old = now.modified == film.modified && !wholly;
  if (now.size != film.size || (!is_as_old && hash_of_file(film.path) != film.hash))
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
  std::error_code error;
  const std::string place = fs::weakly_canonical(film.path, error).replace_extension();
  return std::string(made_of(mark_of(film.hash, settings_of(options)))) +
         std::string(place_of(mark_of(place, "")));
}

std::string_view made_of(std::string_view mark) {
  return mark.substr(0, kMadeOf);
}

std::string_view place_of(std::string_view mark) {
  return mark.size() > kMadeOf ? mark.substr(kMadeOf) : mark;
}

std::string chunk_path(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options) {
  return author_stem(film.path, options) + ".chunk-" + std::to_string(spans.begin) + "-" +
         std::to_string(spans.end);
}

std::string chunk_mark(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options) {
  const auto &all = film.index.spans;
  std::string settings = "version " VERSION " " + settings_of(options);
  for (std::size_t i = spans.begin; i <= spans.end; ++i)
    settings += i < all.size() ? " " + std::to_string(all[i].begin) : " end";
  return mark_of(film.hash, settings);
}

std::string write_plan(const Plan &plan) {
  Json json = {{"version", VERSION}};
  json.update(Json(plan.options));
  if (plan.options.hold.chooses)
    json["hold"] = "auto";
  if (!plan.options.hold.points.empty())
    json["hold-points"] = write_hold_points(plan.options.hold.points);
  json["inputs"] = plan.films;
  json["chunks"] = plan.chunks;
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
    Plan plan{json, json.at("inputs"), json.at("chunks")};
    plan.options.hold = hold_of(json);
    if (is_right(plan))
      return plan;
  } catch (const TrackFileError &) {
    throw;
  } catch (const std::exception &) { // what is no plan is refused as a wrong one is
  }
  throw_error(messages::kPlanIsWrong, path.c_str());
}

} // namespace haptic
