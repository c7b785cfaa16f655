// SPDX-License-Identifier: LGPL-2.1-or-later
// What spidar-check prints, and writes to a file for a bug report. The user's home folder is left
// out of it.
#pragma once

#include "promises.hpp"

#include <array>

namespace spidar_check {

class Output {
public:
  void line(const std::string &text);
  void add(const Finding &finding);
  /// Versions, kernel, time.
  void describe_machine();
  /// How the device is driven.
  void describe_settings(const std::string &settings);
  /// The controller, what to know of its guardian, and the constants of its geometry.
  void describe_unit(const Unit &unit);
  void summary();
  bool failed() const { return counts_[1] > 0; }
  /// Throws spidar::Error (argument).
  void save(const std::string &path) const;

private:
  std::string text_;
  std::array<int, 3> counts_{};
};

} // namespace spidar_check
