// SPDX-License-Identifier: LGPL-2.1-or-later
#include "array/array-layout.hpp"

#include "builtin-layouts.hpp"
#include "key-file.hpp"
#include "messages.hpp"

#include <cmath>

namespace haptic {

namespace {

constexpr double kLowestCarrier = 20;   // Hz
constexpr double kHighestCarrier = 500; // Hz; skin feels no more than that
constexpr double kFarthest = 1e4;       // of any unit
constexpr double kApart = 1e-3;         // m

constexpr KeyFileMessages kMessages = {messages::kLayoutUnknown, messages::kLayoutUnreadable,
                                       messages::kLayoutKeyMissing, messages::kLayoutKeyUnknown,
                                       messages::kLayoutNumber};

void check(const KeyFile &file, const ArrayLayout &layout) {
  const std::size_t count = layout.actuators.size();
  if (count < kFewestActuators || count > kMostActuators)
    file.refuse(messages::kLayoutCount, count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Actuator &a = layout.actuators[i];
      const Actuator &b = layout.actuators[j];
      if (std::hypot(a.x - b.x, a.y - b.y) < kApart)
        file.refuse(messages::kLayoutSamePlace, j + 1, i + 1);
    }
}

} // namespace

ArrayLayout load_array_layout(const std::string &name) {
  KeyFile file(name, kBuiltinLayouts, kMessages);
  file.enter("array");
  const auto unit = file.unit("unit");
  if (!unit)
    file.refuse(messages::kLayoutUnit);
  const std::optional<double> carrier = file.number("carrier", kLowestCarrier, kHighestCarrier);
  ArrayLayout layout;
  while (file.enter("actuator-" + std::to_string(layout.actuators.size() + 1))) {
    Actuator actuator;
    actuator.x = *unit * file.need("x", file.number("x", -kFarthest, kFarthest));
    actuator.y = *unit * file.need("y", file.number("y", -kFarthest, kFarthest));
    const auto own = file.number("carrier", kLowestCarrier, kHighestCarrier);
    actuator.carrier = file.need("carrier", own ? own : carrier);
    actuator.gain = file.number("gain", 0, 1).value_or(1);
    layout.actuators.push_back(actuator);
  }
  file.refuse_unknown();
  check(file, layout);
  return layout;
}

} // namespace haptic
