// SPDX-License-Identifier: LGPL-2.1-or-later
// A film as a file: H.264 with a track of motion fields beside it.
#pragma once

#include "glue/gst-raii.hpp"
#include "samples/motion-field.hpp"

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace film {

/// The text contains the cure.
class FilmError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// x264's constant rate factor: the leaves of the film keep their edges.
inline constexpr int kUsualQuality = 23;

class FilmFile {
public:
  /// The ending of the path chooses the container: .ts (the track is KLV) or .mkv (text).
  /// `quality`: 0 (without loss) to 51. Throws FilmError.
  FilmFile(const std::string &path, int width, int height, int rate, int quality);
  ~FilmFile();
  FilmFile(const FilmFile &) = delete;
  FilmFile &operator=(const FilmFile &) = delete;

  /// The next frame (I420) and its motion. Waits while the encoder is behind. Throws FilmError,
  /// also after SIGINT and SIGTERM.
  void write(std::span<const std::uint8_t> frame, const haptic::MotionField &field);

  /// Completes the file, which appears now. Throws FilmError.
  void finish();

private:
  void push(GstElement *source, haptic::BufferPtr buffer);
  void throw_error();

  haptic::ElementPtr pipeline_;
  haptic::ElementPtr film_;
  haptic::ElementPtr track_;
  haptic::BusPtr bus_;
  const std::string path_;
  const std::string part_; // until it is complete
  int rate_;
  std::uint64_t count_ = 0;
};

} // namespace film
