// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track-error.hpp"

#include <cstdio>
#include <filesystem>
#include <unistd.h>

namespace haptic {

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

} // namespace haptic
