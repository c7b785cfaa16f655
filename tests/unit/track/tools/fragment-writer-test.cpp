// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/fragment-writer.hpp"

#include "made-film.hpp"

#include <gtest/gtest.h>
#include <span>
#include <string>

namespace fragment_writer_test {

using haptic::FilmFormat;
using haptic::FilmSegment;
using haptic::FragmentWriter;
using Bytes = std::span<const std::uint8_t>;

constexpr std::int64_t kFrame = 40'000'000;                               // ns
constexpr char kScheme[] = "urn:misb:KLV:bin:1910.1";                     // MISB ST 1910
constexpr std::int64_t kSoundFrame = 1024;                                // samples
constexpr std::int64_t kSoundTime = kSoundFrame * 1'000'000'000 / 44'100; // ns

std::uint64_t number_at(Bytes bytes, std::size_t at, std::size_t size) {
  std::uint64_t number = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size))
    number = number << 8 | byte;
  return number;
}

struct Box {
  std::string type;
  std::size_t at; // of its size, in what it was read from
  Bytes content;
};

// Expects that the boxes fill the bytes.
std::vector<Box> boxes_in(Bytes bytes) {
  std::vector<Box> boxes;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t size = bytes.size() - at < 8 ? 0 : number_at(bytes, at, 4);
    if (size < 8 || size > bytes.size() - at) {
      ADD_FAILURE() << "a box of " << size << " bytes at " << at << " of " << bytes.size();
      return boxes;
    }
    boxes.push_back({{bytes.begin() + static_cast<std::ptrdiff_t>(at) + 4,
                      bytes.begin() + static_cast<std::ptrdiff_t>(at) + 8},
                     at,
                     bytes.subspan(at + 8, size - 8)});
    at += size;
  }
  return boxes;
}

std::vector<std::string> types_in(Bytes bytes) {
  std::vector<std::string> types;
  for (const Box &box : boxes_in(bytes))
    types.push_back(box.type);
  return types;
}

// The content of the first box of each type, one in another.
Bytes inner(Bytes bytes, std::initializer_list<const char *> path) {
  for (const char *type : path) {
    const auto boxes = boxes_in(bytes);
    const auto box = std::ranges::find(boxes, type, &Box::type);
    if (box == boxes.end()) {
      ADD_FAILURE() << "no " << type;
      return {};
    }
    bytes = box->content;
  }
  return bytes;
}

// Ten frames, and the sound and the fields beside them.
FilmSegment segment_of(std::size_t number) {
  std::vector<test::FrameTime> times;
  for (std::int64_t i = 0; i < 10; ++i)
    times.push_back({(static_cast<std::int64_t>(number) * 10 + i) * kFrame, i == 0});
  FilmSegment segment = test::film_segment(times);
  segment.number = number;
  for (std::size_t i = 0; i < segment.frames.size(); ++i) {
    segment.frames[i].bytes = test::film_frame(i == 0, 100 * i);
    segment.fields.push_back({segment.frames[i].presentation, haptic::FieldKind::motion,
                              std::vector<std::uint8_t>(20 + i, static_cast<std::uint8_t>(i))});
  }
  return segment;
}

void add_sounds(FilmSegment &segment, std::int64_t start, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    segment.sounds.push_back({start + static_cast<std::int64_t>(i) * kSoundTime,
                              std::vector<std::uint8_t>(50 + i, static_cast<std::uint8_t>(i))});
}

TEST(FragmentWriter, TheHeadNamesTheTracksAndHoldsTheParameterSets) {
  for (const bool has_sound : {false, true}) {
    const FilmFormat format = test::film_format(has_sound);
    const auto head = FragmentWriter(format).head();
    EXPECT_EQ(types_in(head), (std::vector<std::string>{"ftyp", "moov"}));
    const Bytes movie = inner(head, {"moov"});
    std::vector<std::string> wanted = {"mvhd", "trak", "mvex"};
    if (has_sound)
      wanted.insert(wanted.begin() + 1, "trak");
    EXPECT_EQ(types_in(movie), wanted);
    EXPECT_EQ(boxes_in(inner(movie, {"mvex"})).size(), has_sound ? 2U : 1U);
    // Behind version, flags and count stands the entry, with 78 bytes before its boxes.
    const Bytes entry =
        inner(inner(movie, {"trak", "mdia", "minf", "stbl", "stsd"}).subspan(8), {"avc1"})
            .subspan(78);
    const Bytes configuration = inner(entry, {"avcC"});
    for (const auto &set : {format.sequence_sets[0], format.picture_sets[0]})
      EXPECT_FALSE(std::ranges::search(configuration, set).empty());
  }
}

// The box has 16 bits for it (ISO/IEC 14496-12, 12.2.3).
TEST(FragmentWriter, ARateOfSoundThatDoesNotFitIsZero) {
  for (const auto &[rate, wanted] : {std::pair(44100, 44100), std::pair(96000, 0)}) {
    FilmFormat format = test::film_format(true);
    format.sound_rate = rate;
    const auto head = FragmentWriter(format).head();
    const auto at = std::ranges::search(head, std::string_view("mp4a")).begin() + 4 + 24;
    EXPECT_EQ(at[0] << 8 | at[1], wanted);
  }
}

TEST(FragmentWriter, BoxesAreAsLongAsTheySay) {
  const FilmFormat format = test::film_format(true);
  FilmSegment segment = segment_of(0);
  add_sounds(segment, 0, 17);
  FragmentWriter writer(format);
  const auto bytes = writer.write(segment);
  std::vector<std::string> wanted(segment.fields.size(), "emsg");
  wanted.insert(wanted.begin(), "styp");
  wanted.insert(wanted.end(), {"moof", "mdat"});
  EXPECT_EQ(types_in(bytes), wanted);
  EXPECT_EQ(types_in(inner(bytes, {"moof"})), (std::vector<std::string>{"mfhd", "traf", "traf"}));
  for (const Box &box : boxes_in(inner(bytes, {"moof"}))) {
    if (box.type == "traf") {
      EXPECT_EQ(types_in(box.content), (std::vector<std::string>{"tfhd", "tfdt", "trun"}));
    }
  }
}

TEST(FragmentWriter, EachFrameStandsWhereItsRunSays) {
  const FilmFormat format = test::film_format(true);
  FilmSegment segment = segment_of(3);
  add_sounds(segment, segment.number * 10 * kFrame, 17);
  const auto bytes = FragmentWriter(format).write(segment);
  const auto boxes = boxes_in(bytes);
  const auto fragment = std::ranges::find(boxes, "moof", &Box::type);
  ASSERT_NE(fragment, boxes.end());
  EXPECT_EQ(number_at(inner(fragment->content, {"mfhd"}), 4, 4), segment.number + 1);
  const Bytes run = inner(fragment->content, {"traf", "trun"});
  EXPECT_EQ(number_at(inner(fragment->content, {"traf", "tfdt"}), 4, 8),
            static_cast<std::uint64_t>(segment.frames[0].turn));
  ASSERT_EQ(number_at(run, 4, 4), segment.frames.size());
  std::size_t at = fragment->at + number_at(run, 8, 4);
  for (std::size_t i = 0; i < segment.frames.size(); ++i) {
    const auto &frame = segment.frames[i];
    const std::size_t entry = 12 + 16 * i;
    EXPECT_EQ(number_at(run, entry, 4), static_cast<std::uint64_t>(frame.duration));
    ASSERT_EQ(number_at(run, entry + 4, 4), frame.bytes.size());
    EXPECT_EQ(number_at(run, entry + 8, 4) >> 16 & 1, frame.is_idr ? 0U : 1U) << "sync sample";
    EXPECT_TRUE(std::ranges::equal(Bytes(bytes).subspan(at, frame.bytes.size()), frame.bytes)) << i;
    at += frame.bytes.size();
  }
  for (const auto &sound : segment.sounds) {
    EXPECT_TRUE(std::ranges::equal(Bytes(bytes).subspan(at, sound.bytes.size()), sound.bytes));
    at += sound.bytes.size();
  }
  EXPECT_EQ(at, bytes.size());
}

TEST(FragmentWriter, EachFieldIsAnEventAtItsTime) {
  const FilmFormat format = test::film_format(false);
  FragmentWriter writer(format);
  std::uint64_t number = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const FilmSegment segment = segment_of(i);
    const auto bytes = writer.write(segment);
    const auto boxes = boxes_in(bytes);
    for (std::size_t k = 0; k < segment.fields.size(); ++k) {
      const Bytes event = boxes.at(k + 1).content;
      ASSERT_EQ(boxes[k + 1].type, "emsg");
      all += 8 + event.size();
      EXPECT_EQ(number_at(event, 0, 4), 0x01000000U) << "version 1: the time is that of the film";
      EXPECT_EQ(number_at(event, 4, 4), 90'000U);
      EXPECT_EQ(number_at(event, 8, 8), static_cast<std::uint64_t>(segment.fields[k].presentation));
      EXPECT_EQ(number_at(event, 20, 4), number++) << "the next one is another event";
      const Bytes rest = event.subspan(24);
      ASSERT_EQ(std::string(rest.begin(), rest.begin() + sizeof kScheme - 1), kScheme);
      EXPECT_TRUE(std::ranges::equal(rest.subspan(sizeof kScheme + 1), segment.fields[k].set));
    }
  }
  EXPECT_EQ(writer.track_bytes(), all);
}

TEST(FragmentWriter, SoundIsCountedOnUnlessItHasAGap) {
  const FilmFormat format = test::film_format(true);
  FragmentWriter writer(format);
  const auto begin_of_sound = [&](std::int64_t start) {
    FilmSegment segment = segment_of(0);
    add_sounds(segment, start, 10);
    const auto bytes = writer.write(segment);
    const auto boxes = boxes_in(inner(bytes, {"moof"}));
    return static_cast<std::int64_t>(number_at(inner(boxes.at(2).content, {"tfdt"}), 4, 8));
  };
  EXPECT_EQ(begin_of_sound(0), 0);
  constexpr std::int64_t kLength = 10 * kSoundTime; // ns
  constexpr std::int64_t kRounding = 1'000'000;     // ns, of the times in a film
  EXPECT_EQ(begin_of_sound(kLength + kRounding), 10 * kSoundFrame);
  EXPECT_EQ(begin_of_sound(2 * kLength - kRounding), 20 * kSoundFrame);
  EXPECT_EQ(begin_of_sound(1'000'000'000), 44'100);
}

} // namespace fragment_writer_test
