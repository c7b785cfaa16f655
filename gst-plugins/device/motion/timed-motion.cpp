// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/timed-motion.hpp"

#include "motion/motion-conditioning.hpp"

#include <algorithm>

namespace haptic {

void scale_velocities(TimedMotion &motion, double factor) noexcept {
  motion.sample *= factor;
  motion.stretch *= factor;
  if (!motion.field)
    return;
  for (FieldCell &cell : motion.field->cells) {
    cell.velocity_x = static_cast<float>(factor * cell.velocity_x);
    cell.velocity_y = static_cast<float>(factor * cell.velocity_y);
  }
}

void set_interval(TimedMotion &motion, std::uint64_t interval) noexcept {
  if (motion.sample.interval > 0)
    motion.stretch *= static_cast<double>(interval) / static_cast<double>(motion.sample.interval);
  motion.sample.interval = interval;
  if (motion.field)
    motion.field->interval = interval;
}

bool is_plausible(const TimedMotion &motion) noexcept {
  return motion.field ? is_plausible(*motion.field) : is_plausible(motion.sample);
}

bool has_measurement(const TimedMotion &motion) noexcept {
  if (!motion.field)
    return motion.sample.confidence > 0;
  return !motion.field->things.empty() ||
         std::ranges::any_of(motion.field->cells,
                             [](const FieldCell &cell) { return cell.confidence > 0; });
}

} // namespace haptic
