// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track-error.hpp"

#include <cstdio>

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

void print_error(const std::string &text) {
  std::fprintf(stderr, "haptic-track: %s\n", text.c_str());
}

void print_remark(const std::string &path, const std::string &remark) {
  print_error('"' + path + "\": " + remark);
}

void print_remarks(const std::string &path, const std::vector<std::string> &remarks) {
  for (const std::string &remark : remarks)
    print_remark(path, remark);
}

} // namespace haptic
