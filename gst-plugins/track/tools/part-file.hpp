// SPDX-License-Identifier: LGPL-2.1-or-later
// A file that appears under its name only when it is whole and on the disk.
#pragma once

#include <string>

namespace haptic {

/// A file under another name, locked against other processes. It is removed unless it is kept.
/// Throws TrackFileError.
class PartFile {
public:
  explicit PartFile(std::string path);
  ~PartFile();
  PartFile(const PartFile &) = delete;
  PartFile &operator=(const PartFile &) = delete;

  const std::string &path() const noexcept { return path_; }

  /// Writes the content to the disk before it renames the file, and then the name.
  void keep_as(const std::string &path);

private:
  std::string path_;
  int fd_ = -1;
  bool kept_ = false;
};

} // namespace haptic
