// SPDX-License-Identifier: LGPL-2.1-or-later
// The form meta/x-klv (docs/formats/klv.md).
#include "core/track-time.hpp"
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "forms/track-form.hpp"

#include <algorithm>
#include <utility>

namespace haptic {
namespace {

std::string details_of(const KlvItem &item) {
  return std::string(item.error) + " (byte " + std::to_string(item.offset) + ")";
}

TrackProblemKind problem_of(KlvKind kind) {
  switch (kind) {
  case KlvKind::foreign:
    return TrackProblemKind::foreign_klv;
  case KlvKind::other_version:
    return TrackProblemKind::other_version;
  case KlvKind::other_sample:
    return TrackProblemKind::other_kind;
  default:
    return TrackProblemKind::damaged;
  }
}

// The time stamps of the sets of one packet: the packet's time is that of its first sample.
class PacketTimes {
public:
  explicit PacketTimes(std::uint64_t packet_time) : packet_time_(packet_time) {}

  std::uint64_t of(const TrackSample &sample) {
    if (first_ == kNoTime) {
      first_ = sample.time;
      return packet_time_;
    }
    if (packet_time_ == kNoTime || sample.time == kNoTime || sample.time < first_)
      return packet_time_;
    return packet_time_ + std::min(sample.time - first_, kLargestTimeStep);
  }

private:
  std::uint64_t packet_time_;
  std::uint64_t first_ = kNoTime; // the sender's, of the first sample
};

class KlvForm final : public TrackForm {
public:
  bool carries_time() const noexcept override { return true; }

  void read(const InputPacket &packet, std::vector<TrackItem> &items) override {
    PacketTimes times(packet.time);
    KlvReader reader(packet.bytes);
    while (const auto item = reader.next()) {
      if (item->kind == KlvKind::motion)
        items.emplace_back(TimedSample{item->sample, times.of(item->sample)});
      else if (item->kind == KlvKind::field)
        items.emplace_back(
            TimedField{coded_field_of(*item), times.of(item->sample), packet.duration});
      else
        items.emplace_back(TrackProblem{problem_of(item->kind), details_of(*item)});
    }
  }

  void write(const TimedSample &item, TrackOutput &output) override {
    output.packets.push_back({write_klv(item.sample), item.time, item.sample.duration});
  }

  bool write(const TimedField &item, TrackOutput &output) override {
    output.packets.push_back({write_klv(item.field), item.time, item.duration});
    output.packets.back().delta = !is_key_field(item.field.bytes);
    return true;
  }
};

} // namespace

std::unique_ptr<TrackForm> make_klv_form() {
  return std::make_unique<KlvForm>();
}

} // namespace haptic
