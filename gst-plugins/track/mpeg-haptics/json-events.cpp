// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/json-events.hpp"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

namespace haptic {
namespace {

// A place in the text that the parser has reached. The copies of one share it.
class CountedPlace {
public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char *;
  using reference = const char &;

  explicit CountedPlace(const char *&at) : at_(&at) {}
  reference operator*() const { return **at_; }
  CountedPlace &operator++() { return ++*at_, *this; }
  bool operator==(const CountedPlace &other) const { return *at_ == *other.at_; }

private:
  const char **at_;
};

// What the library says that is wrong, in our words; the first one that its sentence contains.
constexpr std::pair<std::string_view, const char *> kObjections[] = {
    {"; expected end of input", "there is more behind the end"},
    {"missing closing quote", "a text does not end"},
    {"control character", "a text does not end"},
    {"ill-formed UTF-8", "a text is not UTF-8"},
    {"invalid string", "an escape is wrong"},
    {"invalid number", "a number is expected"},
    {"number overflow", "a number is expected"},
    {"", "this is not JSON"}};

// Hands the library's events to a JsonHandler and keeps the first objection.
class EventForwarder final : public nlohmann::json::json_sax_t {
public:
  // `at`: what the parser has read up to.
  EventForwarder(JsonHandler &handler, const char *const &at)
      : handler_(handler), at_(at), done_(at) {}

  bool null() override { return accept(handler_.word()); }
  bool boolean(bool) override { return accept(handler_.word()); }
  bool number_integer(number_integer_t value) override {
    return accept(handler_.number(static_cast<double>(value)));
  }
  bool number_unsigned(number_unsigned_t value) override {
    return accept(handler_.number(static_cast<double>(value)));
  }
  bool number_float(number_float_t value, const string_t &text) override {
    return accept(text.size() > kLongestJsonWord ? "a number is too long" : handler_.number(value));
  }
  bool string(string_t &text) override {
    return accept(is_long(text) ? kLongText : handler_.text(text));
  }
  bool key(string_t &text) override {
    return accept(is_long(text) ? kLongText : handler_.key(text));
  }
  bool binary(binary_t &) override { return accept("this is not JSON"); }
  bool start_object(std::size_t) override { return descend() && accept(handler_.begin_object()); }
  bool end_object() override { return --depth_, accept(handler_.end_object()); }
  bool start_array(std::size_t) override { return descend() && accept(handler_.begin_array()); }
  bool end_array() override { return --depth_, accept(handler_.end_array()); }
  bool parse_error(std::size_t, const std::string &,
                   const nlohmann::json::exception &error) override {
    for (const auto &[part, objection] : kObjections)
      if (!objection_ && std::string_view(error.what()).find(part) != std::string_view::npos)
        objection_ = objection;
    done_ = at_;
    return false;
  }

  const char *objection() const { return objection_; }
  // What was read and right. What was objected to comes next.
  const char *done() const { return done_; }

private:
  static constexpr char kLongText[] = "a text is too long";

  static bool is_long(const std::string &text) { return text.size() > kLongestJsonText; }
  bool accept(const char *objection) {
    objection_ = objection;
    if (!objection)
      done_ = at_;
    return objection == nullptr;
  }
  bool descend() { return ++depth_ <= kDeepestJson || accept("nested too deeply"); }

  JsonHandler &handler_;
  const char *const &at_;
  const char *done_;
  int depth_ = 0;
  const char *objection_ = nullptr;
};

} // namespace

std::optional<JsonError> parse_json(std::string_view text, JsonHandler &handler) {
  // The library takes a zero byte for the end.
  const std::string_view whole = text.substr(0, text.find('\0'));
  const char *at = whole.data();
  const char *end = at + whole.size();
  EventForwarder events(handler, at);
  nlohmann::json::sax_parse(CountedPlace(at), CountedPlace(end), &events);
  const auto done = static_cast<std::size_t>(events.done() - whole.data());
  const std::size_t offset = std::min(whole.find_first_not_of(" \t\r\n:,", done), whole.size());
  if (events.objection())
    return JsonError{events.objection(), offset};
  if (whole.size() < text.size())
    return JsonError{"there is more behind the end", offset};
  return std::nullopt;
}

} // namespace haptic
