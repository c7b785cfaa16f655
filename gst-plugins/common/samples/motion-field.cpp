// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-field.hpp"

#include "samples/motion-bytes.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr FieldBytes kBytes{MotionKind::field, kFieldCellSize};

constexpr float kPlaceSteps = 65535;

bool is_valid(const FieldCell &cell) {
  return std::isfinite(cell.velocity_x) && std::isfinite(cell.velocity_y) && cell.confidence >= 0 &&
         cell.confidence <= 1;
}

// False for a number that is not finite, too.
bool is_valid(const FieldThing &thing) {
  const auto is_fraction = [](float value) { return value >= 0 && value <= 1; };
  return (is_followed(thing.state) || thing.state == HoldState::hidden) && is_fraction(thing.x) &&
         is_fraction(thing.y) && is_fraction(thing.radius);
}

bool are_valid(std::span<const FieldThing> things) {
  return things.size() <= kMostFieldThings &&
         std::ranges::all_of(things, [](const FieldThing &thing) { return is_valid(thing); });
}

std::uint16_t in_steps(float fraction) {
  return static_cast<std::uint16_t>(std::lround(fraction * kPlaceSteps));
}

FieldThing read_thing(LittleEndianReader &in) {
  FieldThing thing;
  thing.id = in.u16();
  thing.state = static_cast<HoldState>(in.u8());
  in.u8();
  for (auto *value : {&thing.x, &thing.y, &thing.radius})
    *value = static_cast<float>(in.u16()) / kPlaceSteps;
  in.u16();
  return thing;
}

} // namespace

bool is_valid(const MotionField &field) noexcept {
  return is_field(field, [](const FieldCell &cell) { return is_valid(cell); }) &&
         are_valid(field.things);
}

void pack_field_things(std::span<const FieldThing> things, std::span<std::uint8_t> bytes) noexcept {
  if (things.empty())
    return;
  LittleEndianWriter out(bytes);
  out.u32(static_cast<std::uint32_t>(things.size()));
  for (const FieldThing &thing : things) {
    out.u16(thing.id);
    out.u16(static_cast<std::uint16_t>(thing.state));
    for (const float value : {thing.x, thing.y, thing.radius})
      out.u16(in_steps(value));
    out.u16(0);
  }
}

bool are_field_things(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty())
    return true;
  if (bytes.size() < kThingsHeader || bytes[0] > kMostFieldThings ||
      bytes.size() < kThingsHeader + bytes[0] * kThingSize)
    return false;
  LittleEndianReader in(bytes.subspan(kThingsHeader));
  for (std::size_t i = 0; i < bytes[0]; ++i)
    if (!is_valid(read_thing(in)))
      return false;
  return true;
}

bool unpack_field_things(std::span<const std::uint8_t> bytes, std::vector<FieldThing> &things) {
  things.clear();
  if (!are_field_things(bytes))
    return false;
  if (bytes.empty())
    return true;
  LittleEndianReader in(bytes.subspan(kThingsHeader));
  things.resize(bytes[0]);
  for (FieldThing &thing : things)
    thing = read_thing(in);
  return true;
}

void pack_motion_field(const MotionField &field, std::span<std::uint8_t> bytes) noexcept {
  pack_field(field, kBytes, bytes, [](LittleEndianWriter &out, const FieldCell &cell) {
    for (auto value : {cell.velocity_x, cell.velocity_y, cell.confidence})
      out.f32(value);
  });
  pack_field_things(field.things, bytes.subspan(packed_size(field) - packed_size(field.things)));
}

bool unpack_motion_field(std::span<const std::uint8_t> bytes, MotionField &field) {
  field.things.clear();
  const auto read_cell = [](LittleEndianReader &in, FieldCell &cell) {
    for (auto *value : {&cell.velocity_x, &cell.velocity_y, &cell.confidence})
      *value = in.f32();
  };
  return unpack_field(bytes, kBytes, field, read_cell) &&
         unpack_field_things(bytes.subspan(packed_size(field)), field.things) && is_valid(field);
}

} // namespace haptic
