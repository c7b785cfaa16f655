// SPDX-License-Identifier: LGPL-2.1-or-later
// The plan of an authoring: which films, and the chunks that processes measure in any order.
#pragma once

#include "author/film-index.hpp"
#include "author/span-measure.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

/// Of a motion field (field-columns of motionfield).
inline constexpr unsigned kFewestColumns = 4;
inline constexpr unsigned kMostColumns = 96;

struct AuthorOptions {
  std::string folder;   ///< of the copies; empty: that of each video
  unsigned columns = 0; ///< of the motion field; 0: as motionfield has it
  HoldOptions hold;

  /// In a plan, where the things stand beside these.
  template <typename Self, typename Call>
  static void members(Self &self, const Call &call) {
    call("output", self.folder);
    call("columns", self.columns);
  }
};

/// Returns the part of marks that says which things are followed: nothing, if none.
std::string settings_of(const HoldOptions &hold);

struct PlannedFilm {
  std::string path;
  std::uint64_t size = 0;    ///< bytes
  std::int64_t modified = 0; ///< ns since 1970
  std::string hash = {};     ///< SHA-256
  FilmIndex index = {};

  template <typename Self, typename Call>
  static void members(Self &self, const Call &call) {
    call("video", self.path);
    call("size", self.size);
    call("modified", self.modified);
    call("sha256", self.hash);
    call("ending", self.index.ending);
    call("rotation", self.index.rotation);
    call("duration", self.index.duration);
    call("lead", self.index.lead);
    call("warnings", self.index.warnings);
    call("spans", self.index.spans);
  }
};

struct PlannedChunk {
  std::size_t film = 0; ///< index
  SpanRange spans;

  template <typename Self, typename Call>
  static void members(Self &self, const Call &call) {
    call("input", self.film);
    call("first-span", self.spans.begin);
    call("end-span", self.spans.end);
  }
};

struct Plan {
  AuthorOptions options;
  std::vector<PlannedFilm> films;
  std::vector<PlannedChunk> chunks; ///< those of a film stand together, in order
};

/// Returns the film without an index. Throws TrackFileError if it cannot be read.
PlannedFilm identify(const std::string &path);

/// Throws TrackFileError if the film is no longer the same. A film with another time has to have
/// the same content, and so has each one if `wholly`.
void check_unchanged(const PlannedFilm &film, bool wholly);

/// Divides the spans of the films into about `count` chunks, as long as each other; at least one a
/// film, and of a single film not more than it has spans.
std::vector<PlannedChunk> divide_films(const std::vector<PlannedFilm> &films, std::size_t count);

/// Returns the name of the copy without its ending. Two videos may not have the same one.
std::string author_stem(const std::string &path, const AuthorOptions &options);

/// Returns the mark of the copy. Its digits say from which content and with which settings the copy
/// was made, and the last ones where the video lies, without its ending.
std::string copy_mark(const PlannedFilm &film, const AuthorOptions &options);
std::string_view made_of(std::string_view mark);
std::string_view place_of(std::string_view mark);

/// Returns the file with the fields of a chunk, and its mark.
std::string chunk_path(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options);
std::string chunk_mark(const PlannedFilm &film, SpanRange spans, const AuthorOptions &options);

/// Returns the plan as JSON.
std::string write_plan(const Plan &plan);

/// Throws TrackFileError if it is none, or one of another version of this program.
Plan read_plan(const std::string &path);

} // namespace haptic
