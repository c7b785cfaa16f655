// SPDX-License-Identifier: LGPL-2.1-or-later
// gnuplot as a process that draws one picture.
#pragma once

#include "glue/gst-raii.hpp"
#include "palette.hpp"
#include "track-error.hpp"

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace haptic {

/// Throws TrackFileError if there is no gnuplot, and in finish() if it could not draw.
class Gnuplot {
public:
  explicit Gnuplot(const std::string &output) : output_(output) {
    if (!GCharPtr(g_find_program_in_path("gnuplot")))
      throw_error(messages::kGnuplotIsMissing);
    if (output.find('\'') != std::string::npos || output.find('\n') != std::string::npos)
      throw_error(messages::kGnuplotRefusesName, output.c_str());
    pipe_.reset(popen("gnuplot", "w")); // NOLINT(bugprone-command-processor): no word of a user
    if (!pipe_)
      throw_error(messages::kGnuplotFails);
    line(kPalette);
  }

  template <typename... Values>
  void line(const char *format, Values... values) {
    std::fprintf(pipe_.get(), format, values...); // NOLINT(cert-err33-c): seen when it is closed
    std::fputc('\n', pipe_.get());
  }
  void line(const char *text) { std::fprintf(pipe_.get(), "%s\n", text); }
  void bytes(const std::vector<std::uint8_t> &bytes) {
    std::fwrite(bytes.data(), 1, bytes.size(), pipe_.get());
  }
  void set_terminal(const char *type, int width, int height) {
    line("set terminal %s size %d,%d", type, width, height);
    line("set output '%s'", output_.c_str());
  }
  void finish() {
    if (pclose(pipe_.release()) != 0)
      throw_error(messages::kPlotFails, output_.c_str());
  }

private:
  std::string output_;
  std::unique_ptr<std::FILE, int (*)(std::FILE *)> pipe_ = {nullptr, pclose};
};

} // namespace haptic
