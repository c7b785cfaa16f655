// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-plan.hpp"

#include "temporary-folder.hpp"
#include "track-error.hpp"

#include <chrono>
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>

namespace author_plan_test {

namespace fs = std::filesystem;
using haptic::Plan;
using haptic::PlannedChunk;
using haptic::PlannedFilm;
using haptic::TrackFileError;
using test::TemporaryFolder;

std::string error_of(const std::function<void()> &call) {
  try {
    call();
  } catch (const TrackFileError &error) {
    return error.what();
  }
  return "";
}

PlannedFilm film_of(std::size_t spans, const std::string &path) {
  PlannedFilm film = {path, 4711, 1'700'000'000'123'456'789, std::string(64, 'a'), {}};
  for (std::size_t i = 0; i < spans; ++i)
    film.index.spans.push_back(
        {i * haptic::kSpanLength, i * haptic::kSpanLength - (i > 0 ? 1 : 0)});
  film.index.ending = haptic::kTransportStream;
  film.index.duration = spans * haptic::kSpanLength;
  return film;
}

Plan two_films() {
  Plan plan;
  plan.options = {"/films/felt", 32};
  plan.films = {film_of(3, "/films/\"wind\" \xC3\xBC.mp4"), film_of(1, "/films/sea.mkv")};
  plan.films[1].index.ending = haptic::kMatroska;
  plan.films[1].index.rotation = "rotate-90";
  plan.films[1].index.warnings = {"a stream of text is left out"};
  plan.chunks = {{0, {0, 2}}, {0, {2, 3}}, {1, {0, 1}}};
  return plan;
}

class AuthorPlan : public testing::Test {
protected:
  Plan read(const std::string &text) const { return haptic::read_plan(folder.write("plan", text)); }
  std::string refusal(const std::string &text) const {
    return error_of([&] { read(text); });
  }
  std::string sentence_of_wrong() const {
    return haptic::format_text(haptic::messages::kPlanIsWrong, folder.path_of("plan").c_str());
  }

  const TemporaryFolder folder;
};

TEST_F(AuthorPlan, ItSurvivesBeingWrittenAndRead) {
  const Plan sent = two_films();
  const Plan got = read(write_plan(sent));
  EXPECT_EQ(got.options.folder, sent.options.folder);
  EXPECT_EQ(got.options.columns, sent.options.columns);
  ASSERT_EQ(got.films.size(), sent.films.size());
  for (std::size_t i = 0; i < sent.films.size(); ++i) {
    const PlannedFilm &a = sent.films[i];
    const PlannedFilm &b = got.films[i];
    EXPECT_EQ(b.path, a.path);
    EXPECT_EQ(b.size, a.size);
    EXPECT_EQ(b.modified, a.modified);
    EXPECT_EQ(b.hash, a.hash);
    EXPECT_EQ(b.index.ending, a.index.ending);
    EXPECT_EQ(b.index.rotation, a.index.rotation);
    EXPECT_EQ(b.index.duration, a.index.duration);
    EXPECT_EQ(b.index.warnings, a.index.warnings);
    EXPECT_EQ(copy_mark(b, got.options), copy_mark(a, sent.options));
  }
  ASSERT_EQ(got.chunks.size(), sent.chunks.size());
  for (std::size_t i = 0; i < sent.chunks.size(); ++i) {
    const PlannedChunk &a = sent.chunks[i];
    const PlannedChunk &b = got.chunks[i];
    EXPECT_EQ(b.film, a.film);
    EXPECT_EQ(b.spans.begin, a.spans.begin);
    EXPECT_EQ(b.spans.end, a.spans.end);
    EXPECT_EQ(chunk_mark(got.films[b.film], b.spans, got.options),
              chunk_mark(sent.films[a.film], a.spans, sent.options))
        << "the mark holds the times of the spans";
  }
}

TEST_F(AuthorPlan, ItNamesTheThingsToHoldAndTheCopyDependsOnThem) {
  Plan sent = two_films();
  const PlannedFilm &film = sent.films[0];
  const std::string without = copy_mark(film, sent.options);
  EXPECT_EQ(write_plan(sent).find("hold"), std::string::npos) << "as it was before";
  sent.options.hold.chooses = true;
  const std::string chosen = copy_mark(film, sent.options);
  sent.options.hold.points = {{0.25, 0.1, 2.5}, {1, 0, 0}};
  const Plan got = read(write_plan(sent));
  EXPECT_EQ(got.options.hold, sent.options.hold);
  EXPECT_NE(chosen, without);
  EXPECT_NE(copy_mark(film, sent.options), chosen);
  std::string wrong = write_plan(sent);
  wrong.replace(wrong.find("0.25,"), 5, "2.25,");
  EXPECT_EQ(refusal(wrong), sentence_of_wrong());
}

TEST(HoldPoint, IsAPlaceAndMayHaveATime) {
  using haptic::HoldPoint;
  using haptic::read_hold_point;
  EXPECT_EQ(read_hold_point("0.5,0.25"), (HoldPoint{0.5, 0.25, 0}));
  EXPECT_EQ(read_hold_point("1,0@12.5"), (HoldPoint{1, 0, 12.5}));
  for (const char *none : {"", "0.5", "0.5,", "1.1,0", "-0.1,0", "0,0@", "0,0@-1", "0,0@1s", "0,0 ",
                           "nan,0", "0;0", "auto"})
    EXPECT_FALSE(read_hold_point(none)) << none;
  const HoldPoint points[] = {{0.1, 0.2, 0}, {1, 0, 1.5}};
  EXPECT_EQ(haptic::write_hold_points(points), "0.1,0.2@0 1,0@1.5");
}

TEST_F(AuthorPlan, OneThatWasChangedIsRefused) {
  const std::string whole = write_plan(two_films());
  const std::pair<std::string, std::string> changes[] = {{"\"columns\": 32", "\"columns\": 97"},
                                                         {"\"columns\": 32", "\"columns\": 3"},
                                                         {"\"sha256\"", "\"sha1\""},
                                                         {"\"size\": 4711", "\"size\": -1"},
                                                         {"\"size\": 4711", "\"size\": \"4711\""},
                                                         {"\".mkv\"", "\".avi\""},
                                                         {"\"end-span\": 2", "\"end-span\": 1"},
                                                         {"\"end-span\": 2", "\"end-span\": 3"},
                                                         {"\"end-span\": 1", "\"end-span\": 9"},
                                                         {"\"input\": 1", "\"input\": 2"},
                                                         {"\"input\": 1", "\"input\": 0"},
                                                         {"\"chunks\"", "\"parts\""}};
  for (const auto &[from, to] : changes) {
    std::string changed = whole;
    changed.replace(changed.find(from), from.size(), to);
    EXPECT_EQ(refusal(changed), sentence_of_wrong()) << from << " became " << to;
  }
  for (const std::string text : {"", "[]", "{}", "0", "no plan"})
    EXPECT_EQ(refusal(text), sentence_of_wrong()) << text;
  for (std::size_t size = 0; size < whole.rfind('}'); size += 13)
    EXPECT_EQ(refusal(whole.substr(0, size)), sentence_of_wrong()) << size << " bytes";
}

TEST_F(AuthorPlan, OneOfAnotherVersionIsRefusedByItsNumber) {
  std::string other = write_plan(two_films());
  const std::size_t at = other.find("\"version\": \"") + 12;
  other.replace(at, other.find('"', at) - at, "0.0.1");
  EXPECT_NE(refusal(other).find("version 0.0.1 made this plan"), std::string::npos);
  EXPECT_EQ(error_of([&] { haptic::read_plan(folder.path_of("none")); }),
            haptic::format_text(haptic::messages::kFileIsMissing, folder.path_of("none").c_str()));
}

TEST_F(AuthorPlan, ChunksHoldEachSpanOnceAndAreAboutAsLong) {
  const std::vector<PlannedFilm> films = {film_of(60, "a"), film_of(1, "b"), film_of(29, "c")};
  for (const std::size_t count : {1U, 3U, 9U, 30U, 1000U}) {
    const auto chunks = haptic::divide_films(films, count);
    std::size_t next = 0;
    for (std::size_t film = 0; film < films.size(); ++film) {
      std::size_t span = 0;
      std::size_t longest = 0;
      std::size_t shortest = films[film].index.spans.size();
      for (; next < chunks.size() && chunks[next].film == film; ++next) {
        EXPECT_EQ(chunks[next].spans.begin, span);
        span = chunks[next].spans.end;
        longest = std::max(longest, span - chunks[next].spans.begin);
        shortest = std::min(shortest, span - chunks[next].spans.begin);
      }
      EXPECT_EQ(span, films[film].index.spans.size()) << count;
      EXPECT_LE(longest - shortest, 1U) << count;
    }
    EXPECT_EQ(next, chunks.size());
  }
}

TEST_F(AuthorPlan, AFilmMayBeCopiedButNotChanged) {
  const std::string path = folder.write("film.mp4", "frames");
  const PlannedFilm film = haptic::identify(path);
  const auto check = [&](bool wholly) { return error_of([&] { check_unchanged(film, wholly); }); };
  const std::string changed = haptic::format_text(haptic::messages::kFilmHasChanged, path.c_str());
  const auto time = fs::last_write_time(path);
  fs::last_write_time(path, time + std::chrono::hours(1));
  EXPECT_EQ(check(false), "") << "another time, and the same content";
  folder.write("film.mp4", "Frames");
  fs::last_write_time(path, time + std::chrono::hours(1));
  EXPECT_EQ(check(false), changed);
  fs::last_write_time(path, time);
  EXPECT_EQ(check(true), changed) << "of the same size and time";
  folder.write("film.mp4", "more frames");
  EXPECT_EQ(check(false), changed);
}

} // namespace author_plan_test
