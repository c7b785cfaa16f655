// SPDX-License-Identifier: LGPL-2.1-or-later
// The list of the copies of a plan, as JSON and as a table (CSV, RFC 4180).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

struct ManifestRow {
  std::string video;
  std::string video_hash; ///< SHA-256
  std::string copy;
  std::string copy_hash;
  std::uint64_t size = 0;   ///< bytes, of the copy
  double duration = 0;      ///< s
  std::uint64_t frames = 0; ///< that were measured
  double kilobits = 0;      ///< a second, of the track as KLV
  double confidence = 0;    ///< 0..1, mean over cells and frames
  std::vector<std::string> warnings;

  template <typename Self, typename Call>
  static void members(Self &self, const Call &call) {
    call("video", self.video);
    call("video-sha256", self.video_hash);
    call("copy", self.copy);
    call("copy-sha256", self.copy_hash);
    call("bytes", self.size);
    call("seconds", self.duration);
    call("frames", self.frames);
    call("kbit/s", self.kilobits);
    call("confidence", self.confidence);
    call("warnings", self.warnings);
  }
};

/// Returns the rows of a manifest, or none if there is none that can be read.
std::vector<ManifestRow> read_manifest(const std::string &path);

/// Writes STEM.json and STEM.csv, which appear when they are whole. Throws TrackFileError.
void write_manifest(const std::string &stem, const std::vector<ManifestRow> &rows);

} // namespace haptic
