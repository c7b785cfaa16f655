// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author.hpp"

#include "author/author-file.hpp"
#include "json.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "track-error.hpp"
#include "tracks/source-mark.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <map>
#include <sstream>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace haptic {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kExists = 3; // exit status of a process

int status_of_failure() {
  return is_interrupted() ? kInterrupted : EXIT_FAILURE;
}

void print_warnings(const PlannedFilm &film) {
  for (const std::string &warning : film.index.warnings)
    std::fprintf(stderr, "\"%s\": %s\n", film.path.c_str(), warning.c_str());
}

// Calls `work`. Returns whether it did not throw. Its error is printed with the name of the video.
template <typename Work>
bool succeeds(const std::string &path, Work &&work) {
  try {
    work();
    return true;
  } catch (const std::exception &error) {
    print_error(about(path, error.what()));
    return false;
  }
}

double seconds_since(Clock::time_point time) {
  return std::max(1e-3, std::chrono::duration<double>(Clock::now() - time).count());
}

// ---- one film -----------------------------------------------------------------------------------

// Measures the spans, unless they were.
void measure(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options) {
  const std::string path = chunk_path(film, spans, options);
  const std::string mark = chunk_mark(film, spans, options);
  if (!ChunkReader(path, mark).problem())
    return;
  ChunkWriter out(path, mark);
  out.finish(measure_spans(film.path, options.columns, options.hold, film.index, spans, out));
}

int author_one(const std::string &path, const AuthorOptions &options) {
  const auto begun = Clock::now();
  AuthoredFilm film;
  if (!succeeds(path, [&] { film = author_film(path, options); }))
    return status_of_failure();
  if (film.frames == 0) {
    std::printf("there already: %s\n", film.copy.c_str());
    return kExists;
  }
  std::printf("written: %s (%llu frames, %.0f a second)\n", film.copy.c_str(),
              static_cast<unsigned long long>(film.frames),
              static_cast<double>(film.frames) / seconds_since(begun));
  return EXIT_SUCCESS;
}

// Two videos of one name would replace each other's copies. That is found before the work of hours
// begins. A video that is named twice counts once. Returns false after an error.
bool copies_differ(std::vector<std::string> &files, const AuthorOptions &options) {
  std::error_code error;
  if (!options.folder.empty() && !fs::is_directory(options.folder) &&
      !fs::create_directories(options.folder, error))
    throw_error(messages::kOutputFails, options.folder.c_str(), error.message().c_str());
  std::map<std::string, std::string> videos; // of the copies
  bool differ = true;
  std::erase_if(files, [&](const std::string &path) {
    const auto copy = fs::weakly_canonical(author_stem(path, options), error);
    const auto [other, is_new] = videos.emplace(copy.string(), path);
    const bool is_same = path == other->second || fs::equivalent(path, other->second, error);
    if (!is_new && !is_same) {
      print_error(format_text(messages::kCopyNamesCollide, path.c_str(), other->second.c_str()));
      differ = false;
    }
    return !is_new && is_same;
  });
  return differ;
}

// ---- several at a time --------------------------------------------------------------------------

// Starts a process for a video: one that crashes or runs out of memory ends no other.
pid_t start(const std::string &path, const AuthorOptions &options) {
  std::fflush(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0)
    throw_error(messages::kProcessFails, std::strerror(errno));
  if (pid > 0)
    return pid;
  prctl(PR_SET_PDEATHSIG, SIGTERM); // nobody works on for a dead one
  const int status = getppid() == parent ? author_one(path, options) : EXIT_FAILURE;
  std::fflush(nullptr);
  _exit(status);
}

// Returns how often each exit status came. After a signal, other videos are not begun.
std::map<int, std::size_t> author_each(const std::vector<std::string> &files,
                                       const AuthorOptions &options, unsigned jobs) {
  std::map<pid_t, std::string> running;
  std::map<int, std::size_t> counts;
  for (auto next = files.begin();;) {
    if (!is_interrupted() && next != files.end() && running.size() < jobs) {
      running[start(*next, options)] = *next;
      ++next;
      continue;
    }
    if (running.empty())
      return counts;
    int status = 0;
    const pid_t pid = waitpid(-1, &status, 0);
    if (pid < 0) { // a signal came: SIGCHLD is not ignored (author())
      for (const auto &[process, path] : running)
        kill(process, SIGTERM);
      continue;
    }
    if (!WIFEXITED(status))
      print_error(format_text(messages::kProcessCrashed, running[pid].c_str(),
                              strsignal(WTERMSIG(status))));
    ++counts[WIFEXITED(status) ? WEXITSTATUS(status) : EXIT_FAILURE];
    running.erase(pid);
  }
}

// JSON holds no other names.
void check_name(const std::string &path) {
  if (!g_utf8_validate(path.c_str(), -1, nullptr))
    throw_error(messages::kNameIsNotUtf8, path.c_str());
}

// ---- merging ------------------------------------------------------------------------------------

std::string manifest_stem(const std::string &plan_path, const Plan &plan) {
  const fs::path path(plan_path);
  const fs::path folder =
      plan.options.folder.empty() ? path.parent_path() : fs::path(plan.options.folder);
  return (folder / path.stem()).string() + ".manifest";
}

// Opens the chunks of a film. Throws if one is not whole.
std::vector<ChunkReader> open_chunks(const Plan &plan, std::size_t film) {
  std::vector<ChunkReader> chunks;
  for (std::size_t k = 0; k < plan.chunks.size(); ++k) {
    if (plan.chunks[k].film != film)
      continue;
    const SpanRange spans = plan.chunks[k].spans;
    const std::string path = chunk_path(plan.films[film], spans, plan.options);
    chunks.emplace_back(path, chunk_mark(plan.films[film], spans, plan.options));
    if (const char *problem = chunks.back().problem())
      throw_error("%s", format_text(problem, path.c_str(), k).c_str());
  }
  return chunks;
}

constexpr const char *kColumns[] = {"video",   "video-sha256", "copy",   "copy-sha256", "bytes",
                                    "seconds", "frames",       "kbit/s", "confidence",  "warnings"};

// Returns the rows of the manifest, or no array if there is none that can be read.
Json read_manifest(const std::string &stem) {
  std::ifstream file(stem + ".json", std::ios::binary);
  return Json::parse(file, nullptr, false);
}

// Writes the rows as JSON and as a table (CSV, RFC 4180).
void write_manifest(const std::string &stem, const Json &rows) {
  std::ostringstream table;
  const char *comma = "";
  for (const char *key : kColumns)
    table << std::exchange(comma, ",") << key;
  table << "\r\n";
  for (const Json &row : rows) {
    comma = "";
    for (const std::string key : kColumns) {
      const Json &cell = row[key];
      table << std::exchange(comma, ",");
      std::string text;
      for (const Json &part : cell) // a text is its only part
        if (part.is_string())
          text += (text.empty() ? "" : "; ") + part.get<std::string>();
      if (cell.is_number_float())
        table << format_text("%.*f", key == "kbit/s" ? 1 : 3, cell.get<double>());
      else if (cell.is_number())
        table << cell;
      else
        table << std::quoted(text, '"', '"');
    }
    table << "\r\n";
  }
  write_bytes(stem + ".json", rows.dump(1) + "\n");
  write_bytes(stem + ".csv", table.str());
}

Json row_of(const PlannedFilm &film, const std::string &copy,
            const std::vector<ChunkReader> &chunks) {
  std::uint64_t frames = 0;
  std::uint64_t confidence = 0; // millionths
  double bytes = 0;             // of the track as KLV
  for (const ChunkReader &chunk : chunks) {
    frames += chunk.stats().frames;
    confidence += chunk.stats().confidence;
    bytes += static_cast<double>(chunk.fields().size());
  }
  const double length = rounded(seconds(film.index.duration), 1e3); // s
  const double mean = 1e-6 * static_cast<double>(confidence) /
                      static_cast<double>(std::max<std::uint64_t>(frames, 1));
  return {{"video", film.path},
          {"video-sha256", film.hash},
          {"copy", copy},
          {"copy-sha256", hash_of_file(copy)},
          {"bytes", fs::file_size(copy)},
          {"seconds", length},
          {"frames", frames},
          {"kbit/s", length > 0 ? rounded(8e-3 * bytes / length, 1e3) : 0.0},
          {"confidence", rounded(mean, 1e3)},
          {"warnings", film.index.warnings}};
}

// Somebody may have changed it.
bool is_whole(const Json &row) {
  return std::ranges::all_of(kColumns, [&](const char *key) { return row.contains(key); });
}

// Returns the row of a copy that the manifest knows and that is unchanged, or null.
Json merged_row(const Json &manifest, const std::string &copy) {
  for (const Json &row : manifest)
    if (!copy.empty() && is_whole(row) && row["copy"] == Json(copy) &&
        row["copy-sha256"] == Json(hash_of_file(copy)))
      return row;
  return nullptr;
}

// Merges one film, unless it was.
Json merge_film(const Plan &plan, std::size_t i, const Json &before) {
  const PlannedFilm &film = plan.films[i];
  check_unchanged(film, true);
  std::string copy = find_copy(film, plan.options);
  if (Json row = merged_row(before, copy); !row.is_null())
    return row;
  const std::vector<ChunkReader> chunks = open_chunks(plan, i);
  const char *word = copy.empty() ? "written" : "there already";
  if (copy.empty())
    copy = write_copy(film, plan.options, chunks);
  std::printf("%s: %s\n", word, copy.c_str());
  return row_of(film, copy, chunks);
}

} // namespace

AuthoredFilm author_film(const std::string &path, const AuthorOptions &options) {
  if (fs::path(path).stem().extension() == ".haptic" && fs::exists(path) && mark_in(path))
    return {path};
  PlannedFilm film = identify(path);
  if (std::string copy = find_copy(film, options); !copy.empty())
    return {std::move(copy)};
  film.index = index_film(film.path);
  find_copy(film, options); // throws where another file has its name
  print_warnings(film);
  const SpanRange all = {0, film.index.spans.size()};
  measure(film, all, options);
  const std::string path_of_chunk = chunk_path(film, all, options);
  std::vector<ChunkReader> chunks;
  chunks.emplace_back(path_of_chunk, chunk_mark(film, all, options));
  std::error_code error;
  fs::remove(path_of_chunk, error); // its content stays while it is mapped
  return {write_copy(film, options, chunks), chunks[0].stats().frames};
}

int author(std::vector<std::string> files, const AuthorOptions &options, unsigned jobs) {
  if (!copies_differ(files, options))
    return EXIT_FAILURE;
  stop_when_interrupted();
  std::signal(SIGCHLD, SIG_DFL); // a parent may have left it ignored; then nobody can be waited for
  const auto begun = Clock::now();
  auto counts = author_each(files, options, jobs);
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const std::size_t failed = counts[EXIT_FAILURE];
  const std::size_t done = counts[EXIT_SUCCESS] + counts[kExists] + failed;
  std::printf("%zu written, %zu there already, %zu failed", counts[EXIT_SUCCESS], counts[kExists],
              failed);
  if (is_interrupted())
    std::printf(", %zu not done: run it again to go on", files.size() - done);
  std::printf("; %.0f s, at most %ld MB a process\n", seconds_since(begun), usage.ru_maxrss / 1024);
  if (is_interrupted())
    return kInterrupted;
  return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

int plan_authoring(std::vector<std::string> files, const AuthorOptions &options, unsigned chunks) {
  Plan plan{.options = options};
  if (!copies_differ(files, options))
    return EXIT_FAILURE;
  stop_when_interrupted();
  if (!options.folder.empty())
    plan.options.folder = fs::absolute(options.folder).lexically_normal().string();
  check_name(plan.options.folder);
  double minutes = 0;
  for (const std::string &path : files)
    succeeds(path, [&] {
      PlannedFilm film = identify(path);
      check_name(film.path);
      film.index = index_film(film.path);
      find_copy(film, plan.options); // throws where another file has its name
      print_warnings(film);
      minutes += static_cast<double>(film.index.duration) / 60e9;
      plan.films.push_back(std::move(film));
    });
  if (is_interrupted())
    return kInterrupted;
  const auto usual = static_cast<unsigned>(std::clamp(minutes, 1.0, 1.0 * kMostChunks));
  plan.chunks = divide_films(plan.films, chunks > 0 ? chunks : usual);
  std::fputs(write_plan(plan).c_str(), stdout);
  return std::fflush(stdout) == 0 && plan.films.size() == files.size() ? EXIT_SUCCESS
                                                                       : EXIT_FAILURE;
}

int author_chunk(const std::string &path, unsigned chunk) {
  stop_when_interrupted();
  const Plan plan = read_plan(path);
  if (chunk >= plan.chunks.size())
    throw_error(messages::kChunkIsUnknown, path.c_str(), chunk, plan.chunks.size());
  const PlannedChunk &planned = plan.chunks[chunk];
  const PlannedFilm &film = plan.films[planned.film];
  const bool is_done = succeeds(film.path, [&] {
    check_unchanged(film, false);
    const std::string copy = find_copy(film, plan.options);
    if (!merged_row(read_manifest(manifest_stem(path, plan)), copy).is_null())
      std::printf("there already: %s\n", copy.c_str());
    else
      measure(film, planned.spans, plan.options);
  });
  return is_done ? EXIT_SUCCESS : status_of_failure();
}

int merge_chunks(const std::string &path) {
  stop_when_interrupted();
  const Plan plan = read_plan(path);
  const std::string stem = manifest_stem(path, plan);
  const Json before = read_manifest(stem);
  Json rows = Json::array();
  std::vector<std::size_t> merged;
  bool is_complete = true;
  for (std::size_t i = 0; i < plan.films.size() && !is_interrupted(); ++i) {
    const std::string &video = plan.films[i].path;
    if (succeeds(video, [&] { rows.push_back(merge_film(plan, i, before)); })) {
      merged.push_back(i);
      continue;
    }
    is_complete = false;
    // It may be elsewhere for a while; what was made of it is known.
    std::ranges::copy_if(before, std::back_inserter(rows), [&](const Json &row) {
      return is_whole(row) && row["video"] == Json(video);
    });
  }
  if (is_interrupted())
    return kInterrupted;
  write_manifest(stem, rows);
  std::error_code error;
  for (const PlannedChunk &chunk : plan.chunks)
    if (std::ranges::find(merged, chunk.film) != merged.end())
      fs::remove(chunk_path(plan.films[chunk.film], chunk.spans, plan.options), error);
  std::printf("manifest: %s.json, .csv\n", stem.c_str());
  return is_complete ? EXIT_SUCCESS : EXIT_FAILURE;
}

} // namespace haptic
