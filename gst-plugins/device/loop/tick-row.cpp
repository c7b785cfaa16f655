// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/tick-row.hpp"

#include <charconv>
#include <cmath>
#include <Eigen/Geometry>

namespace haptic {
namespace {

constexpr int kDigits = 9;
constexpr int kDigitsOfTime = 12; // s: microseconds for ten days

void append_number(std::string &text, double value, int kept = kDigits) {
  std::array<char, 32> digits{};
  // Adding zero turns -0 into 0.
  const auto end =
      std::to_chars(digits.begin(), digits.end(), std::isfinite(value) ? value + 0.0 : 0,
                    std::chars_format::general, kept)
          .ptr;
  if (!text.empty() && text.back() != '\n')
    text += ',';
  text.append(digits.begin(), end);
}

} // namespace

void TickRow::read(const spidar::DeviceState &state) noexcept {
  position = state.pose.position;
  tension = state.tensions;
  const Eigen::Quaterniond q(state.pose.rotation);
  const double sign = q.w() < 0 ? -1 : 1; // w >= 0
  orientation = {sign * q.x(), sign * q.y(), sign * q.z(), sign * q.w()};
  turning = state.angular_velocity;
  realised = state.realised;
}

void append_row(std::string &text, const TickRow &row) {
  const auto append = [&text](const auto &values) {
    for (const double value : values)
      append_number(text, value);
  };
  append_number(text, row.time, kDigitsOfTime);
  append(row.position);
  append(row.velocity);
  append_number(text, row.spin);
  append(row.commanded.force);
  append(row.commanded.torque);
  append_number(text, row.confidence);
  append(row.tension);
  append_number(text, row.mono, kDigitsOfTime);
  append_number(text, row.hold);
  append(row.orientation);
  append_number(text, row.energy);
  append(row.turning);
  append(row.realised.force);
  append(row.realised.torque);
  append(row.proxy);
  append_number(text, row.touches ? 1 : 0);
  append_number(text, row.limits);
  text += '\n';
}

} // namespace haptic
