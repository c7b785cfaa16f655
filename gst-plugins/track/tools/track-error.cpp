// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track-error.hpp"

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

} // namespace haptic
