// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track-error.hpp"

#include "glue/gst-raii.hpp"

#include <cstdarg>

namespace haptic {
namespace {

std::string formatted_list(const char *format, va_list arguments) {
  return GCharPtr(g_strdup_vprintf(format, arguments)).get();
}

} // namespace

std::string formatted(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  std::string text = formatted_list(format, arguments);
  va_end(arguments);
  return text;
}

void throw_error(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const std::string text = formatted_list(format, arguments);
  va_end(arguments);
  throw TrackFileError(text);
}

} // namespace haptic
