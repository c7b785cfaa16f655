// SPDX-License-Identifier: LGPL-2.1-or-later
// The folder of a package: files and folders appear under their names when they are whole.
#pragma once

#include "part-file.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// The main playlist, which the player plays.
inline constexpr char kMainPlaylist[] = "film.m3u8";
/// The page of a single film, among the player's files.
inline constexpr char kSinglePage[] = "single.html";

/// A file of a package and the one it is copied from, if there is one.
struct PackageFile {
  std::string name;
  std::string source;
};

class PackageFolder {
public:
  /// Makes the folder and locks it against other processes. Throws TrackFileError, also where it
  /// is no package, neither whole (with a file `mark`) nor begun, and another file has one of the
  /// names.
  PackageFolder(const std::string &path, const std::string &mark,
                const std::vector<PackageFile> &files);

  const std::filesystem::path &path() const noexcept { return path_; }
  /// A folder for what is not whole. It stays until finish(), so that the next process can go on.
  std::string work() const { return work_; }

  bool has(const std::string &name) const;
  /// Returns the path of an empty folder, which publish() gives its name.
  std::string begin(const std::string &name);
  void publish(const std::string &name);
  /// Copies a file into the folder, however large it is.
  void copy_in(const std::string &path, const std::string &name);
  void copy_in(const std::vector<PackageFile> &files);

  /// Writes the main playlist and removes the bit rates that are not among the given names.
  void finish(const std::string &playlist, const std::vector<std::string> &names);
  /// Removes work().
  void finish();

private:
  std::filesystem::path path_;
  std::filesystem::path work_;
  std::optional<PartFile> lock_; // beside work_, which finish() removes
};

/// Returns the player's files.
std::vector<PackageFile> player_files(const std::string &player);

/// Returns the folder of the player's files. Throws TrackFileError if it is not there.
std::string player_folder();

} // namespace haptic
