// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/package-folder.hpp"

#include "part-file.hpp"
#include "track-error.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <sys/file.h>
#include <unistd.h>

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr char kWork[] = ".package"; // hidden: a web server need not show it
constexpr char kPage[] = "index.html";

[[noreturn]] void fail_to_write(const std::string &path) {
  throw_error(messages::kOutputFails, path.c_str(), std::strerror(errno));
}

std::string read_whole(const fs::path &path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void sync_folder(const std::string &path) {
  if (const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC); fd >= 0) {
    fsync(fd);
    close(fd);
  }
}

std::span<const std::uint8_t> bytes_of(const std::string &text) {
  return {reinterpret_cast<const std::uint8_t *>(text.data()), text.size()};
}

// Returns whether package() makes folders of such names: ts-0123456789abcdef.
bool is_name_of_rate(const std::string &name) {
  const std::size_t digits = name.find('-') + 1;
  return (name.starts_with("ts-") || name.starts_with("mp4-") || name.starts_with("cmaf-")) &&
         name.size() == digits + 16 &&
         name.find_first_not_of("0123456789abcdef", digits) == std::string::npos;
}

} // namespace

void write_whole(const std::string &path, std::span<const std::uint8_t> bytes) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  bool good = fd >= 0;
  while (good && !bytes.empty()) {
    const ssize_t count = ::write(fd, bytes.data(), bytes.size());
    good = count > 0 || (count < 0 && errno == EINTR);
    bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  good = good && fsync(fd) == 0;
  const int reason = errno;
  if (fd >= 0)
    close(fd);
  errno = reason;
  if (!good)
    fail_to_write(path);
}

void write_whole(const std::string &path, const std::string &text) {
  write_whole(path, bytes_of(text));
}

PackageFolder::PackageFolder(std::string path, std::string player, const std::string &page,
                             const std::string &mark)
    : path_(std::move(path)), player_(std::move(player)),
      work_((fs::path(path_) / kWork).string()) {
  std::error_code error;
  if (has(kPage) && !has(mark) &&
      read_whole(fs::path(path_) / kPage) != read_whole(fs::path(player_) / page))
    throw_error(messages::kFolderHoldsOther, path_.c_str());
  fs::create_directories(work_, error);
  if (error)
    throw_error(messages::kOutputFails, path_.c_str(), error.message().c_str());
  lock_ = open(work_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0)
    fail_to_write(work_);
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    close(lock_);
    throw_error(messages::kFileIsBeingWritten, path_.c_str());
  }
}

PackageFolder::~PackageFolder() {
  close(lock_);
}

bool PackageFolder::has(const std::string &name) const {
  std::error_code error;
  return fs::exists(fs::path(path_) / name, error);
}

std::string PackageFolder::begin(const std::string &name) {
  const fs::path part = fs::path(work_) / name;
  std::error_code error;
  fs::remove_all(part, error);
  fs::create_directory(part, error);
  if (error)
    throw_error(messages::kOutputFails, part.c_str(), error.message().c_str());
  return part.string();
}

void PackageFolder::publish(const std::string &name) {
  const std::string part = (fs::path(work_) / name).string();
  const std::string whole = (fs::path(path_) / name).string();
  sync_folder(part);
  if (std::rename(part.c_str(), whole.c_str()) != 0)
    fail_to_write(whole);
  sync_folder(path_);
}

void PackageFolder::write(const std::string &name, std::span<const std::uint8_t> bytes) {
  PartFile part((fs::path(work_) / "file").string());
  write_whole(part.path(), bytes);
  part.keep_as((fs::path(path_) / name).string());
}

void PackageFolder::copy(const std::string &from, const std::string &to) {
  write(to, bytes_of(read_whole(fs::path(path_) / from)));
}

void PackageFolder::copy_in(const std::string &path, const std::string &name) {
  PartFile part((fs::path(work_) / "file").string());
  std::error_code error;
  fs::copy_file(path, part.path(), fs::copy_options::overwrite_existing, error);
  if (error)
    throw_error(messages::kOutputFails, name.c_str(), error.message().c_str());
  part.keep_as((fs::path(path_) / name).string());
}

void PackageFolder::copy_player() {
  std::error_code error;
  for (auto entry = fs::recursive_directory_iterator(player_, error);
       entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const std::string name = fs::relative(entry->path(), player_, error).string();
    const bool is_of_build = entry->path().extension() == ".p";
    if (entry->is_directory(error)) {
      if (is_of_build)
        entry.disable_recursion_pending();
      else
        fs::create_directories(fs::path(path_) / name, error);
    } else if (entry->is_regular_file(error) && name != kSinglePage &&
               !entry->path().filename().string().starts_with(".")) {
      write(name, bytes_of(read_whole(entry->path())));
    }
  }
  if (error)
    throw_error(messages::kOutputFails, path_.c_str(), error.message().c_str());
}

void PackageFolder::finish(const std::string &playlist, const std::vector<std::string> &names) {
  write(kMainPlaylist, bytes_of(playlist));
  std::error_code error;
  std::vector<fs::path> old;
  for (const auto &entry : fs::directory_iterator(path_, error))
    if (const std::string name = entry.path().filename().string();
        is_name_of_rate(name) && std::ranges::find(names, name) == names.end())
      old.push_back(entry.path());
  for (const fs::path &path : old)
    fs::remove_all(path, error);
  finish();
}

void PackageFolder::finish() {
  std::error_code error;
  fs::remove_all(work_, error);
}

std::string player_folder() {
  const char *named = std::getenv("FEELING_WIND_WEB");
  std::string path = named ? named : WEB_FOLDER;
  std::error_code error;
  if (!fs::is_regular_file(fs::path(path) / kPage, error))
    throw_error(messages::kPlayerIsMissing, path.c_str());
  return path;
}

} // namespace haptic
