// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads JSON (RFC 8259) from front to back with the SAX reader of nlohmann-json, and builds no
// tree: a file may be large.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace haptic {

/// Limits of what parse_json() reads. A file beyond them is refused.
inline constexpr int kDeepestJson = 32;               // objects and arrays in each other
inline constexpr std::size_t kLongestJsonText = 4096; // bytes of a text without its escapes
inline constexpr std::size_t kLongestJsonWord = 1024; // bytes of a number or of true, false, null

/// Receives the values of a JSON text in their order. Each function returns nothing, or what is
/// wrong with the value; this ends the reading.
class JsonHandler {
public:
  virtual ~JsonHandler() = default;
  virtual const char *begin_object() = 0;
  virtual const char *end_object() = 0;
  virtual const char *begin_array() = 0;
  virtual const char *end_array() = 0;
  /// The name of the member whose value comes next. A name may come twice.
  virtual const char *key(std::string_view name) = 0;
  virtual const char *number(double value) = 0; ///< finite
  /// Escapes are UTF-8 already.
  virtual const char *text(std::string_view value) = 0;
  virtual const char *word() = 0; ///< true, false or null
};

struct JsonError {
  const char *what;
  std::size_t offset; ///< bytes
};

/// Returns the first error, or nothing if the text is one JSON value and the handler objected to
/// none of it. Memory is bounded by the longest text or number in it, and the depth of calls too.
std::optional<JsonError> parse_json(std::string_view text, JsonHandler &handler);

} // namespace haptic
