// SPDX-License-Identifier: LGPL-2.1-or-later
// A file that appears under its name only when it is whole and on the disk; and the start of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace haptic {

/// A file under another name, locked against other processes. It is removed unless it is kept.
/// Throws TrackFileError.
class PartFile {
public:
  /// `name` stands in the error if another process has the lock; empty: the path.
  explicit PartFile(std::string path, const std::string &name = {});
  ~PartFile();
  PartFile(const PartFile &) = delete;
  PartFile &operator=(const PartFile &) = delete;

  const std::string &path() const noexcept { return path_; }

  /// Appends to it, from its begin on.
  void write(std::span<const std::uint8_t> bytes);

  /// Writes the content to the disk before it renames the file, and then the name.
  void keep_as(const std::string &path);

private:
  std::string path_;
  int fd_ = -1;
  bool kept_ = false;
  bool begun_ = false;
};

/// Returns the first bytes of a file, at most so many; nothing if it cannot be read.
std::string read_start(const std::string &path, std::size_t most);

/// Renames a file or folder and writes the name to the disk. Throws TrackFileError.
void rename_on_disk(const std::string &from, const std::string &to);

/// Writes a file that appears under its name when it is whole. Throws TrackFileError.
void write_bytes(const std::string &path, std::span<const std::uint8_t> bytes);
void write_bytes(const std::string &path, std::string_view text);

} // namespace haptic
