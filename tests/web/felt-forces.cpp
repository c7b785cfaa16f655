// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes tracks, a moving hand, and the force that hapticsink commands on each millisecond, for
// force-test.mjs. Numbers are little-endian doubles. A track is the number of packets; each packet
// with its time in s, its size and its bytes; the number of ticks; each tick with the hand's x, y
// and z, whether it presses, and the force's x and y.
#include "field-code/field-codec.hpp"
#include "force/force-law.hpp"
#include "forms/klv.hpp"
#include "leaf-fields.hpp"
#include "motion/motion-interpolator.hpp"
#include "motion/sample-intake.hpp"
#include "safety/safety-chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

namespace {

constexpr std::int64_t kTick = 1'000'000; // ns
constexpr std::int64_t kFrame = test::LeafFields::kInterval;
constexpr int kFrames = 240;
constexpr unsigned kHeldTrack = 4; // with a thing, which the hand holds again and again

struct Packet {
  haptic::CodedField coded;
  std::int64_t time; // ns
};

void put(double number) {
  std::fwrite(&number, sizeof number, 1, stdout);
}

haptic::MotionField still(haptic::MotionField field) {
  for (auto &cell : field.cells)
    cell.velocity_x = cell.velocity_y = 0;
  return field;
}

// One that swings, is hidden for a third of a second, and ends.
std::vector<haptic::FieldThing> things_at(int frame) {
  if (frame > 140)
    return {};
  const auto x = static_cast<float>(0.5 + 0.1 * std::sin(0.1 * frame));
  return {{7, frame > 70 && frame < 80 ? haptic::HoldState::hidden : haptic::HoldState::held, x,
           0.5F, 0.5F}};
}

// Leaves, with a second at rest, a cut, and single losses now and then.
std::vector<Packet> track(unsigned seed) {
  test::LeafFields leaves(seed, 0.9, seed == kHeldTrack ? 40.0 : 20.0 * seed);
  haptic::FieldEncoder encoder;
  std::vector<Packet> packets;
  for (int frame = 0; frame < kFrames; ++frame) {
    haptic::MotionField field = leaves.next();
    if (frame > 100 && frame < 130)
      field = still(field);
    if (frame == 160)
      field.flags = haptic::kMotionCut;
    const auto things = seed == kHeldTrack ? things_at(frame) : std::vector<haptic::FieldThing>{};
    const auto coded = encoder.push(field, !things.empty());
    const bool lost = frame % 37 == 36 || (seed == 2 && frame > 200 && frame < 212);
    if (!coded || lost)
      continue;
    Packet packet{{*coded, static_cast<std::uint64_t>(frame * kFrame)}, frame * kFrame};
    packet.coded.things.resize(haptic::packed_size(things));
    haptic::pack_field_things(things, packet.coded.things);
    packets.push_back(std::move(packet));
  }
  return packets;
}

haptic::PointerPosition hand_at(double time, unsigned seed) {
  haptic::PointerPosition place;
  place.x = 0.5 + 0.45 * std::sin(1.3 * time);
  place.y = 0.5 + 0.5 * std::cos(0.7 * time);
  place.z = -0.5 * std::sin(0.4 * time);
  place.pressed = seed == kHeldTrack && std::fmod(time, 2.7) > 0.5;
  return place;
}

// As hapticsink with its defaults and a hand that no speed is measured of.
class Sink {
public:
  Sink() { intake_.set_layout(true); }

  // Gives it the fields that come by now: one and a half frames early.
  void receive(const std::vector<Packet> &packets, std::int64_t now) {
    for (; next_ < packets.size() && packets[next_].time - 3 * kFrame / 2 <= now; ++next_) {
      const Packet &packet = packets[next_];
      if (decoder_.push(packet.coded.bytes) != haptic::FieldDecoder::Result::field)
        continue;
      if (decoder_.rested())
        add(decoder_.rest(), packet.time - kFrame, now);
      unpack_field_things(packet.coded.things, things_);
      add(decoder_.field(), packet.time, now);
    }
  }
  spidar::Vector3 tick(std::int64_t now, const haptic::PointerPosition &place) {
    const haptic::MotionAt &motion = interpolator_.at(now, place);
    const haptic::LawSettings settings;
    haptic::SafetyChain::Input input;
    const auto &conditioned =
        conditioner_.step(haptic::scale_motion(motion.sample, haptic::kReferenceWidth), 0, 1e-3);
    input.wanted = law_->wrench(conditioned, {}, settings, 1e-3);
    input.measured = motion.measured;
    input.trust = haptic::confidence_gate(motion.sample.confidence);
    input.age = motion.age;
    input.interval = motion.interval;
    if (motion.cut)
      input.holds = haptic::kHoldCut;
    input.max_force = settings.max_force;
    input.slew_rate = 20;
    input.dt = 1e-3;
    return chain_.step(input).force;
  }

private:
  void add(haptic::MotionField field, std::int64_t time, std::int64_t now) {
    field.things = things_;
    std::vector<std::uint8_t> bytes(packed_size(field));
    pack_motion_field(field, bytes);
    const bool gap =
        field.things.empty() &&
        std::ranges::none_of(field.cells, [](const auto &cell) { return cell.confidence > 0; });
    auto result = intake_.accept(bytes, gap, {time, {}, haptic::RateLaw::as_seen});
    if (result.motion)
      interpolator_.add(std::move(*result.motion), now);
  }
  std::unique_ptr<haptic::FieldPool> pool_ = std::make_unique<haptic::FieldPool>();
  haptic::SampleIntake intake_{*pool_};
  haptic::FieldDecoder decoder_;
  std::vector<haptic::FieldThing> things_; // of the last packet
  haptic::MotionInterpolator interpolator_;
  haptic::MotionConditioner conditioner_;
  std::unique_ptr<haptic::ForceLaw> law_ = haptic::force_laws()[0].make();
  haptic::SafetyChain chain_{spidar::DeviceLimits{}}; // no hand
  std::size_t next_ = 0;
};

void put_track(unsigned seed) {
  const auto packets = track(seed);
  put(static_cast<double>(packets.size()));
  for (const Packet &packet : packets) {
    const auto bytes = write_klv(packet.coded);
    put(static_cast<double>(packet.time) * 1e-9);
    put(static_cast<double>(bytes.size()));
    std::fwrite(bytes.data(), 1, bytes.size(), stdout);
  }
  Sink sink;
  constexpr int kTicks = kFrames * kFrame / kTick;
  // The first fields come before the first frame, as all others do.
  for (int tick = -2 * kFrame / kTick; tick < 0; ++tick)
    sink.receive(packets, tick * kTick);
  put(kTicks);
  for (int tick = 0; tick < kTicks; ++tick) {
    const auto place = hand_at(tick * 1e-3, seed);
    sink.receive(packets, tick * kTick);
    const auto force = sink.tick(tick * kTick, place);
    for (const double number :
         {place.x, place.y, place.z, place.pressed ? 1.0 : 0.0, force.x(), force.y()})
      put(number);
  }
}

} // namespace

int main() {
  for (unsigned seed = 1; seed <= kHeldTrack; ++seed)
    put_track(seed);
}
