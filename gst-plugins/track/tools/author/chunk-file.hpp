// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion fields of some spans of a film as a file: sets of KLV, and a line of text that says
// what they belong to.
#pragma once

#include "forms/klv.hpp"
#include "part-file.hpp"
#include "track-error.hpp"
#include "tracks/source-mark.hpp"

#include <cstdint>
#include <glib.h>
#include <memory>
#include <string>

namespace haptic {

struct ChunkStats {
  std::uint64_t frames = 0;     ///< that were measured
  std::uint64_t confidence = 0; ///< sum over the frames of their cells' mean confidence, millionths
};

/// Appears under its name when it is whole and on the disk. Throws TrackFileError.
class ChunkWriter {
public:
  /// `mark` names film, settings and spans.
  ChunkWriter(std::string path, std::string mark);
  void add(const CodedField &field);
  void finish(const ChunkStats &stats);

private:
  std::string path_;
  std::string mark_;
  PartFile part_;
  ContentHash hash_;
};

class ChunkReader {
public:
  ChunkReader(const std::string &path, const std::string &mark);
  /// Returns what is wrong with it, a sentence of messages.hpp for its path and number; null: it is
  /// whole, and of this film, version and settings.
  const char *problem() const noexcept { return problem_; }
  const ChunkStats &stats() const noexcept { return stats_; }
  /// All fields, as sets of KLV. They stay valid while this object exists.
  std::span<const std::uint8_t> fields() const noexcept;
  /// Takes what was read out of the memory of this process. It is read again when it is needed.
  void forget() const noexcept;

private:
  std::unique_ptr<GMappedFile, decltype(&g_mapped_file_unref)> file_{nullptr, g_mapped_file_unref};
  std::size_t size_ = 0; // bytes of the fields
  const char *problem_ = messages::kChunkIsMissing;
  ChunkStats stats_;
};

} // namespace haptic
