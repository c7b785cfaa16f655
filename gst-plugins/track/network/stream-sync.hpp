// SPDX-License-Identifier: LGPL-2.1-or-later
// One time line for the RTP streams of a sender.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>

namespace haptic {

/// For how long the shortest way of a stream is remembered, ns: at least so long, at most twice. A
/// jitter buffer that a late packet has reset is back within 2 s.
inline constexpr std::int64_t kWayMemory = 3'000'000'000;
/// A way is longer from now on when all packets of so much of the sender's time came too late, ns.
inline constexpr std::int64_t kLateFor = 500'000'000;
/// A packet is not moved further, ns: the clocks of such streams have nothing in common.
inline constexpr std::int64_t kMostApart = 3'000'000'000;

/// What a sender says about one of its streams: at `rtp` its wall clock showed `wall`.
struct SenderReport {
  std::string sender;     ///< CNAME, the same for all streams of a sender
  std::uint32_t ssrc = 0; ///< of the stream
  std::uint32_t rtp = 0;  ///< 1/clock rate
  std::int64_t wall = 0;  ///< ns
};

/// A packet that comes out of the jitter buffer of its stream.
struct TimedPacket {
  std::uint32_t ssrc = 0;
  std::uint32_t rtp = 0;       ///< 1/clock rate
  std::int32_t clock_rate = 0; ///< Hz
  std::int64_t time = 0;       ///< when it is to be played by the jitter buffer, ns
  std::int64_t earliest = 0;   ///< when it can be played at the earliest, since it came, ns
};

/// Gives packets of the same instant the same time, whatever the jitter buffers do with each
/// stream. The time line is that of the stream with the longest way, so that no packet is late. A
/// jitter buffer that a stall has reset does not move it: as long as packets come in time, the
/// shortest way of the last seconds counts. Standard: RFC 3550, section 6.4.1. Not thread-safe.
class StreamSync {
public:
  /// A report about the stream of this session.
  void report(unsigned session, SenderReport report) {
    Stream &stream = streams_[session];
    const SenderReport &before = stream.report;
    if (before.ssrc != report.ssrc || before.sender != report.sender)
      stream = {};
    else if (stream.has_way)
      stream.move(wall_at(stream, report.rtp) - report.wall);
    stream.report = std::move(report);
  }

  /// When the packet is to be played, ns: as the jitter buffer says, until its stream and another
  /// one of the same sender have been reported about.
  std::int64_t time_of(unsigned session, const TimedPacket &packet) {
    const auto found = streams_.find(session);
    if (found == streams_.end() || found->second.report.ssrc != packet.ssrc ||
        packet.clock_rate <= 0)
      return packet.time;
    Stream &stream = found->second;
    stream.clock_rate = packet.clock_rate;
    const std::int64_t wall = wall_at(stream, packet.rtp);
    stream.add(packet.time - wall, packet.time);
    auto [way, has_other] = longest_way(stream);
    if (packet.earliest <= wall + way) {
      stream.in_time = wall;
    } else if (wall - stream.in_time >= kLateFor) {
      stream.forget(packet.time - wall);
      way = longest_way(stream).first;
    }
    const std::int64_t time = wall + way;
    return has_other && std::abs(time - packet.time) <= kMostApart ? std::max<std::int64_t>(time, 0)
                                                                   : packet.time;
  }

private:
  // The way is from the sender's wall clock to the time to play; it has the offset of the clocks in
  // it.
  struct Stream {
    SenderReport report;
    std::int32_t clock_rate = 0;      // of the last packet
    std::int64_t before = 0;          // the shortest way of the interval before
    std::int64_t now = 0;             // and of this one
    std::int64_t since = 0, last = 0; // its first packet, and the last one
    std::int64_t in_time = 0;         // the wall clock of the last packet that was
    bool has_way = false;

    void add(std::int64_t way, std::int64_t time) {
      if (!is_current(time)) {
        forget(way);
        since = time;
      } else if (time >= since + kWayMemory) {
        before = std::exchange(now, way);
        since = time;
      } else {
        now = std::min(now, way);
      }
      has_way = true;
      last = time;
    }
    void forget(std::int64_t way) { before = now = way; }
    // The sender's wall clock was set back by this.
    void move(std::int64_t distance) {
      before += distance;
      now += distance;
      in_time -= distance;
    }
    std::int64_t shortest() const { return std::min(before, now); }
    bool is_current(std::int64_t time) const {
      return has_way && std::abs(time - last) < kWayMemory;
    }
  };

  static std::int64_t wall_at(const Stream &stream, std::uint32_t rtp) {
    const auto ticks = static_cast<std::int32_t>(rtp - stream.report.rtp); // may wrap around
    return stream.report.wall + ticks * std::int64_t{1'000'000'000} / stream.clock_rate;
  }

  // Of this stream and those of the same sender, and whether there are any.
  std::pair<std::int64_t, bool> longest_way(const Stream &stream) const {
    std::pair<std::int64_t, bool> longest{stream.shortest(), false};
    for (const auto &[number, other] : streams_)
      if (&other != &stream && other.report.sender == stream.report.sender &&
          other.is_current(stream.last))
        longest = {std::max(longest.first, other.shortest()), true};
    return longest;
  }

  std::map<unsigned, Stream> streams_; // by session
};

} // namespace haptic
