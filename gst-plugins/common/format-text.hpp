// SPDX-License-Identifier: LGPL-2.1-or-later
// printf into a std::string, for the tables of messages.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace haptic {

inline std::string format_list(const char *format, std::va_list arguments) {
  std::va_list again;
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, again);
  va_end(again);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, arguments);
  return text;
}

[[gnu::format(printf, 1, 2)]] inline std::string format_text(const char *format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  std::string text = format_list(format, arguments);
  va_end(arguments);
  return text;
}

} // namespace haptic
