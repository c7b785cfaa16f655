// SPDX-License-Identifier: LGPL-2.1-or-later
#include "part-file.hpp"

#include "track-error.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace haptic {

namespace {

// Whether the name still means this file. Its holder may have kept or removed it before the lock.
bool is_at(const std::string &path, int fd) {
  struct stat held = {};
  struct stat named = {};
  return fstat(fd, &held) == 0 && stat(path.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino;
}

} // namespace

PartFile::PartFile(std::string path) : path_(std::move(path)) {
  for (;;) {
    fd_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd_ < 0)
      throw_error(messages::kOutputFails, path_.c_str(), std::strerror(errno));
    if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      close(fd_);
      throw_error(messages::kFileIsBeingWritten, path_.c_str());
    }
    if (is_at(path_, fd_))
      return;
    close(fd_);
  }
}

PartFile::~PartFile() {
  if (!kept_)
    unlink(path_.c_str());
  close(fd_);
}

void PartFile::keep_as(const std::string &path) {
  if (fsync(fd_) != 0 || std::rename(path_.c_str(), path.c_str()) != 0)
    throw_error(messages::kOutputFails, path.c_str(), std::strerror(errno));
  kept_ = true;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (const int fd = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC); fd >= 0) {
    fsync(fd);
    close(fd);
  }
}

} // namespace haptic
