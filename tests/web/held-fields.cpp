// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes tracks with things, presses on them, and what FieldHold makes of the fields that follow,
// for held-test.mjs. Numbers are little-endian doubles. A track is the number of packets; each
// packet with its time in s, its size and its bytes; the number of presses; each press with the
// number of its field, x, y and z, and the number of samples; each sample with its state, x, y,
// radius, s since the press, velocity x and y, and confidence.
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "leaf-fields.hpp"
#include "motion/field-hold.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

namespace {

using haptic::FieldThing;
using haptic::HoldState;
using haptic::MotionField;

constexpr int kFrames = 200;
constexpr int kThings = 12;
constexpr int kPresses = 60;
constexpr int kFollowed = 40; // fields

void put(double number) {
  std::fwrite(&number, sizeof number, 1, stdout);
}

// Things that swing, some of them small. Now and then one is hidden, or cannot be told from its
// neighbours; some end.
std::vector<FieldThing> things_at(int frame) {
  std::vector<FieldThing> things;
  for (int i = 0; i < kThings; ++i) {
    const int age = (frame + 37 * i) % 160;
    if (age > 140)
      continue;
    const double phase = 0.1 * frame * (1 + 0.1 * i);
    things.push_back({static_cast<std::uint16_t>(i + kThings * ((frame + 37 * i) / 160)),
                      age % 50 > 40   ? HoldState::hidden
                      : age % 70 > 60 ? HoldState::about
                                      : HoldState::held,
                      static_cast<float>(0.1 + 0.07 * i + 0.04 * std::sin(phase)),
                      static_cast<float>(0.5 + 0.3 * std::cos(2.1 * i) + 0.05 * std::cos(phase)),
                      0.004F * static_cast<float>(i)});
  }
  return things;
}

// What a decoder holds, with the things of the packet.
std::vector<MotionField> put_track(unsigned seed) {
  test::LeafFields leaves(seed, 0.9, 4);
  haptic::FieldEncoder encoder;
  haptic::FieldDecoder decoder;
  std::vector<MotionField> fields;
  put(kFrames);
  for (int frame = 0; frame < kFrames; ++frame) {
    MotionField field = leaves.next();
    if (frame == 150)
      field.flags = haptic::kMotionCut;
    haptic::CodedField coded{encoder.push(field, true).value()};
    coded.time = frame * test::LeafFields::kInterval;
    field.things = things_at(frame);
    coded.things.resize(packed_size(field.things));
    pack_field_things(field.things, coded.things);
    decoder.push(coded.bytes);
    fields.push_back(decoder.field());
    unpack_field_things(coded.things, fields.back().things);
    const auto bytes = write_klv(coded);
    put(static_cast<double>(coded.time) * 1e-9);
    put(static_cast<double>(bytes.size()));
    std::fwrite(bytes.data(), 1, bytes.size(), stdout);
  }
  return fields;
}

void put_sample(const haptic::MotionSample &sample) {
  const haptic::HeldPlace &held = sample.held;
  put(static_cast<double>(held.state));
  for (const float number : {held.x, held.y, held.radius})
    put(number);
  put(static_cast<double>(held.time) * 1e-9);
  for (const float number : {sample.velocity_x, sample.velocity_y, sample.confidence})
    put(number);
}

// On a thing, or beside one, or anywhere.
void put_press(const std::vector<MotionField> &fields, std::mt19937 &random) {
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  const auto first = static_cast<std::size_t>(number(1, kFrames - 2));
  haptic::PointerPosition place{.x = number(0, 1), .y = number(0, 1), .z = number(-1, 1)};
  const auto &things = fields[first].things;
  const auto chosen = static_cast<std::size_t>(number(0, 2 * kThings));
  if (chosen < things.size()) {
    place.x = static_cast<double>(things[chosen].x) + number(-0.02, 0.02);
    place.y = static_cast<double>(things[chosen].y) + number(-0.02, 0.02);
  }
  const std::size_t count = std::min<std::size_t>(kFollowed, fields.size() - first);
  for (const double value : {static_cast<double>(first), place.x, place.y, place.z})
    put(value);
  put(static_cast<double>(count));
  haptic::FieldHold hold;
  hold.press(place, fields[first]);
  put_sample(hold.sample());
  for (std::size_t i = 1; i < count; ++i) {
    hold.step(fields[first + i], place.z);
    put_sample(hold.sample());
  }
}

} // namespace

int main() {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto fields = put_track(seed);
    std::mt19937 random(seed);
    put(kPresses);
    for (int press = 0; press < kPresses; ++press)
      put_press(fields, random);
  }
}
