// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-sample.hpp"

#include "samples/motion-bytes.hpp"

namespace haptic {
namespace {

// False for a number that is not finite, too.
bool is_fraction(float value) {
  return value >= 0 && value <= 1;
}

bool is_valid(const HeldPlace &held) {
  return held.state <= HoldState::refused && is_fraction(held.x) && is_fraction(held.y) &&
         is_fraction(held.radius);
}

void write_held(LittleEndianWriter &out, const HeldPlace &held) {
  for (auto value : {held.x, held.y, held.radius})
    out.f32(value);
  out.u8(static_cast<std::uint8_t>(held.state));
  out.u8(0);
  out.u16(0);
  out.u64(held.time);
}

HeldPlace read_held(LittleEndianReader &in) {
  HeldPlace held;
  for (auto *value : {&held.x, &held.y, &held.radius})
    *value = in.f32();
  held.state = static_cast<HoldState>(in.u8());
  in.u8();
  in.u16();
  held.time = in.u64();
  return held;
}

} // namespace

bool is_valid(const MotionSample &s) noexcept {
  return is_finite(s.motion()) && is_fraction(s.pointer_x) && is_fraction(s.pointer_y) &&
         is_fraction(s.region_width) && is_fraction(s.region_height) && is_fraction(s.confidence) &&
         has_frame(s) && s.model <= MotionModel::affine && is_valid(s.held);
}

std::string_view motion_model_name(MotionModel model) noexcept {
  switch (model) {
  case MotionModel::still:
    return "static";
  case MotionModel::translation:
    return "translation";
  case MotionModel::similarity:
    return "similarity";
  case MotionModel::affine:
    return "affine";
  case MotionModel::none:
    break;
  }
  return "none";
}

MotionSampleBytes pack_motion_sample(const MotionSample &s) noexcept {
  MotionSampleBytes bytes;
  LittleEndianWriter out(bytes.bytes_);
  write_header(out, MotionKind::point, {s.flags, s.interval});
  for (auto value : {s.velocity_x, s.velocity_y, s.spin, s.divergence, s.pointer_x, s.pointer_y,
                     s.region_width, s.region_height, s.confidence})
    out.f32(value);
  write_frame(out, s);
  out.u16(s.points);
  out.u8(static_cast<std::uint8_t>(s.model));
  out.u8(0);
  if (s.held.state != HoldState::none) {
    write_held(out, s.held);
    bytes.size_ = kHeldMotionSampleSize;
  }
  return bytes;
}

std::optional<MotionSample> unpack_motion_sample(std::span<const std::uint8_t> bytes) noexcept {
  const bool may_be_held = bytes.size() >= kHeldMotionSampleSize;
  if (bytes.size() != kMotionSampleSize && !may_be_held)
    return std::nullopt;
  LittleEndianReader in(bytes);
  const auto header = read_header(in, MotionKind::point);
  if (!header)
    return std::nullopt;
  MotionSample s;
  s.flags = header->flags;
  s.interval = header->interval;
  for (auto *value : {&s.velocity_x, &s.velocity_y, &s.spin, &s.divergence, &s.pointer_x,
                      &s.pointer_y, &s.region_width, &s.region_height, &s.confidence})
    *value = in.f32();
  read_frame(in, s);
  s.points = in.u16();
  s.model = static_cast<MotionModel>(in.u8());
  in.u8();
  if (may_be_held)
    s.held = read_held(in);
  if (!is_valid(s))
    return std::nullopt;
  return s;
}

} // namespace haptic
