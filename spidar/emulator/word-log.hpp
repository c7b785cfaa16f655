// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes D/A words and events as CSV. One thread.
#pragma once

#include "plant.hpp"

#include <cstdio>
#include <memory>
#include <string>

namespace emulator {

/// Columns: time in s of the machine's monotonic clock (that of /proc/uptime on a machine that
/// never slept), unit from 1, event (`words` when the host set them), and the D/A words at the
/// motors.
class WordLog {
public:
  /// Throws spidar::Error (argument) when `path` cannot be written.
  explicit WordLog(const std::string &path);

  void add(Time time, int unit, const std::string &event, const spidar::DacWords &words);
  void flush();

private:
  struct Closer {
    void operator()(std::FILE *file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Closer> file_;
};

} // namespace emulator
