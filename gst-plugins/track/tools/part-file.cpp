// SPDX-License-Identifier: LGPL-2.1-or-later
#include "part-file.hpp"

#include "track-error.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace haptic {
namespace {

// Of a file system: Lustre without the mount option flock, NFS without lockd, some of FUSE.
bool knows_no_locks(int error) {
  return error == ENOSYS || error == ENOLCK || error == EOPNOTSUPP;
}

} // namespace

PartFile::PartFile(std::string path, const std::string &name) : path_(std::move(path)) {
  for (;;) {
    fd_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd_ < 0)
      throw_error(messages::kOutputFails, path_.c_str(), std::strerror(errno));
    if (flock(fd_, LOCK_EX | LOCK_NB) != 0 && !knows_no_locks(errno)) {
      const int error = errno;
      close(fd_);
      if (error == EWOULDBLOCK)
        throw_error(messages::kFileIsBeingWritten, (name.empty() ? path_ : name).c_str());
      throw_error(messages::kOutputFails, path_.c_str(), std::strerror(error));
    }
    // Its holder may have kept or removed it before the lock.
    struct stat held = {};
    struct stat named = {};
    fstat(fd_, &held);
    if (stat(path_.c_str(), &named) == 0 && held.st_ino == named.st_ino)
      return;
    close(fd_);
  }
}

PartFile::~PartFile() {
  if (!kept_)
    unlink(path_.c_str());
  close(fd_);
}

void PartFile::write(std::span<const std::uint8_t> bytes) {
  bool good = std::exchange(begun_, true) || ftruncate(fd_, 0) == 0; // of a process that died
  while (good && !bytes.empty()) {
    const ssize_t count = ::write(fd_, bytes.data(), bytes.size());
    good = count > 0 || (count < 0 && errno == EINTR);
    bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  if (!good)
    throw_error(messages::kOutputFails, path_.c_str(), std::strerror(errno));
}

void PartFile::keep_as(const std::string &path) {
  if (fsync(fd_) != 0)
    throw_error(messages::kOutputFails, path.c_str(), std::strerror(errno));
  rename_on_disk(path_, path);
  kept_ = true;
}

std::string read_start(const std::string &path, std::size_t most) {
  std::string bytes(most, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(most));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

void rename_on_disk(const std::string &from, const std::string &to) {
  if (std::rename(from.c_str(), to.c_str()) != 0)
    throw_error(messages::kOutputFails, to.c_str(), std::strerror(errno));
  const std::string folder = std::filesystem::path(to).parent_path().string();
  if (const int fd = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC); fd >= 0) {
    fsync(fd);
    close(fd);
  }
}

void write_bytes(const std::string &path, std::span<const std::uint8_t> bytes) {
  PartFile part(path + ".part");
  part.write(bytes);
  part.keep_as(path);
}

void write_bytes(const std::string &path, std::string_view text) {
  write_bytes(path, {reinterpret_cast<const std::uint8_t *>(text.data()), text.size()});
}

} // namespace haptic
