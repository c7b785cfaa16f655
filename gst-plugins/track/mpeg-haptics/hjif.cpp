// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes .hjif: ISO/IEC 23090-31:2025, clause 6.2 (HJIF specifications).
#include "mpeg-haptics/hjif.hpp"

#include "core/track-time.hpp"
#include "mpeg-haptics/force-curve.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace haptic {
namespace {

// Ticks. Positions have 16 bits in .hmpg, and an effect of .hjif must fit there.
constexpr std::int64_t kLongestEffect = 8 * std::int64_t{kTrackTimescale};

std::string number_text(double value) {
  char digits[32];
  // Four decimals are finer than the 8 bits of the binary form.
  const auto end =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, 4);
  return {digits, end.ptr};
}

// Felt samples without a pause between them, for no longer than an effect may last.
struct Stretch {
  std::int64_t begin = 0;
  std::vector<ForcePoint> points;
};

// The force holds until the last sample is over.
void close(Stretch &stretch, std::int64_t end) {
  const ForcePoint last = stretch.points.back();
  if (end - 1 > last.tick)
    stretch.points.push_back({end - 1, last.force});
}

// The line goes on in another effect. Effects that share a tick add there.
Stretch split(Stretch &stretch) {
  const ForcePoint joint = stretch.points.back();
  const ForcePoint before = stretch.points[stretch.points.size() - 2];
  stretch.points.pop_back();
  if (const std::int64_t tick = joint.tick - 1; tick > before.tick) {
    const double part =
        static_cast<double>(tick - before.tick) / static_cast<double>(joint.tick - before.tick);
    stretch.points.push_back({tick,
                              {std::lerp(before.force.x, joint.force.x, part),
                               std::lerp(before.force.y, joint.force.y, part)}});
  }
  return {joint.tick, {joint}};
}

std::vector<Stretch> stretches_of(std::span<const TrackSample> samples) {
  std::vector<Stretch> stretches;
  bool open = false;
  std::int64_t end = 0; // of the sample before, ticks
  for (const auto &sample : samples) {
    const std::int64_t tick = sample.time == kNoTime ? 0 : ticks_of(sample.time, kTrackTimescale);
    const bool felt = sample.time != kNoTime && is_felt(sample.motion);
    if (open) {
      const auto since = tick - stretches.back().points.back().tick;
      if (felt && since == 0)
        continue;
      open = felt && since > 0 && since <= kLongestHold;
      if (!open)
        close(stretches.back(), sample.time != kNoTime && since > 0 ? std::min(end, tick) : end);
      else if (tick - stretches.back().begin > kLongestEffect)
        stretches.push_back(split(stretches.back()));
    }
    if (!felt)
      continue;
    if (!open)
      stretches.push_back({tick, {}});
    stretches.back().points.push_back({tick, force_of_motion(sample.motion)});
    open = true;
    end = tick + ticks_held(sample.duration);
  }
  if (open)
    close(stretches.back(), end);
  return stretches;
}

std::string channel_text(std::span<const Stretch> stretches, int id) {
  const bool right = id == 0;
  std::string text = R"({"id":)" + std::to_string(id) + R"(,"description":")" +
                     (right ? "to the right" : "up") +
                     R"(","gain":1.0,"mixing_coefficient":1.0,"body_part_mask":0,)"
                     R"("direction":)" +
                     (right ? R"({"X":127,"Y":0,"Z":0})" : R"({"X":0,"Y":127,"Z":0})") +
                     R"(,"vertices":[],"bands":[{"band_type":"Curve","curve_type":)"
                     R"("Linear","lower_frequency_limit":0,"upper_frequency_limit":1000,)"
                     R"("effects":[)";
  int effect = id;
  for (const auto &stretch : stretches) {
    text += std::string(effect == id ? "" : ",") +
            "\n"
            R"({"id":)" +
            std::to_string(effect) + R"(,"effect_type":"Basis","position":)" +
            std::to_string(stretch.begin) + R"(,"keyframes":[)";
    effect += 2;
    const char *between = "";
    for (const auto &point : stretch.points) {
      text += std::string(between) + R"({"relative_position":)" +
              std::to_string(point.tick - stretch.begin) + R"(,"amplitude_modulation":)" +
              number_text(right ? point.force.x : point.force.y) + "}";
      between = ",";
    }
    text += "]}";
  }
  return text + "]}]}";
}

} // namespace

std::string write_hjif(std::span<const TrackSample> samples, const std::string &date) {
  const auto stretches = stretches_of(samples);
  return R"({"version":"2023","profile":"Main","level":1,"date":")" + date +
         R"(","description":"Motion under a pointer in a picture, as a force","timescale":)" +
         std::to_string(kTrackTimescale) +
         R"(,"avatars":[],"perceptions":[{"id":0,"avatar_id":0,"description":"Force along )"
         R"(the motion","perception_modality":"Force","unit_exponent":-3,)"
         R"("perception_unit_exponent":0,"effect_library":[],"reference_devices":[],)"
         R"("channels":[)"
         "\n" +
         channel_text(stretches, 0) + ",\n" + channel_text(stretches, 1) +
         R"(]}],"syncs":[{"timestamp":0}]})"
         "\n";
}

} // namespace haptic
