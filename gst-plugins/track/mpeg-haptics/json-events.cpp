// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/json-events.hpp"

#include <cmath>
#include <cstdint>
#include <glib.h>
#include <string>
#include <string_view>

namespace haptic {
namespace {

struct BrokenAssertion {};

// RapidJSON must not end the process, whatever it reads. parse_json() makes an error of this.
[[noreturn]] void throw_broken_assertion() {
  throw BrokenAssertion();
}

} // namespace
} // namespace haptic

#define RAPIDJSON_ASSERT(condition)                                                                \
  ((condition) ? static_cast<void>(0) : haptic::throw_broken_assertion())
#include <rapidjson/reader.h>

namespace haptic {
namespace {

// The longest escape of one byte is \u00XX. With this bound RapidJSON's buffer is bounded, too.
constexpr std::size_t kLongestEscapedText = 6 * kLongestJsonText;

// The bytes as RapidJSON takes them. The text ends early where a text or a number is too long.
class BoundedStream {
public:
  using Ch = char;

  explicit BoundedStream(std::string_view text) : text_(text) {}

  char Peek() const { return too_long_ || at_ >= text_.size() ? '\0' : text_[at_]; }
  char Take() {
    const char c = Peek();
    if (too_long_ || at_ >= text_.size())
      return c;
    ++at_;
    measure(c);
    return c;
  }
  std::size_t Tell() const { return at_; }

  // RapidJSON asks for these where it parses in place, which it does not here.
  char *PutBegin() { throw_broken_assertion(); }
  void Put(char) { throw_broken_assertion(); }
  void Flush() { throw_broken_assertion(); }
  std::size_t PutEnd(char *) { throw_broken_assertion(); }

  const char *too_long() const { return too_long_; }
  bool is_at_end() const { return at_ == text_.size(); }
  /// A line break or another control byte stands within a text.
  bool is_text_broken() const {
    return in_text_ && at_ < text_.size() && static_cast<unsigned char>(Peek()) < 0x20;
  }

private:
  void measure(char c) {
    if (in_text_) {
      const bool ends = c == '"' && !escaped_;
      escaped_ = c == '\\' && !escaped_;
      in_text_ = !ends;
      if (!ends && ++length_ > kLongestEscapedText)
        too_long_ = "a text is too long";
    } else if (c == '"') {
      in_text_ = true;
      escaped_ = false;
      length_ = 0;
    } else if (std::string_view("{}[],: \t\r\n").find(c) != std::string_view::npos) {
      length_ = 0;
    } else if (++length_ > kLongestJsonWord) {
      too_long_ = "a number is too long";
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t length_ = 0; // bytes of the text or the word so far
  bool in_text_ = false;
  bool escaped_ = false; // the byte before was a backslash
  const char *too_long_ = nullptr;
};

// Hands RapidJSON's events to a JsonHandler and keeps its objection.
class EventForwarder {
public:
  using Ch = char;

  explicit EventForwarder(JsonHandler &handler) : handler_(handler) {}

  bool Null() { return accept(handler_.word()); }
  bool Bool(bool) { return accept(handler_.word()); }
  bool RawNumber(const char *text, rapidjson::SizeType length, bool) {
    const double value = g_ascii_strtod(std::string(text, length).c_str(), nullptr);
    return accept(std::isfinite(value) ? handler_.number(value) : "a number is expected");
  }
  // RapidJSON asks for these where it reads numbers itself, which it does not here.
  bool Int(int) { throw_broken_assertion(); }
  bool Uint(unsigned) { throw_broken_assertion(); }
  bool Int64(std::int64_t) { throw_broken_assertion(); }
  bool Uint64(std::uint64_t) { throw_broken_assertion(); }
  bool Double(double) { throw_broken_assertion(); }
  bool String(const char *text, rapidjson::SizeType length, bool) {
    return is_short(length) && accept(handler_.text({text, length}));
  }
  bool Key(const char *text, rapidjson::SizeType length, bool) {
    return is_short(length) && accept(handler_.key({text, length}));
  }
  bool StartObject() { return descend() && accept(handler_.begin_object()); }
  bool EndObject(rapidjson::SizeType) { return --depth_, accept(handler_.end_object()); }
  bool StartArray() { return descend() && accept(handler_.begin_array()); }
  bool EndArray(rapidjson::SizeType) { return --depth_, accept(handler_.end_array()); }

  const char *objection() const { return objection_; }

private:
  bool accept(const char *objection) {
    objection_ = objection;
    return objection == nullptr;
  }
  bool is_short(std::size_t length) {
    return length <= kLongestJsonText || accept("a text is too long");
  }
  bool descend() { return ++depth_ <= kDeepestJson || accept("nested too deeply"); }

  JsonHandler &handler_;
  int depth_ = 0;
  const char *objection_ = nullptr;
};

const char *text_of(rapidjson::ParseErrorCode code) {
  switch (code) {
  case rapidjson::kParseErrorDocumentEmpty:
    return "there is nothing in it";
  case rapidjson::kParseErrorDocumentRootNotSingular:
    return "there is more behind the end";
  case rapidjson::kParseErrorStringUnicodeEscapeInvalidHex:
  case rapidjson::kParseErrorStringUnicodeSurrogateInvalid:
  case rapidjson::kParseErrorStringEscapeInvalid:
    return "an escape is wrong";
  case rapidjson::kParseErrorStringMissQuotationMark:
  case rapidjson::kParseErrorStringInvalidEncoding:
    return "a text does not end";
  case rapidjson::kParseErrorNumberTooBig:
  case rapidjson::kParseErrorNumberMissFraction:
  case rapidjson::kParseErrorNumberMissExponent:
    return "a number is expected";
  default:
    return "this is not JSON";
  }
}

} // namespace

std::optional<JsonError> parse_json(std::string_view text, JsonHandler &handler) {
  // Iterative: nesting costs no stack of the process. As strings: RapidJSON 1.1 rounds numbers to
  // the nearest only by a function whose behaviour is undefined for zeros.
  constexpr unsigned kFlags =
      rapidjson::kParseIterativeFlag | rapidjson::kParseNumbersAsStringsFlag;
  BoundedStream stream(text);
  EventForwarder events(handler);
  try {
    rapidjson::Reader reader;
    const rapidjson::ParseResult result = reader.Parse<kFlags>(stream, events);
    if (events.objection())
      return JsonError{events.objection(), result.Offset()};
    if (stream.too_long())
      return JsonError{stream.too_long(), stream.Tell()};
    if (stream.is_text_broken())
      return JsonError{"a text does not end", stream.Tell()};
    if (result.IsError())
      return JsonError{text_of(result.Code()), result.Offset()};
  } catch (const BrokenAssertion &) {
    return JsonError{"this is not JSON", stream.Tell()};
  }
  if (!stream.is_at_end()) // RapidJSON takes a zero byte for the end
    return JsonError{"there is more behind the end", stream.Tell()};
  return std::nullopt;
}

} // namespace haptic
