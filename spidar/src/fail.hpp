// SPDX-License-Identifier: LGPL-2.1-or-later
// Errors and texts from the messages of messages.hpp. Not for the real-time thread.
#pragma once

#include "messages.hpp"
#include "spidar/error.hpp"

#include <cstdarg>
#include <cstdio>

namespace spidar {

inline std::string formatted_list(const char *format, std::va_list arguments) {
  std::va_list again;
  va_copy(again, arguments);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, again)), '\0');
  va_end(again);
  std::vsnprintf(text.data(), text.size() + 1, format, arguments);
  return text;
}

/// The text of `format` and its arguments, as printf() writes it.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char *format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  std::string text = formatted_list(format, arguments);
  va_end(arguments);
  return text;
}

/// Throws Error with that text.
[[noreturn, gnu::format(printf, 2, 3)]] inline void fail(Cause cause, const char *format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  const std::string text = formatted_list(format, arguments);
  va_end(arguments);
  throw Error(cause, text);
}

} // namespace spidar
