// SPDX-License-Identifier: LGPL-2.1-or-later
#include "touch/touch.hpp"

namespace haptic {

void Touch::step(const spidar::Vector3 &hand, const spidar::Vector3 &half, const FrameShift &shift,
                 const ContactLimits &limits, double dt) noexcept {
  if (at_.cut)
    law_.restart();
  if (!is_known())
    return law_.restart();
  law_.step({*at_.from, *at_.to, at_.weight, half, shift}, hand, limits, dt);
}

// A surface is certain: of the sum, the motion's part fades with its own confidence. While there is
// no surface, the motion is felt as without touch.
void Touch::apply(TouchMode mode, SafetyChain::Input &input) const noexcept {
  if (mode == TouchMode::surface) {
    input.wanted = {};
    input.of_hand.setZero();
    input.measured = at_.to != nullptr;
  } else if (!is_known()) {
    return;
  } else {
    input.make_certain();
  }
  const Contact &contact = law_.contact();
  input.touch = {.force = contact.force,
                 .surface_work = contact.surface_work,
                 .energy = contact.energy,
                 .released = contact.released};
  input.trust = 1;
  input.age = at_.age;
  input.interval = at_.interval;
}

} // namespace haptic
