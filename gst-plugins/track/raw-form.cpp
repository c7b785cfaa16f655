// SPDX-License-Identifier: LGPL-2.1-or-later
// The form haptics/x-raw (docs/formats/motion-sample.md, docs/formats/motion-field.md).
#include "field-codec.hpp"
#include "motion-field.hpp"
#include "track-form.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace haptic {
namespace {

constexpr std::uint64_t kMicrosecond = 1000; // ns

TrackItem damage(const char *details) {
  return TrackProblem{TrackProblemKind::damaged, details};
}

class RawForm final : public TrackForm {
public:
  explicit RawForm(TrackLayout layout) : layout_(layout) {}

  bool carries_time() const noexcept override { return false; }

  void read(const InputPacket &packet, std::vector<TrackItem> &items) override {
    if (layout_ == TrackLayout::field)
      read_field(packet, items);
    else
      read_sample(packet, items);
  }

  void write(const TimedSample &item, TrackOutput &output) override {
    const auto bytes = pack_motion_sample(item.sample.motion);
    OutputPacket packet{{bytes.begin(), bytes.end()}, item.time, item.sample.duration};
    packet.gap = !(item.sample.motion.confidence > 0);
    output.packets.push_back(std::move(packet));
  }

  bool write(const TimedField &item, TrackOutput &output) override {
    using Result = FieldDecoder::Result;
    const Result result = decoder_.push(item.field.bytes);
    if (result == Result::missing)
      output.problems.push_back({TrackProblemKind::missing, "a sequence number is missing"});
    if (result == Result::damaged)
      output.problems.push_back(
          {TrackProblemKind::damaged, "a motion field that contradicts itself"});
    if (!decoder_.has_field())
      return false;
    const std::uint64_t interval = decoder_.field().interval;
    if (decoder_.rested() && item.time != kNoTime && item.time >= interval)
      output.packets.push_back(packed(decoder_.rest(), item.time - interval, interval));
    const bool lasts_for_interval = item.field.duration == kNoTime && interval > 0;
    output.packets.push_back(
        packed(decoder_.field(), item.time, lasts_for_interval ? interval : item.field.duration));
    return true;
  }

  void restart() override {
    encoder_.restart();
    decoder_.forget();
  }

private:
  static void read_sample(const InputPacket &packet, std::vector<TrackItem> &items) {
    const auto motion = unpack_motion_sample(packet.bytes);
    if (!motion) {
      if (!packet.gap)
        items.push_back(damage("a motion sample that does not say what it is"));
      return;
    }
    TimedSample item;
    item.sample.motion = *motion;
    if (packet.gap)
      item.sample.motion.confidence = 0;
    item.sample.duration = packet.duration;
    item.time = packet.time;
    items.emplace_back(item);
  }

  void read_field(const InputPacket &packet, std::vector<TrackItem> &items) {
    if (!unpack_motion_field(packet.bytes, field_)) {
      if (!packet.gap)
        items.push_back(damage("a motion field that does not say what it is"));
      return;
    }
    if (packet.gap)
      std::ranges::fill(field_.cells, FieldCell{});
    if (packet.discontinuous)
      encoder_.restart();
    auto bytes = encoder_.push(field_);
    if (!bytes) {
      items.emplace_back(TimedRest{packet.time, packet.duration});
      return;
    }
    TimedField item;
    item.field.bytes = std::move(*bytes);
    item.time = packet.time;
    item.duration = packet.duration;
    // The code holds the interval to the microsecond. Another duration is sent beside it.
    const auto difference = static_cast<std::int64_t>(packet.duration - field_.interval);
    if (std::abs(difference) > static_cast<std::int64_t>(kMicrosecond))
      item.field.duration = packet.duration;
    items.emplace_back(std::move(item));
  }

  static OutputPacket packed(const MotionField &field, std::uint64_t time, std::uint64_t duration) {
    OutputPacket packet{std::vector<std::uint8_t>(packed_size(field)), time, duration};
    pack_motion_field(field, packet.bytes);
    packet.gap =
        std::ranges::none_of(field.cells, [](const auto &cell) { return cell.confidence > 0; });
    return packet;
  }

  TrackLayout layout_; // of what is read
  FieldEncoder encoder_;
  FieldDecoder decoder_;
  MotionField field_; // that was read last; kept for its memory
};

} // namespace

std::unique_ptr<TrackForm> make_raw_form(TrackLayout layout) {
  return std::make_unique<RawForm>(layout);
}

} // namespace haptic
