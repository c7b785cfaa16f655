// SPDX-License-Identifier: LGPL-2.1-or-later
// Segments of a film as MPEG-2 transport streams (ISO/IEC 13818-1) with the fields as KLV beside
// them, each with its time (SMPTE RP 217, asynchronous).
#pragma once

#include "package/film-segments.hpp"

#include <array>
#include <span>

namespace haptic {

/// Returns the frame with start codes, and with the parameter sets before an IDR frame (ITU-T
/// H.264, annex B).
std::vector<std::uint8_t> byte_stream_of(const FilmFormat &format, const SegmentFrame &frame);

class TransportStreamWriter {
public:
  /// `reordering` of the film, ns.
  TransportStreamWriter(const FilmFormat &format, std::int64_t reordering);

  /// Returns whole packets, first those of the tables. Segments must come in their order: their
  /// packets are counted on.
  std::vector<std::uint8_t> write(const FilmSegment &segment);

  /// Returns the bytes of the track so far, with all around it.
  std::size_t track_bytes() const noexcept { return fields_.packets * kPacket; }

private:
  static constexpr std::size_t kPacket = 188;
  using Bytes = std::span<const std::uint8_t>;
  struct Clock {                 ///< what stands in the first packet of a frame
    std::int64_t reference = -1; ///< ticks; none
    bool is_idr = false;
  };

  struct Stream {
    unsigned pid;
    unsigned id; ///< of its units
    std::size_t packets = 0;
  };

  void put_tables();
  void put_unit(Stream &stream, std::int64_t presentation, std::int64_t decoding,
                std::vector<std::uint8_t> payload, Clock clock);
  void put_packets(Stream &stream, Bytes unit, Clock clock);
  void put_framed(std::vector<std::uint8_t> &unit, Bytes sound) const;

  const FilmFormat &format_;
  std::int64_t reordering_; // ticks
  std::array<Stream, 2> tables_ = {{{0x0000, 0}, {0x1000, 0}}};
  Stream video_ = {0x100, 0xE0};
  Stream sound_ = {0x101, 0xC0};
  Stream fields_ = {0x102, 0xFC}; // metadata: with the id BD, ffmpeg drops the times
  std::vector<std::uint8_t> out_;
};

} // namespace haptic
