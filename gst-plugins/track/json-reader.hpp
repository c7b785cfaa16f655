// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads JSON from front to back, without building a tree of it: input from outside may be large.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace haptic {

/// After the first error every call returns at once; `error` tells it.
class JsonReader {
public:
  explicit JsonReader(std::string_view text) noexcept : text_(text) {}

  /// Calls `member(key)` for each member; it must read the value or skip() it.
  template <typename Member>
  void object(Member &&member) {
    if (!open('{'))
      return;
    for (bool first = true; !closed('}', first); first = false) {
      std::string key = string();
      expect(':');
      if (!failed())
        member(key);
    }
    --depth_;
  }

  /// Calls `element()` for each element.
  template <typename Element>
  void array(Element &&element) {
    if (!open('['))
      return;
    for (bool first = true; !closed(']', first); first = false)
      element();
    --depth_;
  }

  double number();      ///< finite
  std::string string(); ///< at most kLongestString bytes; \u escapes become UTF-8
  void skip();          ///< a value of any kind
  void end();           ///< nothing but blanks is left

  /// For the caller's own objections to what it has read.
  void fail(const char *what) noexcept;
  bool failed() const noexcept { return error_ != nullptr; }
  const char *error() const noexcept { return error_ ? error_ : ""; }
  std::size_t offset() const noexcept { return at_; } ///< bytes

private:
  char peek() noexcept; // behind blanks; 0 at the end
  bool take(char wanted) noexcept;
  void expect(char wanted) noexcept;
  bool open(char bracket) noexcept;
  bool closed(char bracket, bool first) noexcept;
  unsigned hex_digits() noexcept;

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
  const char *error_ = nullptr;
};

} // namespace haptic
