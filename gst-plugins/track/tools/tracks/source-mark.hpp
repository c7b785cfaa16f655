// SPDX-License-Identifier: LGPL-2.1-or-later
// The mark in a copy that says of which video and with which settings it was made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glib.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// The SHA-256 of some bytes.
class ContentHash {
public:
  void add(const void *bytes, std::size_t size);
  /// Returns 64 hexadecimal digits. Nothing is added afterwards.
  std::string digits() const;

private:
  std::unique_ptr<GChecksum, decltype(&g_checksum_free)> sum_{g_checksum_new(G_CHECKSUM_SHA256),
                                                              g_checksum_free};
};

/// Returns the ContentHash of a file. Throws TrackFileError.
std::string hash_of_file(const std::string &path);

/// Returns 16 hexadecimal digits that depend on the digits of a file and on the settings.
std::string mark_of(const std::string &hash, const std::string &settings);

/// Puts the mark into the first field of a track, a KLV set or a line of text.
void insert_mark(std::vector<std::uint8_t> &field, const std::string &mark);

/// Returns whether a track of this project is in a file, be it of points, fields or reliefs.
bool holds_track(const std::string &path);

/// Returns the mark of a copy, empty if it has none; or nothing if the file holds no motion fields.
std::optional<std::string> mark_in(const std::string &path);

} // namespace haptic
