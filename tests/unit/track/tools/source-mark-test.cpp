// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/source-mark.hpp"

#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "leaf-track.hpp"
#include "temporary-folder.hpp"
#include "track-error.hpp"

#include <gtest/gtest.h>

namespace source_mark_test {

using haptic::CodedField;
using test::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;

// Of "abc" (FIPS 180-2, B.1).
constexpr char kHashOfAbc[] = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

std::string text_of(const Bytes &bytes) {
  return {bytes.begin(), bytes.end()};
}

class SourceMark : public testing::Test {
protected:
  std::optional<std::string> mark_in(const std::string &content) const {
    return haptic::mark_in(folder.write("copy", content));
  }

  const TemporaryFolder folder;
  const CodedField field = test::leaf_track(1)[0];
  const std::string mark = haptic::mark_of(kHashOfAbc, "columns 32");
};

TEST_F(SourceMark, ItIsFoundInKlvAndTheFieldIsTheSame) {
  Bytes set = write_klv(field);
  haptic::insert_mark(set, mark);
  EXPECT_EQ(mark_in("what a container writes before" + text_of(set)), mark);
  haptic::KlvReader reader(set);
  EXPECT_EQ(coded_field_of(reader.next().value()), field);
  EXPECT_FALSE(reader.next());
}

TEST_F(SourceMark, ItIsFoundInTextAndTheFieldIsTheSame) {
  const std::string line = write_text_line(field);
  Bytes bytes(line.begin(), line.end());
  haptic::insert_mark(bytes, mark);
  EXPECT_EQ(mark_in("1\n00:00:00,000 --> 00:00:01,000\n" + text_of(bytes) + "\n"), mark);
  EXPECT_EQ(haptic::read_text_line(text_of(bytes)).field, field);
}

TEST_F(SourceMark, ACopyOfUnknownOriginHasAnEmptyOne) {
  EXPECT_EQ(mark_in(text_of(write_klv(field))), "");
  EXPECT_EQ(mark_in(write_text_line(field)), "");
}

TEST_F(SourceMark, ATrackOfEachKindIsFound) {
  CodedField relief = field;
  relief.kind = haptic::FieldKind::relief;
  for (const std::string &content :
       {text_of(write_klv(field)), write_text_line(field), write_text_line(relief),
        write_text_line(haptic::TrackSample{})})
    EXPECT_TRUE(haptic::holds_track(folder.write("film", "what stands before" + content)));
  EXPECT_FALSE(haptic::holds_track(folder.write("film", "hv1 and no line")));
}

TEST_F(SourceMark, AFileWithoutFieldsHasNone) {
  EXPECT_EQ(mark_in(""), std::nullopt);
  EXPECT_EQ(mark_in("src=" + mark), std::nullopt);
  EXPECT_EQ(haptic::mark_in(folder.path_of("missing")), std::nullopt);
}

TEST_F(SourceMark, AFileThatEndsWithinItHasAnEmptyOne) {
  Bytes set = write_klv(field);
  haptic::insert_mark(set, mark);
  const std::size_t begin = text_of(set).find(mark);
  for (std::size_t size = haptic::kMotionKey.size(); size < begin + mark.size(); ++size)
    EXPECT_EQ(mark_in(text_of(set).substr(0, size)), "") << size;
}

TEST_F(SourceMark, ItDependsOnTheFilmAndOnTheSettings) {
  EXPECT_EQ(haptic::hash_of_file(folder.write("film", "abc")), kHashOfAbc);
  EXPECT_EQ(mark.size(), 16U);
  EXPECT_EQ(haptic::mark_of(kHashOfAbc, "columns 32"), mark);
  EXPECT_NE(haptic::mark_of(kHashOfAbc, "columns 33"), mark);
  EXPECT_NE(haptic::mark_of(haptic::hash_of_file(folder.write("film", "abd")), "columns 32"), mark);
  EXPECT_THROW(haptic::hash_of_file(folder.path_of("missing")), haptic::TrackFileError);
}

} // namespace source_mark_test
