// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json-reader.hpp"

#include <charconv>
#include <cmath>

namespace haptic {
namespace {

constexpr int kDeepest = 32;
constexpr std::size_t kLongestString = 4096;

void append_utf8(std::string &text, unsigned code) {
  if (code < 0x80) {
    text.push_back(static_cast<char>(code));
  } else if (code < 0x800) {
    text.push_back(static_cast<char>(0xC0U | code >> 6));
    text.push_back(static_cast<char>(0x80U | (code & 0x3FU)));
  } else {
    text.push_back(static_cast<char>(0xE0U | code >> 12));
    text.push_back(static_cast<char>(0x80U | (code >> 6 & 0x3FU)));
    text.push_back(static_cast<char>(0x80U | (code & 0x3FU)));
  }
}

} // namespace

void JsonReader::fail(const char *what) noexcept {
  if (!error_)
    error_ = what;
}

char JsonReader::peek() noexcept {
  while (at_ < text_.size() &&
         (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
    ++at_;
  return at_ < text_.size() ? text_[at_] : '\0';
}

bool JsonReader::take(char wanted) noexcept {
  if (error_ || peek() != wanted || at_ >= text_.size())
    return false;
  ++at_;
  return true;
}

void JsonReader::expect(char wanted) noexcept {
  if (!take(wanted))
    fail("this is not JSON");
}

bool JsonReader::open(char bracket) noexcept {
  if (!take(bracket)) {
    fail(bracket == '{' ? "an object is expected" : "an array is expected");
    return false;
  }
  if (++depth_ > kDeepest)
    fail("nested too deeply");
  return !failed();
}

bool JsonReader::closed(char bracket, bool first) noexcept {
  if (failed() || take(bracket))
    return true;
  if (!first)
    expect(',');
  return failed();
}

double JsonReader::number() {
  peek();
  double value = 0;
  const char *begin = text_.data() + at_;
  const auto end = std::from_chars(begin, text_.data() + text_.size(), value);
  if (failed() || end.ec != std::errc() || !std::isfinite(value)) {
    fail("a number is expected");
    return 0;
  }
  at_ += static_cast<std::size_t>(end.ptr - begin);
  return value;
}

unsigned JsonReader::hex_digits() noexcept {
  unsigned code = 0;
  if (text_.size() - at_ < 4) {
    fail("an escape is cut off");
    return 0;
  }
  const auto end = std::from_chars(text_.data() + at_, text_.data() + at_ + 4, code, 16);
  if (end.ptr != text_.data() + at_ + 4)
    fail("an escape is wrong");
  at_ += 4;
  return code;
}

std::string JsonReader::string() {
  std::string text;
  if (!take('"')) {
    fail("a text is expected");
    return text;
  }
  while (!failed()) {
    if (at_ >= text_.size() || static_cast<unsigned char>(text_[at_]) < 0x20) {
      fail("a text does not end");
      break;
    }
    const char c = text_[at_++];
    if (c == '"')
      return text;
    if (text.size() >= kLongestString) {
      fail("a text is too long");
      break;
    }
    if (c != '\\') {
      text.push_back(c);
      continue;
    }
    const char escape = at_ < text_.size() ? text_[at_++] : '\0';
    constexpr std::string_view kNames = "\"\\/bfnrt";
    constexpr std::string_view kMeanings = "\"\\/\b\f\n\r\t";
    if (escape == 'u')
      append_utf8(text, hex_digits());
    else if (const auto which = kNames.find(escape); escape && which != std::string_view::npos)
      text.push_back(kMeanings[which]);
    else
      fail("an escape is wrong");
  }
  return {};
}

void JsonReader::skip() {
  switch (peek()) {
  case '{':
    return object([this](const std::string &) { skip(); });
  case '[':
    return array([this] { skip(); });
  case '"':
    string();
    return;
  default:
    for (const std::string_view word : {"true", "false", "null"})
      if (text_.substr(at_).starts_with(word)) {
        at_ += word.size();
        return;
      }
    number();
  }
}

void JsonReader::end() {
  if (!failed() && (peek() != '\0' || at_ < text_.size()))
    fail("there is more behind the end");
}

} // namespace haptic
