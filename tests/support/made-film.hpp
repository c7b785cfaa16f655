// SPDX-License-Identifier: LGPL-2.1-or-later
// Films whose frames hold no picture but the heads that a parser reads, so that a test chooses the
// time of each frame and where the key frames are.
#pragma once

#include "package/film-segments.hpp"
#include "package/fragment-writer.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <vector>

namespace test {

/// Of 64 x 48 px in the baseline profile; AAC-LC of 44.1 kHz, stereo.
inline haptic::FilmFormat film_format(bool has_sound) {
  haptic::FilmFormat format;
  format.width = 64;
  format.height = 48;
  format.sequence_sets = {{0x67, 0x42, 0xC0, 0x0A, 0xDA, 0x11, 0xE4}};
  format.picture_sets = {{0x68, 0xCE, 0x38, 0x80}};
  if (has_sound) {
    format.sound = {0x12, 0x10};
    format.sound_rate = 44100;
    format.sound_channels = 2;
  }
  return format;
}

/// A slice's head behind its length, and so many bytes of no meaning.
inline std::vector<std::uint8_t> film_frame(bool is_idr, std::size_t more = 0) {
  std::vector<std::uint8_t> frame =
      is_idr ? std::vector<std::uint8_t>{0, 0, 0, 0, 0x65, 0x88, 0x84, 0xC0}
             : std::vector<std::uint8_t>{0, 0, 0, 0, 0x41, 0x9A, 0x23};
  for (std::size_t i = 0; i < more; ++i)
    frame.push_back(static_cast<std::uint8_t>(i % 251 + 1));
  const std::size_t length = frame.size() - 4;
  for (std::size_t i = 0; i < 4; ++i)
    frame[i] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
  return frame;
}

struct FrameTime {
  std::int64_t presentation = 0; ///< ns
  bool is_idr = false;
};

/// Returns the frames, which are given in the order of decoding, as those of one segment. The last
/// one is as long as the one before it.
inline haptic::FilmSegment film_segment(const std::vector<FrameTime> &times) {
  std::vector<std::int64_t> turns;
  for (const FrameTime &time : times)
    turns.push_back(haptic::ticks_of(time.presentation));
  std::ranges::sort(turns);
  haptic::FilmSegment segment;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::size_t before = std::min(i, turns.size() - 2);
    segment.frames.push_back({haptic::ticks_of(times[i].presentation), turns[i],
                              turns[before + 1] - turns[before], times[i].is_idr,
                              film_frame(times[i].is_idr)});
  }
  return segment;
}

inline void write_film(const std::string &path, const std::vector<FrameTime> &times) {
  const haptic::FilmFormat format = film_format(false);
  haptic::FragmentWriter writer(format);
  std::ofstream file(path, std::ios::binary);
  for (const auto &bytes : {writer.head(), writer.write(film_segment(times))})
    file.write(reinterpret_cast<const char *>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

} // namespace test
