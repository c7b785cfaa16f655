// SPDX-License-Identifier: LGPL-2.1-or-later
// Makes a track of packets: each sample gets its time, and what is wrong a remark.
#pragma once

#include "core/track-clock.hpp"
#include "forms/problem-counters.hpp"
#include "forms/track-form.hpp"
#include "tracks/track-file.hpp"

#include <memory>
#include <optional>

namespace haptic {

/// Packets of a file that is a track alone have no time stamps: its samples keep their own times,
/// and some of what is damaged is named.
///
/// Packets of a stream in a container have time stamps, which are the times. After a cut, packets
/// before the first clock of a transport stream have none, and some remuxers drop those of others.
/// The times of the sender then lead from a sample with a time stamp to the others, also to those
/// before it.
class TrackReader {
public:
  /// `track` gets samples, fields and remarks. `damaged`: what stands before the number of a
  /// damaged packet of a file; "" if the packet has no number; null: a stream.
  TrackReader(std::unique_ptr<TrackForm> form, TrackFile &track, const char *damaged = nullptr)
      : form_(std::move(form)), track_(track), damaged_(damaged) {}

  /// `at`: the number of the packet in its file, as the remark counts.
  void push(const InputPacket &packet, std::size_t at = 0);
  /// A stream without any time stamp begins at 0. `at`: where a file ends, as the remark counts.
  void finish(std::size_t at = 0);
  /// Of a stream alone in its container, which a demuxer begins at a time of its own: all times are
  /// those of the sender again.
  void take_times_of_sender() noexcept;
  /// Returns how many damaged packets or sets a file has so far.
  std::size_t damage() const noexcept { return damage_; }

private:
  void take(std::vector<TrackItem> &items, std::size_t at);
  void report(const TrackProblem &problem, std::size_t at);
  template <typename Timed>
  void place(Timed &one, std::uint64_t pts, std::vector<Timed> &all);

  std::unique_ptr<TrackForm> form_;
  TrackFile &track_;
  const char *damaged_; // of a file
  std::size_t damage_ = 0;
  std::size_t others_ = 0; // sets that are none of ours, in a file
  TrackClock clock_;
  std::optional<std::uint64_t> sender_ahead_; // ns, of the first time stamp
  ProblemCounters problems_;                  // of a stream
};

} // namespace haptic
