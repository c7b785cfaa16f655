// SPDX-License-Identifier: LGPL-2.1-or-later
// The form haptics/x-raw (docs/formats/motion-sample.md, docs/formats/motion-field.md)
// and haptics/x-field (docs/formats/relief-field.md).
#include "field-code/field-codec.hpp"
#include "forms/track-form.hpp"
#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace haptic {
namespace {

constexpr std::uint64_t kMicrosecond = 1000; // ns

TrackItem damage(const char *details) {
  return TrackProblem{TrackProblemKind::damaged, details};
}

// How motion fields and reliefs are packed, in the same words.
struct Motion {
  static constexpr FieldKind kKind = FieldKind::motion;
  static constexpr char kUnreadable[] = "a motion field that does not say what it is";
  static constexpr char kContradiction[] = "a motion field that contradicts itself";
  static constexpr auto unpack = unpack_motion_field;
  static constexpr auto pack = pack_motion_field;
  static bool is_known(const FieldCell &cell) { return cell.confidence > 0; }
  static std::vector<std::uint8_t> things_of(const MotionField &field) {
    std::vector<std::uint8_t> bytes(packed_size(field.things));
    pack_field_things(field.things, bytes);
    return bytes;
  }
};

struct Relief {
  static constexpr FieldKind kKind = FieldKind::relief;
  static constexpr char kUnreadable[] = "a relief that does not say what it is";
  static constexpr char kContradiction[] = "a relief that contradicts itself";
  static constexpr auto unpack = unpack_relief_field;
  static constexpr auto pack = pack_relief_field;
  static bool is_known(const ReliefCell &cell) { return cell.validity > 0; }
  static std::vector<std::uint8_t> things_of(const ReliefField &) { return {}; }
};

// Fields of one kind. `Kind` is Motion or Relief.
template <typename Kind, typename Cells>
class FieldForm {
public:
  void read(const InputPacket &packet, std::vector<TrackItem> &items) {
    if (!Kind::unpack(packet.bytes, field_)) {
      if (!packet.gap)
        items.push_back(damage(Kind::kUnreadable));
      return;
    }
    if (packet.gap)
      std::ranges::fill(field_.cells, typename decltype(field_.cells)::value_type{});
    if (packet.discontinuous)
      encoder_.restart();
    auto things = packet.gap ? std::vector<std::uint8_t>{} : Kind::things_of(field_);
    auto bytes = encoder_.push(field_, things != things_);
    if (!bytes) {
      items.emplace_back(TimedRest{packet.time, packet.duration});
      return;
    }
    TimedField item;
    item.field.bytes = std::move(*bytes);
    item.field.kind = Kind::kKind;
    item.field.things = things_ = std::move(things);
    item.time = packet.time;
    item.duration = packet.duration;
    // The code holds the interval to the microsecond. Another duration is sent beside it.
    const auto difference = static_cast<std::int64_t>(packet.duration - field_.interval);
    if (std::abs(difference) > static_cast<std::int64_t>(kMicrosecond))
      item.field.duration = packet.duration;
    items.emplace_back(std::move(item));
  }

  bool write(const TimedField &item, TrackOutput &output) {
    using Result = typename GridDecoder<Cells>::Result;
    const Result result = decoder_.push(item.field.bytes);
    if (decoder_.lost())
      output.problems.push_back({TrackProblemKind::missing, "a sequence number is missing"});
    if (result == Result::damaged)
      output.problems.push_back({TrackProblemKind::damaged, Kind::kContradiction});
    if (result != Result::field) // what follows passes over it, as over a sample that was lost
      return false;
    const std::uint64_t interval = decoder_.field().interval;
    if (decoder_.rested() && item.time != kNoTime && item.time >= interval)
      output.packets.push_back(packed(decoder_.rest(), item.time - interval, interval));
    things_ = item.field.things;
    const bool lasts_for_interval = item.field.duration == kNoTime && interval > 0;
    output.packets.push_back(
        packed(decoder_.field(), item.time, lasts_for_interval ? interval : item.field.duration));
    return true;
  }

  void restart() {
    encoder_.restart();
    decoder_.forget();
    things_.clear();
  }

private:
  using Field = typename Cells::Field;

  // With the things of the coded field that was read last.
  OutputPacket packed(const Field &field, std::uint64_t time, std::uint64_t duration) const {
    OutputPacket packet{std::vector<std::uint8_t>(packed_size(field)), time, duration};
    Kind::pack(field, packet.bytes);
    packet.bytes.insert(packet.bytes.end(), things_.begin(), things_.end());
    packet.gap = things_.empty() && std::ranges::none_of(field.cells, Kind::is_known);
    return packet;
  }

  GridEncoder<Cells> encoder_;
  GridDecoder<Cells> decoder_;
  Field field_;                      // that was read last; kept for its memory
  std::vector<std::uint8_t> things_; // packed, of the field that was read last
};

class RawForm final : public TrackForm {
public:
  explicit RawForm(TrackLayout layout) : layout_(layout) {}

  bool carries_time() const noexcept override { return false; }

  void read(const InputPacket &packet, std::vector<TrackItem> &items) override {
    if (layout_ == TrackLayout::field)
      fields_.read(packet, items);
    else if (layout_ == TrackLayout::relief)
      reliefs_.read(packet, items);
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
    return item.field.kind == FieldKind::relief ? reliefs_.write(item, output)
                                                : fields_.write(item, output);
  }

  void restart() override {
    fields_.restart();
    reliefs_.restart();
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

  TrackLayout layout_; // of what is read
  FieldForm<Motion, MotionCells> fields_;
  FieldForm<Relief, ReliefCells> reliefs_;
};

} // namespace

std::unique_ptr<TrackForm> make_raw_form(TrackLayout layout) {
  return std::make_unique<RawForm>(layout);
}

} // namespace haptic
