// SPDX-License-Identifier: LGPL-2.1-or-later
// Authors one video: makes a copy with the motion of its whole frame beside it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace haptic {

struct AuthorOptions {
  std::string folder;   ///< of the copy; empty: that of the video
  unsigned columns = 0; ///< of the motion field; 0: as motionfield has it
};

struct AuthorProgress {
  std::uint64_t frames = 0;
  double done = 0; ///< 0..1, 0 also where the length is not known
};

struct Authored {
  std::string path; ///< of the copy
  bool existed = false;
  std::uint64_t frames = 0;
  std::vector<std::string> remarks; ///< what of the video is not in the copy
};

/// Writes NAME.haptic.ts, or NAME.haptic.mkv where MPEG-TS has no place for the video. The copy
/// appears under its name only when it is whole and on the disk. A copy that exists stays as it is.
/// `report` is called some times a second. Throws TrackFileError. Initializes GStreamer and seeds
/// GLib's random numbers: call it in a process of its own.
Authored author_file(const std::string &path, const AuthorOptions &options,
                     const std::function<void(const AuthorProgress &)> &report);

/// Returns the name of the copy without its ending. Two videos may not have the same one.
std::string author_stem(const std::string &path, const AuthorOptions &options);

/// Returns the name of the file that author_file() writes before the copy is whole.
std::string author_part(const std::string &path, const AuthorOptions &options);

} // namespace haptic
