// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion-sample.hpp"

#include "little-endian.hpp"

namespace haptic {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'H', 'M', 'S', 'P'};
constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kKindPoint = 0;

bool is_fraction(float value) {
  return value >= 0 && value <= 1;
} // false for NaN

} // namespace

bool is_valid(const MotionSample &s) noexcept {
  return is_finite(s.motion()) && is_fraction(s.pointer_x) && is_fraction(s.pointer_y) &&
         is_fraction(s.region_width) && is_fraction(s.region_height) && is_fraction(s.confidence) &&
         s.frame_width > 0 && s.frame_height > 0 && s.pixel_aspect_n > 0 && s.pixel_aspect_d > 0 &&
         s.model <= MotionModel::affine;
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
  MotionSampleBytes bytes{};
  LittleEndianWriter out(bytes);
  for (auto letter : kMagic)
    out.u8(letter);
  out.u8(kVersion);
  out.u8(kKindPoint);
  out.u16(s.flags);
  out.u64(s.interval);
  for (auto value : {s.velocity_x, s.velocity_y, s.spin, s.divergence, s.pointer_x, s.pointer_y,
                     s.region_width, s.region_height, s.confidence})
    out.f32(value);
  for (auto value : {s.frame_width, s.frame_height, s.pixel_aspect_n, s.pixel_aspect_d})
    out.u32(value);
  out.u16(s.points);
  out.u8(static_cast<std::uint8_t>(s.model));
  out.u8(0);
  return bytes;
}

std::optional<MotionSample> unpack_motion_sample(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() < kMotionSampleSize)
    return std::nullopt;
  LittleEndianReader in(bytes);
  for (auto letter : kMagic)
    if (in.u8() != letter)
      return std::nullopt;
  if (in.u8() != kVersion || in.u8() != kKindPoint)
    return std::nullopt;
  MotionSample s;
  s.flags = in.u16();
  s.interval = in.u64();
  for (auto *value : {&s.velocity_x, &s.velocity_y, &s.spin, &s.divergence, &s.pointer_x,
                      &s.pointer_y, &s.region_width, &s.region_height, &s.confidence})
    *value = in.f32();
  for (auto *value : {&s.frame_width, &s.frame_height, &s.pixel_aspect_n, &s.pixel_aspect_d})
    *value = in.u32();
  s.points = in.u16();
  s.model = static_cast<MotionModel>(in.u8());
  if (!is_valid(s))
    return std::nullopt;
  return s;
}

} // namespace haptic
