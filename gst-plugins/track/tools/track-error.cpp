// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track-error.hpp"

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <unistd.h>

namespace haptic {
namespace {

volatile std::sig_atomic_t interrupted = 0;

} // namespace

void stop_when_interrupted() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGXFSZ, SIG_IGN);
}

bool is_interrupted() noexcept {
  return interrupted != 0;
}

void throw_if_interrupted() {
  if (is_interrupted())
    throw_error(messages::kWorkIsInterrupted);
}

std::string about(const std::string &path, const std::string &text) {
  return text.starts_with('"') ? text : '"' + path + "\": " + text;
}

void throw_error(const char *format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  const std::string text = format_list(format, arguments);
  va_end(arguments);
  throw TrackFileError(text);
}

void check_readable(const std::string &path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw_error(messages::kFileIsMissing, path.c_str());
  if (!std::filesystem::is_regular_file(path, error))
    throw_error(messages::kFileIsNone, path.c_str());
  if (access(path.c_str(), R_OK) != 0)
    throw_error(messages::kFileIsForbidden, path.c_str());
}

void print_error(const std::string &text) {
  std::fprintf(stderr, "haptic-track: %s\n", text.c_str());
}

void print_remarks(const std::string &path, const std::vector<std::string> &remarks) {
  for (const std::string &remark : remarks)
    print_error(about(path, remark));
}

} // namespace haptic
