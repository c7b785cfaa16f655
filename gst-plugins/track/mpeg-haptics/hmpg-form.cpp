// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/hmpg-form.hpp"

#include "mpeg-haptics/hmpg-track.hpp"

#include <optional>
#include <utility>

namespace haptic {
namespace {

class HmpgForm final : public TrackForm {
public:
  explicit HmpgForm(std::uint64_t unit_duration) : unit_duration_(unit_duration) {}

  bool carries_time() const noexcept override { return false; }

  void read(const InputPacket &packet, std::vector<TrackItem> &items) override {
    append(decoder_.push(packet.bytes, packet.time), items);
  }

  void finish_reading(std::vector<TrackItem> &items) override { append(decoder_.finish(), items); }
  void set_live(bool live) override { decoder_.set_live(live); }

  void write(const TimedSample &item, TrackOutput &output) override {
    if (item.time == kNoTime) {
      output.problems.push_back(
          {TrackProblemKind::damaged, "a sample without a time has no place in haptics/hmpg"});
      return;
    }
    if (!encoder_)
      encoder_.emplace(unit_duration_, today());
    append(encoder_->push(item.sample.motion, item.time, item.sample.duration), output);
  }

  // MPEG haptics holds one point.
  bool write(const TimedField &, TrackOutput &) override { return false; }

  void finish(TrackOutput &output) override {
    if (encoder_)
      append(encoder_->finish(), output);
  }

  void restart() override {
    encoder_.reset();
    decoder_.seek();
  }

private:
  static void append(HmpgDecoder::Result &&result, std::vector<TrackItem> &items) {
    if (!result.problem.empty())
      items.emplace_back(TrackProblem{TrackProblemKind::damaged, result.problem});
    if (!result.unsupported.empty())
      items.emplace_back(TrackProblem{TrackProblemKind::unsupported, result.unsupported});
    for (auto &sample : result.samples) {
      const std::uint64_t time = std::exchange(sample.time, kNoTime);
      items.emplace_back(TimedSample{sample, time});
    }
  }

  static void append(std::vector<CodedUnit> &&units, TrackOutput &output) {
    for (auto &unit : units) {
      output.packets.push_back({std::move(unit.bytes), unit.time, unit.duration});
      output.packets.back().header = unit.type == UnitType::initialization;
    }
  }

  std::uint64_t unit_duration_; // ns
  std::optional<HmpgEncoder> encoder_;
  HmpgDecoder decoder_;
};

} // namespace

std::unique_ptr<TrackForm> make_hmpg_form(std::uint64_t unit_duration) {
  return std::make_unique<HmpgForm>(unit_duration);
}

} // namespace haptic
