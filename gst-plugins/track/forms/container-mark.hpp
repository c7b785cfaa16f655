// SPDX-License-Identifier: LGPL-2.1-or-later
// Marks of a haptic track in the bytes of a container, for which GStreamer's muxers have no
// property.
#pragma once

#include <cstdint>
#include <span>

namespace haptic {

/// Gives the packets of the haptic track in a transport stream the PES stream id of metadata (FC)
/// in place of that of private data (BD). ffmpeg drops the time stamps of KLV with the id BD when
/// it copies a stream, and keeps those with FC. Does nothing unless the bytes are whole packets of
/// 188 bytes.
void keep_times_of_track(std::span<std::uint8_t> packets);

/// Sets FlagDefault of the first text track of a Matroska header to 0, so that no player shows the
/// haptic track as subtitles unasked, and names the track. The size stays: both take the place of
/// the name that matroskamux gives every track, or of the film's title. Returns whether the header
/// is over: the tracks were there, or the frames begin.
bool hide_text_track(std::span<std::uint8_t> header);

} // namespace haptic
