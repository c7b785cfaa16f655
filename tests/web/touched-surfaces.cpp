// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes a track of reliefs with the surface that hapticsink makes of it at many times and places,
// and the force on a finger that moves over one of them, for touch-test.mjs. Numbers are
// little-endian doubles: the number of packets; each packet with its time in s, its size and its
// bytes; the number of probes; each with time, x and y (m), 1 where there is a surface, height,
// stiffness and friction; the number of ticks of the finger; each with x and y, the proxy's x and
// y, and the force.
#include "depth-scene.hpp"
#include "device-limits.hpp"
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "touch/contact-law.hpp"
#include "touch/relief-intake.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <spidar/geometry.hpp>

namespace {

using spidar::Vector3;

constexpr std::int64_t kTick = 1'000'000; // ns
constexpr auto kFrame = static_cast<std::int64_t>(test::DepthScene::kInterval);
constexpr int kFrames = 120;
constexpr int kColumns = 32;
const Vector3 kHalf = spidar::Geometry{}.workspace_half;
// Of the finger, as in pipelines/web/player/contact.js.
constexpr double kDepth = 0.0025;
constexpr double kSteepest = 0.25;

void put(double number) {
  std::fwrite(&number, sizeof number, 1, stdout);
}

// Balls before a wall of another material, with a hole, and a cut.
haptic::ReliefField scene(int frame) {
  haptic::ReliefField relief = test::DepthScene::relief(frame, kColumns);
  for (std::size_t i = 0; i < relief.cells.size(); ++i) {
    haptic::ReliefCell &cell = relief.cells[i];
    if (i % kColumns < 6)
      cell = {};
    else if (cell.height < 0)
      cell = {cell.height, 60, 0.8F, 1};
  }
  relief.flags = frame == 70 ? haptic::kMotionCut : 0;
  return relief;
}

std::vector<haptic::CodedField> track() {
  haptic::ReliefEncoder encoder;
  std::vector<haptic::CodedField> packets;
  for (int frame = 0; frame < kFrames; ++frame) {
    auto bytes = encoder.push(scene(frame)).value();
    const bool lost = frame % 37 == 36 || (frame > 90 && frame < 96);
    if (!lost)
      packets.push_back({std::move(bytes), static_cast<std::uint64_t>(frame * kFrame),
                         haptic::kNoTime, haptic::FieldKind::relief});
  }
  return packets;
}

void put_track(const std::vector<haptic::CodedField> &packets) {
  put(static_cast<double>(packets.size()));
  for (const auto &packet : packets) {
    const auto bytes = write_klv(packet);
    put(static_cast<double>(packet.time) * 1e-9);
    put(static_cast<double>(bytes.size()));
    std::fwrite(bytes.data(), 1, bytes.size(), stdout);
  }
}

// As hapticsink: reliefs come one and a half frames early.
class Sink {
public:
  explicit Sink(const std::vector<haptic::CodedField> &packets) : packets_(packets) {}

  const haptic::ReliefAt &at(std::int64_t now) {
    for (; next_ < packets_.size(); ++next_) {
      const auto due = static_cast<std::int64_t>(packets_[next_].time);
      if (due - 3 * kFrame / 2 > now)
        break;
      if (decoder_.push(packets_[next_].bytes) != haptic::ReliefDecoder::Result::field)
        continue;
      std::vector<std::uint8_t> bytes(packed_size(decoder_.field()));
      pack_relief_field(decoder_.field(), bytes);
      timeline_.add(intake_.accept(bytes, false, due).relief.value(), now);
    }
    return timeline_.at(now);
  }

private:
  const std::vector<haptic::CodedField> &packets_;
  std::unique_ptr<haptic::ReliefPool> pool_ = std::make_unique<haptic::ReliefPool>();
  haptic::ReliefIntake intake_{*pool_};
  haptic::ReliefTimeline timeline_;
  haptic::ReliefDecoder decoder_;
  std::size_t next_ = 0;
};

// Where the finger is at a time in s, within `share` of the picture.
Vector3 place_at(double time, double share) {
  return {share * kHalf.x() * std::sin(2.1 * time), share * kHalf.y() * std::cos(1.3 * time + 0.5),
          0};
}

void put_probes(const std::vector<haptic::CodedField> &packets) {
  Sink sink(packets);
  constexpr int kProbes = kFrames * kFrame / kTick - 100;
  put(kProbes);
  for (int i = 0; i < kProbes; ++i) {
    const haptic::ReliefAt &at = sink.at(i * kTick);
    const Vector3 place = place_at(0.02 * i, 1);
    const haptic::SurfacePoint point =
        haptic::ReliefSurface(*at.from, *at.to, at.weight, kHalf).at(place.x(), place.y());
    for (const double number : {i * 1e-3, place.x(), place.y(), point.exists ? 1.0 : 0.0,
                                point.height, point.stiffness, point.friction})
      put(number);
  }
}

Vector3 shortened(const Vector3 &v, double most) {
  return v.norm() > most ? Vector3(v * (most / v.norm())) : v;
}

// Over the first relief, with a rest now and then: the force of the spring, within the limits of
// the safety chain. The page leaves the damper against the hand out.
void put_finger(const std::vector<haptic::CodedField> &packets) {
  haptic::ReliefDecoder decoder;
  decoder.push(packets.front().bytes);
  const haptic::ReliefSurface surface(decoder.field(), decoder.field(), 1, kHalf);
  const haptic::ContactLimits limits{.device = test::kSpidar};
  haptic::ContactLaw law;
  constexpr int kTicks = 6000;
  put(kTicks);
  double time = 0;
  Vector3 force = Vector3::Zero();
  for (int tick = 0; tick < kTicks; ++tick) {
    time += tick % 1000 < 700 ? 1e-3 : 0;
    Vector3 finger = place_at(time, 0.55);
    const haptic::SurfacePoint here = surface.at(finger.x(), finger.y());
    finger.z() =
        here.height - kDepth / std::max(surface.normal(finger.x(), finger.y()).z(), kSteepest);
    const haptic::Contact &contact = law.step(surface, finger, limits, 1e-3);
    // With the damper against the surface's own speed, 5 ticks of the spring: its work is k d rise.
    const double stiffness = std::min(surface.at(contact.proxy.x(), contact.proxy.y()).stiffness,
                                      haptic::stiffest(limits));
    const Vector3 spring = contact.proxy - finger;
    const double depth = std::max(spring.norm(), 1e-9);
    const double damper =
        5 * std::min(1 / 5e-4, 1 / depth) * contact.surface_work / (stiffness * depth);
    force += shortened(shortened((1 + damper) * stiffness * spring, 1) - force, 0.02);
    for (const double number : {finger.x(), finger.y(), contact.proxy.x(), contact.proxy.y(),
                                force.x(), force.y(), force.z()})
      put(number);
  }
}

} // namespace

int main() {
  const auto packets = track();
  put_track(packets);
  put_probes(packets);
  put_finger(packets);
}
