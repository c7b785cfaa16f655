// SPDX-License-Identifier: LGPL-2.1-or-later
// Makes a track of the packets of one stream of a container: each sample gets its time.
#pragma once

#include "core/track-clock.hpp"
#include "forms/problem-counters.hpp"
#include "forms/track-form.hpp"
#include "tracks/track-file.hpp"

#include <memory>

namespace haptic {

/// Some packets have no time stamp: those that a cut left before the first clock of a transport
/// stream, and all that a remuxer took it from. The times of the sender lead from one sample with a
/// stamp to the others, those before it too.
class StreamTrack {
public:
  /// `track` gets samples, fields and remarks.
  StreamTrack(std::unique_ptr<TrackForm> form, TrackFile &track)
      : form_(std::move(form)), track_(track) {}

  /// The time of the packet is that of the stream, or kNoTime.
  void push(const InputPacket &packet);
  /// A stream without any time stamp begins at 0.
  void finish();

private:
  struct Untied {
    bool is_field;
    std::size_t index;
  };

  void report(const TrackProblem &problem);
  void place(bool is_field, std::uint64_t pts);
  void tie(std::uint64_t pts, std::uint64_t time, std::uint64_t duration);

  std::unique_ptr<TrackForm> form_;
  TrackFile &track_;
  TrackClock clock_;
  ProblemCounters problems_;
  std::vector<Untied> untied_; // samples whose time is still the sender's
};

} // namespace haptic
