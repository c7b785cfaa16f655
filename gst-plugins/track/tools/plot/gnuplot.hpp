// SPDX-License-Identifier: LGPL-2.1-or-later
// gnuplot as a process that draws one picture.
#pragma once

#include "glue/gst-raii.hpp"
#include "palette.hpp"
#include "part-file.hpp"
#include "track-error.hpp"

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace haptic {

/// Throws TrackFileError if there is no gnuplot, and in finish() if it could not draw.
class Gnuplot {
public:
  explicit Gnuplot(const std::string &output) : output_(output), part_(output + ".part") {
    if (!GCharPtr(g_find_program_in_path("gnuplot")))
      throw_error(messages::kGnuplotIsMissing);
    if (output.find('\'') != std::string::npos || output.find('\n') != std::string::npos)
      throw_error(messages::kGnuplotRefusesName, output.c_str());
    // If it cannot open the file, it draws into its output. No word of a user is in the command.
    pipe_.reset(popen("exec gnuplot >/dev/null", "w")); // NOLINT(bugprone-command-processor)
    if (!pipe_)
      throw_error(messages::kGnuplotFails);
    std::signal(SIGPIPE, SIG_IGN); // Ctrl-C ends it, too
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
    line("set output '%s'", part_.path().c_str());
  }
  void finish() {
    const bool has_drawn = pclose(pipe_.release()) == 0;
    throw_if_interrupted();
    if (!has_drawn)
      throw_error(messages::kPlotFails, output_.c_str());
    part_.keep_as(output_);
  }

private:
  std::string output_;
  PartFile part_;
  std::unique_ptr<std::FILE, int (*)(std::FILE *)> pipe_ = {nullptr, pclose};
};

} // namespace haptic
