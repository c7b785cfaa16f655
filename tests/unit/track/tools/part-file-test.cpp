// SPDX-License-Identifier: LGPL-2.1-or-later
#include "part-file.hpp"

#include "temporary-folder.hpp"
#include "track-error.hpp"

#include <cerrno>
#include <filesystem>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace part_file_test {

namespace fs = std::filesystem;
using haptic::PartFile;
using haptic::TrackFileError;
using test::content_of;
using test::TemporaryFolder;

bool has_locks = true; // the file system

extern "C" int flock(int file, int operation) noexcept {
  if (has_locks)
    return static_cast<int>(syscall(SYS_flock, file, operation));
  errno = ENOSYS;
  return -1;
}

std::string refusal(const std::string &path) {
  try {
    const PartFile part(path);
  } catch (const TrackFileError &error) {
    return error.what();
  }
  return "";
}

TEST(PartFile, ItHasItsNameOnlyWhenItIsWhole) {
  const TemporaryFolder folder;
  const std::string name = folder.path_of("track.ts");
  {
    PartFile part(name + ".part");
    folder.write("track.ts.part", "all of it");
    EXPECT_FALSE(fs::exists(name));
    part.keep_as(name);
    EXPECT_EQ(content_of(name), "all of it");
    EXPECT_FALSE(fs::exists(part.path()));
  }
  EXPECT_EQ(content_of(name), "all of it") << "and it stays";
}

TEST(PartFile, AFileSystemWithoutLocksIsWrittenTo) {
  const TemporaryFolder folder;
  const std::string name = folder.path_of("track.ts");
  has_locks = false;
  EXPECT_EQ(refusal(name + ".part"), "");
  has_locks = true;
}

TEST(PartFile, WhatIsNotKeptIsRemovedAndTheFileOfBeforeStays) {
  const TemporaryFolder folder;
  const std::string name = folder.write("track.ts", "of before");
  {
    const PartFile part(name + ".part");
    folder.write("track.ts.part", "half of");
  }
  EXPECT_FALSE(fs::exists(name + ".part"));
  EXPECT_EQ(content_of(name), "of before");
}

TEST(PartFile, OnlyOneWritesAFileAtATime) {
  const TemporaryFolder folder;
  const std::string name = folder.path_of("track.ts.part");
  {
    const PartFile first(name);
    EXPECT_EQ(refusal(name),
              haptic::format_text(haptic::messages::kFileIsBeingWritten, name.c_str()));
    EXPECT_TRUE(fs::exists(name)) << "who was refused removes nothing";
  }
  EXPECT_EQ(refusal(name), "") << "after the first one ended";
}

TEST(PartFile, AFileOfADeadProcessIsTakenOver) {
  const TemporaryFolder folder;
  const std::string name = folder.write("track.ts.part", "left behind");
  EXPECT_EQ(refusal(name), "");
  EXPECT_TRUE(folder.is_empty());
}

TEST(PartFile, APlaceThatDoesNotExistIsNamed) {
  const TemporaryFolder folder;
  const std::string nowhere = folder.path_of("missing/track.ts");
  EXPECT_NE(refusal(nowhere).find(nowhere), std::string::npos);
  {
    PartFile part(folder.path_of("track.ts.part"));
    EXPECT_THROW(part.keep_as(nowhere), TrackFileError);
  }
  EXPECT_TRUE(folder.is_empty()) << "what could not be kept is removed";
}

} // namespace part_file_test
