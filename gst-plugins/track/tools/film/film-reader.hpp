// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the coded frames of a film that a browser can play: H.264, and AAC if it has sound.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace haptic {

struct FilmFormat {
  std::string video_codec; ///< for a playlist or a browser (RFC 6381), as sound_codec
  std::string sound_codec;
  int width = 0; ///< px
  int height = 0;
  int pixel_aspect_n = 1;
  int pixel_aspect_d = 1;
  double frame_rate = 0;                                ///< 1/s, 0: not known
  std::vector<std::vector<std::uint8_t>> sequence_sets; ///< SPS, at least one of four bytes
  std::vector<std::vector<std::uint8_t>> picture_sets;  ///< PPS
  std::vector<std::uint8_t> sound;                      ///< AudioSpecificConfig; empty: no sound
  int sound_rate = 0;                                   ///< Hz
  int sound_channels = 0;
  std::vector<std::string> left_out; ///< caps of further streams
};

/// One frame of H.264 (NAL units behind a length of four bytes each, without parameter sets) or
/// AAC.
struct FilmFrame {
  bool is_sound = false;
  bool is_idr = false;   ///< of the video: what follows depends on nothing before
  std::int64_t time = 0; ///< ns of presentation in the stream
  std::vector<std::uint8_t> bytes;
};

/// Calls `call` for the frames of each stream in the order of decoding, one at a time, in any
/// thread. Returns the format. Throws TrackFileError if a browser cannot play the film or the
/// process was interrupted, also with the text of what `call` throws.
FilmFormat read_film(const std::string &path, const std::function<void(FilmFrame &&)> &call);

} // namespace haptic
