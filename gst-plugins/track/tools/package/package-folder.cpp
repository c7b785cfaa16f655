// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/package-folder.hpp"

#include "track-error.hpp"
#include "tracks/source-mark.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <regex>

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr char kWork[] = ".package"; // hidden: a web server need not show it

void check(const std::string &path, const std::error_code &error) {
  if (error)
    throw_error(messages::kOutputFails, path.c_str(), error.message().c_str());
}

} // namespace

PackageFolder::PackageFolder(const std::string &path, const std::string &mark,
                             const std::vector<PackageFile> &files)
    : path_(path), work_(path_ / kWork) {
  const bool is_ours = has(mark) || has(kWork);
  for (const auto &[name, source] : files)
    if (!is_ours && has(name) &&
        (source.empty() || hash_of_file(path_ / name) != hash_of_file(source)))
      throw_error(messages::kFolderHoldsOther, path_.c_str(), name.c_str());
  std::error_code error;
  fs::create_directories(path_, error);
  check(path_, error);
  lock_.emplace(work_.string() + ".lock", path_);
  fs::create_directory(work_, error);
  check(path_, error);
}

bool PackageFolder::has(const std::string &name) const {
  std::error_code error;
  return fs::exists(path_ / name, error);
}

std::string PackageFolder::begin(const std::string &name) {
  const fs::path part = work_ / name;
  std::error_code error;
  fs::remove_all(part, error);
  fs::create_directory(part, error);
  check(part, error);
  return part;
}

void PackageFolder::publish(const std::string &name) {
  rename_on_disk(work_ / name, path_ / name);
}

void PackageFolder::copy_in(const std::string &path, const std::string &name) {
  PartFile part(work_ / "file");
  std::error_code error;
  fs::copy_file(path, part.path(), fs::copy_options::overwrite_existing, error);
  check(name, error);
  part.keep_as(path_ / name);
}

void PackageFolder::copy_in(const std::vector<PackageFile> &files) {
  for (const auto &[name, source] : files) {
    std::error_code error;
    fs::create_directories((path_ / name).parent_path(), error);
    copy_in(source, name);
  }
}

void PackageFolder::finish(const std::string &playlist, const std::vector<std::string> &names) {
  write_bytes(path_ / kMainPlaylist, playlist);
  const std::regex rate("(ts|mp4|cmaf)-[0-9a-f]{16}"); // the folders that package() makes or made
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(path_, error))
    if (const std::string name = entry.path().filename();
        std::regex_match(name, rate) && std::ranges::find(names, name) == names.end())
      fs::remove_all(entry.path(), error);
  finish();
}

void PackageFolder::finish() {
  std::error_code error;
  fs::remove_all(work_, error);
}

std::vector<PackageFile> player_files(const std::string &player) {
  std::vector<PackageFile> files;
  std::error_code error;
  for (auto entry = fs::recursive_directory_iterator(player, error);
       entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const std::string name = fs::relative(entry->path(), player, error).string();
    if (entry->is_directory(error) && entry->path().extension() == ".p") // of the build
      entry.disable_recursion_pending();
    else if (entry->is_regular_file(error) && name != kSinglePage &&
             !entry->path().filename().string().starts_with("."))
      files.push_back({name, entry->path()});
  }
  check(player, error);
  return files;
}

std::string player_folder() {
  const char *named = std::getenv("FEELING_WIND_WEB");
  std::string path = named ? named : WEB_FOLDER;
  std::error_code error;
  if (!fs::is_regular_file(fs::path(path) / "index.html", error))
    throw_error(messages::kPlayerIsMissing, path.c_str());
  return path;
}

} // namespace haptic
