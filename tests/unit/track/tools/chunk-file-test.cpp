// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/chunk-file.hpp"

#include "leaf-track.hpp"
#include "temporary-folder.hpp"

#include <filesystem>
#include <gtest/gtest.h>

namespace chunk_file_test {

namespace fs = std::filesystem;
namespace messages = haptic::messages;
using haptic::ChunkReader;
using haptic::CodedField;
using test::content_of;
using test::TemporaryFolder;

constexpr char kMark[] = "0123456789abcdef";
constexpr char kOtherMark[] = "fedcba9876543210";

class ChunkFile : public testing::Test {
protected:
  void write(const std::vector<CodedField> &fields) {
    haptic::ChunkWriter writer(path, kMark);
    for (const CodedField &field : fields)
      writer.add(field);
    EXPECT_FALSE(fs::exists(path)) << "before it is whole";
    writer.finish({.frames = fields.size(), .confidence = 123'456});
  }

  const char *problem(const char *mark = kMark) const { return ChunkReader(path, mark).problem(); }

  const TemporaryFolder folder;
  const std::string path = folder.path_of("film.haptic.chunk-0-1");
  const std::vector<CodedField> track = test::leaf_track(4);
};

TEST_F(ChunkFile, WhatWasWrittenIsRead) {
  write(track);
  const ChunkReader reader(path, kMark);
  ASSERT_EQ(reader.problem(), nullptr);
  EXPECT_EQ(reader.stats().frames, track.size());
  EXPECT_EQ(reader.stats().confidence, 123'456U);
  for (int round = 0; round < 2; ++round) {
    haptic::KlvReader sets(reader.fields());
    for (const CodedField &field : track)
      EXPECT_EQ(coded_field_of(sets.next().value()), field);
    EXPECT_FALSE(sets.next());
    reader.forget(); // and it is read again
  }
}

TEST_F(ChunkFile, CutAnywhereItIsDamaged) {
  write(track);
  // Without its last newline it is whole.
  for (auto size = fs::file_size(path) - 2; size > 0; --size) {
    fs::resize_file(path, size);
    ASSERT_STREQ(problem(), messages::kChunkIsDamaged) << size << " bytes";
  }
  fs::resize_file(path, 0);
  EXPECT_STREQ(problem(), messages::kChunkIsDamaged);
  fs::remove(path);
  EXPECT_STREQ(problem(), messages::kChunkIsMissing);
}

TEST_F(ChunkFile, OneOtherByteInAFieldDamagesIt) {
  write(track);
  const std::string whole = content_of(path);
  const std::size_t size = ChunkReader(path, kMark).fields().size();
  for (std::size_t at = 0; at < size; at += 7) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    folder.write(fs::path(path).filename(), changed);
    ASSERT_STREQ(problem(), messages::kChunkIsDamaged) << at;
  }
}

TEST_F(ChunkFile, OneOfAnotherFilmIsForeign) {
  write(track);
  EXPECT_STREQ(problem(kOtherMark), messages::kChunkIsForeign);
  EXPECT_EQ(problem(), nullptr);
}

TEST_F(ChunkFile, AClaimOfMoreFramesThanThereAreNumbersIsDamage) {
  write(track);
  std::string claims = content_of(path);
  claims.insert(claims.rfind(kMark) + sizeof kMark, 30, '9'); // behind the mark and a blank
  folder.write(fs::path(path).filename(), claims);
  EXPECT_STREQ(problem(), messages::kChunkIsDamaged);
}

TEST_F(ChunkFile, AnUnfinishedOneLeavesNothing) {
  { haptic::ChunkWriter(path, kMark).add(track[0]); }
  EXPECT_TRUE(folder.is_empty());
}

} // namespace chunk_file_test
