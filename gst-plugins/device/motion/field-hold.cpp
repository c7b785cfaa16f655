// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/field-hold.hpp"

#include "samples/field-sampler.hpp"
#include "samples/region-size.hpp"
#include "seconds.hpp"

#include <algorithm>
#include <limits>

namespace haptic {
namespace {

// The least distance in which a press finds a thing: 24 px in a frame 1920 px wide, which a finger
// covers.
constexpr float kLeastReach = 0.0125F; // of the width

float seconds_of(const MotionField &field) noexcept {
  return static_cast<float>(seconds(field.interval));
}

float half_region(const MotionField &field, double z) noexcept {
  const double width = field.frame_width;
  const double side =
      region_side(z, default_region_side(static_cast<int>(width)), width, field.frame_height);
  return static_cast<float>(side / (2 * width));
}

} // namespace

void FieldHold::press(const PointerPosition &place, const MotionField &field) noexcept {
  const auto width = static_cast<float>(field.frame_width);
  const auto height = static_cast<float>(field.frame_height);
  sample_ = sample_field(field, place);
  sample_.held = {.state = HoldState::about,
                  .x = static_cast<float>(place.x),
                  .y = static_cast<float>(place.y),
                  .radius = half_region(field, place.z)};
  is_thing_ = false;
  const HeldPlace pressed = sample_.held;
  float nearest = std::numeric_limits<float>::infinity();
  for (const FieldThing &thing : field.things) {
    const float dx = (thing.x - pressed.x) * width;
    const float dy = (thing.y - pressed.y) * height;
    const float distance2 = dx * dx + dy * dy;
    const float reach = std::max(thing.radius, kLeastReach) * width;
    if (!is_followed(thing.state) || distance2 > reach * reach || distance2 >= nearest)
      continue;
    nearest = distance2;
    id_ = thing.id;
    is_thing_ = true;
    sample_.held = {.state = thing.state, .x = thing.x, .y = thing.y, .radius = thing.radius};
  }
  sample_.pointer_x = sample_.held.x;
  sample_.pointer_y = sample_.held.y;
}

void FieldHold::lose() noexcept {
  sample_.velocity_x = sample_.velocity_y = sample_.confidence = 0;
  if (is_pressed())
    sample_.held.state = HoldState::lost;
}

void FieldHold::step(const MotionField &field, double z, double stretch) noexcept {
  const HeldPlace before = sample_.held;
  sample_ = frame_of(field);
  sample_.held = before;
  sample_.held.time += field.interval;
  if ((field.flags & (kMotionCut | kMotionDiscontinuity)) != 0)
    lose();
  if (is_pressed() && sample_.held.state != HoldState::lost) {
    if (is_thing_)
      follow_thing(field, z, static_cast<float>(stretch));
    else
      follow_region(field, z, static_cast<float>(stretch));
  }
  sample_.pointer_x = sample_.held.x;
  sample_.pointer_y = sample_.held.y;
}

void FieldHold::follow_thing(const MotionField &field, double z, float stretch) noexcept {
  const auto thing = std::ranges::find(field.things, id_, &FieldThing::id);
  if (thing == field.things.end())
    return lose();
  HeldPlace &held = sample_.held;
  const HeldPlace before = held;
  held.state = thing->state;
  held.x = thing->x;
  held.y = thing->y;
  held.radius = thing->radius;
  const float interval = seconds_of(field);
  if (held.state == HoldState::about)
    feel_region(field, z);
  if (held.state != HoldState::held || before.state != HoldState::held || !(interval > 0))
    return;
  const auto width = static_cast<float>(field.frame_width);
  const auto height = static_cast<float>(field.frame_height);
  sample_.velocity_x = (held.x - before.x) * width / interval * stretch;
  sample_.velocity_y = (held.y - before.y) * height / interval * stretch;
  sample_.confidence = 1;
}

void FieldHold::feel_region(const MotionField &field, double z) noexcept {
  const MotionSample motion =
      sample_field(field, {.x = sample_.held.x, .y = sample_.held.y, .z = z});
  sample_.velocity_x = motion.velocity_x;
  sample_.velocity_y = motion.velocity_y;
  sample_.confidence = motion.confidence;
}

void FieldHold::follow_region(const MotionField &field, double z, float stretch) noexcept {
  feel_region(field, z);
  HeldPlace &held = sample_.held;
  held.radius = half_region(field, z);
  const float interval = seconds_of(field) / stretch;
  const auto width = static_cast<float>(field.frame_width);
  const auto height = static_cast<float>(field.frame_height);
  held.x = std::clamp(held.x + sample_.velocity_x * interval / width, 0.F, 1.F);
  held.y = std::clamp(held.y + sample_.velocity_y * interval / height, 0.F, 1.F);
}

} // namespace haptic
