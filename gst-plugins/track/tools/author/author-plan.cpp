// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-plan.hpp"

#include "samples/motion-field.hpp"
#include "track-error.hpp"
#include "tracks/source-mark.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <rapidjson/document.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

namespace haptic {
namespace {

namespace fs = std::filesystem;
using Json = rapidjson::Value;
using Writer = rapidjson::PrettyWriter<rapidjson::StringBuffer>;

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
  struct stat status = {};
  if (stat(path.c_str(), &status) != 0)
    throw_error(messages::kFileIsMissing, path.c_str());
  if (!S_ISREG(status.st_mode))
    throw_error(messages::kFileIsNone, path.c_str());
  if (access(path.c_str(), R_OK) != 0)
    throw_error(messages::kFileIsForbidden, path.c_str());
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

void write_text(Writer &json, const char *key, const std::string &text) {
  json.Key(key);
  json.String(text.c_str(), static_cast<rapidjson::SizeType>(text.size()));
}

void write_number(Writer &json, const char *key, std::uint64_t number) {
  json.Key(key);
  json.Uint64(number);
}

void write_film(Writer &json, const PlannedFilm &film) {
  json.StartObject();
  write_text(json, "video", film.path);
  write_number(json, "size", film.size);
  json.Key("modified");
  json.Int64(film.modified);
  write_text(json, "sha256", film.hash);
  write_text(json, "ending", film.index.ending);
  write_text(json, "rotation", film.index.rotation);
  write_number(json, "duration", film.index.duration);
  write_number(json, "lead", film.index.lead);
  json.Key("warnings");
  json.StartArray();
  for (const std::string &warning : film.index.warnings)
    json.String(warning.c_str());
  json.EndArray();
  json.Key("spans");
  json.StartArray();
  for (const Span &span : film.index.spans) {
    json.StartObject();
    write_number(json, "begin", span.begin);
    write_number(json, "decode-from", span.decode_from);
    json.EndObject();
  }
  json.EndArray();
  json.EndObject();
}

void write_chunk(Writer &json, const PlannedChunk &chunk) {
  json.StartObject();
  write_number(json, "input", chunk.film);
  write_number(json, "first-span", chunk.spans.begin);
  write_number(json, "end-span", chunk.spans.end);
  json.EndObject();
}

// Members of a JSON object. What is missing or of another kind throws.
class Members {
public:
  Members(const Json &json, const std::string &path) : json_(json), path_(path) {
    require(json.IsObject());
  }

  std::string text(const char *key) const {
    const Json &value = member(key);
    require(value.IsString());
    return value.GetString();
  }
  std::uint64_t number(const char *key) const {
    const Json &value = member(key);
    require(value.IsUint64());
    return value.GetUint64();
  }
  std::int64_t signed_number(const char *key) const {
    const Json &value = member(key);
    require(value.IsInt64());
    return value.GetInt64();
  }
  const Json &list(const char *key) const {
    const Json &value = member(key);
    require(value.IsArray());
    return value;
  }
  bool has(const char *key) const { return json_.HasMember(key); }
  void require(bool is_right) const {
    if (!is_right)
      throw_error(messages::kPlanIsWrong, path_.c_str());
  }

private:
  const Json &member(const char *key) const {
    const auto found = json_.FindMember(key);
    require(found != json_.MemberEnd());
    return found->value;
  }

  const Json &json_;
  const std::string &path_;
};

void read_hold(const Members &members, HoldOptions &hold) {
  hold.chooses = members.has("hold") && members.text("hold") == "auto";
  std::istringstream words(members.has("hold-points") ? members.text("hold-points") : "");
  for (std::string word; words >> word;) {
    const auto point = read_hold_point(word);
    members.require(point.has_value());
    hold.points.push_back(*point);
  }
  members.require(hold.points.size() <= kMostFieldThings);
}

PlannedFilm read_film(const Json &json, const std::string &path) {
  const Members members(json, path);
  PlannedFilm film;
  film.path = members.text("video");
  film.size = members.number("size");
  film.modified = members.signed_number("modified");
  film.hash = members.text("sha256");
  film.index.ending = members.text("ending");
  film.index.rotation = members.text("rotation");
  film.index.duration = members.number("duration");
  film.index.lead = members.number("lead");
  for (const Json &warning : members.list("warnings").GetArray()) {
    members.require(warning.IsString());
    film.index.warnings.emplace_back(warning.GetString());
  }
  for (const Json &span : members.list("spans").GetArray()) {
    const Members times(span, path);
    film.index.spans.push_back({times.number("begin"), times.number("decode-from")});
  }
  members.require(!film.index.spans.empty() &&
                  (film.index.ending == kTransportStream || film.index.ending == kMatroska));
  return film;
}

PlannedChunk read_chunk(const Json &json, const Plan &plan, const std::string &path) {
  const Members members(json, path);
  const PlannedChunk chunk = {members.number("input"),
                              {members.number("first-span"), members.number("end-span")}};
  members.require(chunk.film < plan.films.size() && chunk.spans.begin < chunk.spans.end &&
                  chunk.spans.end <= plan.films[chunk.film].index.spans.size());
  return chunk;
}

// Throws unless the chunks cover each film once, in order.
void check_cover(const Plan &plan, const std::string &path) {
  std::size_t film = 0;
  std::size_t span = 0;
  bool is_right = true;
  for (const PlannedChunk &chunk : plan.chunks) {
    is_right = is_right && chunk.film == film && chunk.spans.begin == span;
    span = chunk.spans.end;
    if (is_right && span == plan.films[film].index.spans.size()) {
      ++film;
      span = 0;
    }
  }
  if (!is_right || film != plan.films.size())
    throw_error(messages::kPlanIsWrong, path.c_str());
}

} // namespace

std::string write_plan(const Plan &plan) {
  rapidjson::StringBuffer text;
  Writer json(text);
  json.SetIndent(' ', 1);
  json.StartObject();
  write_text(json, "version", VERSION);
  write_text(json, "output", plan.options.folder);
  write_number(json, "columns", plan.options.columns);
  if (plan.options.hold.chooses)
    write_text(json, "hold", "auto");
  if (!plan.options.hold.points.empty())
    write_text(json, "hold-points", write_hold_points(plan.options.hold.points));
  json.Key("inputs");
  json.StartArray();
  for (const PlannedFilm &film : plan.films)
    write_film(json, film);
  json.EndArray();
  json.Key("chunks");
  json.StartArray();
  for (const PlannedChunk &chunk : plan.chunks)
    write_chunk(json, chunk);
  json.EndArray();
  json.EndObject();
  return std::string(text.GetString(), text.GetSize()) + "\n";
}

Plan read_plan(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw_error(messages::kFileIsMissing, path.c_str());
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  rapidjson::Document document;
  document.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
  if (document.HasParseError())
    throw_error(messages::kPlanIsWrong, path.c_str());
  const Members members(document, path);
  if (const std::string version = members.text("version"); version != VERSION)
    throw_error(messages::kPlanIsOfOtherVersion, path.c_str(), version.c_str(), VERSION);
  Plan plan;
  plan.options.folder = members.text("output");
  const std::uint64_t columns = members.number("columns");
  members.require(columns == 0 || (columns >= kFewestColumns && columns <= kMostColumns));
  plan.options.columns = static_cast<unsigned>(columns);
  read_hold(members, plan.options.hold);
  for (const Json &film : members.list("inputs").GetArray())
    plan.films.push_back(read_film(film, path));
  for (const Json &chunk : members.list("chunks").GetArray())
    plan.chunks.push_back(read_chunk(chunk, plan, path));
  check_cover(plan, path);
  return plan;
}

} // namespace haptic
