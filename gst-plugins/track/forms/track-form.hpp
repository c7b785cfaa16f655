// SPDX-License-Identifier: LGPL-2.1-or-later
// The forms that a haptic track has on its way: packets to samples and fields, and back.
#pragma once

#include "core/track-sample.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace haptic {

/// What the samples of a track are of.
enum class TrackLayout { point, field, relief };

constexpr TrackLayout layout_of(FieldKind kind) noexcept {
  return kind == FieldKind::relief ? TrackLayout::relief : TrackLayout::field;
}

/// One buffer that comes, without GStreamer.
struct InputPacket {
  std::span<const std::uint8_t> bytes;
  std::uint64_t time = kNoTime;     ///< ns, time stamp of the buffer
  std::uint64_t duration = kNoTime; ///< ns
  bool gap = false;                 ///< the buffer has no content that counts
  bool discontinuous = false;       ///< something before it was lost
};

/// One buffer to be sent.
struct OutputPacket {
  std::vector<std::uint8_t> bytes;
  std::uint64_t time = kNoTime;
  std::uint64_t duration = kNoTime;
  bool gap = false;    ///< nothing was measured
  bool delta = false;  ///< cannot be read without those before
  bool header = false; ///< needed to read those behind
};

/// What can be wrong with a stream.
enum class TrackProblemKind {
  damaged,
  foreign_klv,
  foreign_text,
  other_version,
  other_kind,
  unsupported,  ///< MPEG haptics that gives no force here
  missing,      ///< a field before this one was lost
  without_time, ///< the buffer has no time stamp; the sample's own time gave it one
  untied        ///< it has none, and no buffer before it had one
};

struct TrackProblem {
  TrackProblemKind kind = TrackProblemKind::damaged;
  std::string details; ///< for developers
};

/// A sample of one point and the time stamp of its buffer, if this is the sample's.
struct TimedSample {
  TrackSample sample;
  std::uint64_t time = kNoTime; ///< ns
};

/// The same of a coded field.
struct TimedField {
  CodedField field;
  std::uint64_t time = kNoTime;     ///< ns
  std::uint64_t duration = kNoTime; ///< ns, of the buffer
};

/// A field that needs not be sent, since the whole frame rests as before.
struct TimedRest {
  std::uint64_t time = kNoTime;
  std::uint64_t duration = kNoTime;
};

using TrackItem = std::variant<TimedSample, TimedField, TimedRest, TrackProblem>;

/// What a form makes of the items that are written into it.
struct TrackOutput {
  std::vector<OutputPacket> packets;
  std::vector<TrackProblem> problems;
};

/// One form in both directions. An object serves one direction of one stream.
class TrackForm {
public:
  virtual ~TrackForm() = default;

  /// Appends what the packet holds, in its order.
  virtual void read(const InputPacket &packet, std::vector<TrackItem> &items) = 0;
  /// Appends what was held back: nothing continues the packets before.
  virtual void finish_reading(std::vector<TrackItem> &) {}
  /// The packets of a live source must not be held back for long.
  virtual void set_live(bool) {}
  /// Whether the samples of this form carry the sender's time. Otherwise that of the buffer is it.
  virtual bool carries_time() const noexcept = 0;

  /// Appends the packets of a sample, or none yet.
  virtual void write(const TimedSample &sample, TrackOutput &output) = 0;
  /// The same of a field. Returns false if it says nothing without one that was lost.
  virtual bool write(const TimedField &field, TrackOutput &output) = 0;
  /// Appends what is held back. The stream ends, or something else follows.
  virtual void finish(TrackOutput &) {}

  /// Another part of the stream follows, from elsewhere in it.
  virtual void restart() {}
};

/// Packed samples, fields or reliefs: haptics/x-raw, haptics/x-field.
std::unique_ptr<TrackForm> make_raw_form(TrackLayout layout);
/// Local sets of SMPTE ST 336: meta/x-klv.
std::unique_ptr<TrackForm> make_klv_form();
/// Lines of text: text/x-raw.
std::unique_ptr<TrackForm> make_text_form();

} // namespace haptic
