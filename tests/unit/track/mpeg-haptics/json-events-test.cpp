// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/json-events.hpp"

#include <gtest/gtest.h>
#include <string>

namespace json_events_test {

using haptic::parse_json;

// Writes down what comes, and objects to the text "stop".
class Recorder final : public haptic::JsonHandler {
public:
  const char *begin_object() override { return add("{"); }
  const char *end_object() override { return add("}"); }
  const char *begin_array() override { return add("["); }
  const char *end_array() override { return add("]"); }
  const char *key(std::string_view name) override { return add(std::string(name) + ":"); }
  const char *number(double value) override {
    last = value;
    return add("n");
  }
  const char *text(std::string_view value) override {
    add("'" + std::string(value) + "'");
    return value == "stop" ? "stop was asked for" : nullptr;
  }
  const char *word() override { return add("w"); }

  std::string events;
  double last = 0;

private:
  const char *add(const std::string &event) {
    events += event;
    return nullptr;
  }
};

std::string events_of(std::string_view text) {
  Recorder recorder;
  const auto error = parse_json(text, recorder);
  return error ? std::string("error: ") + error->what : recorder.events;
}

std::string error_of(std::string_view text) {
  Recorder recorder;
  const auto error = parse_json(text, recorder);
  return error ? error->what : "";
}

double number_of(std::string_view text) {
  Recorder recorder;
  EXPECT_FALSE(parse_json(text, recorder)) << text;
  return recorder.last;
}

TEST(JsonEvents, ComeInTheOrderOfTheText) {
  EXPECT_EQ(events_of(R"( {"a": [1, "x", true], "b": {"c": null}, "a": []} )"),
            "{a:[n'x'w]b:{c:w}a:[]}");
}

TEST(JsonEvents, NumbersAreTheNearestDoubles) {
  EXPECT_EQ(number_of("0"), 0);
  EXPECT_EQ(number_of("-17"), -17);
  EXPECT_EQ(number_of("18446744073709551615"), 18446744073709551615.0);
  EXPECT_EQ(number_of("0.1"), 0.1);
  EXPECT_EQ(number_of("2.2250738585072011e-308"), 2.2250738585072011e-308);
  EXPECT_EQ(number_of("1.7976931348623157e308"), 1.7976931348623157e308);
  EXPECT_EQ(number_of("9007199254740993"), 9007199254740992.0);
  EXPECT_EQ(number_of("5e-324"), 5e-324);
  for (const char *zero : {"0E-88", "0.000e-330", "-0e5", "1e-400"})
    EXPECT_EQ(number_of(zero), 0) << zero;
}

TEST(JsonEvents, NoNumberIsInfiniteOrNotANumber) {
  for (const char *text : {"1e999", "-1e309", "NaN", "Infinity", "inf", "-nan", "0x10", "+1", ".5"})
    EXPECT_NE(error_of(text), "") << text;
}

TEST(JsonEvents, EscapesBecomeUtf8) {
  EXPECT_EQ(events_of(R"("\"\\\/\b\f\n\r\t")"), "'\"\\/\b\f\n\r\t'");
  EXPECT_EQ(events_of(R"("\u0041\u00e9\u20ac\ud83d\ude00")"), "'A\u00e9\u20ac\U0001F600'");
  EXPECT_EQ(error_of(R"("\x")"), "an escape is wrong");
  EXPECT_EQ(error_of(R"("\u12g4")"), "an escape is wrong");
  EXPECT_EQ(error_of(R"("\ud83d")"), "an escape is wrong") << "half a pair";
}

TEST(JsonEvents, WhatIsNotOneValueIsRefused) {
  for (const char *text : {"", " ", "{", "[", "{]", "[1,]", "{\"a\"}", "{\"a\":}", "{\"a\":1,}",
                           "{a:1}", "tru", "'x'", "[1 2]", "// x\n1"})
    EXPECT_NE(error_of(text), "") << text;
  EXPECT_EQ(error_of("1 2"), "there is more behind the end");
  EXPECT_EQ(error_of(std::string_view("1\0", 2)), "there is more behind the end");
  EXPECT_EQ(error_of(std::string_view("[\0]", 3)), "this is not JSON");
  EXPECT_EQ(error_of("\"x"), "a text does not end");
  EXPECT_EQ(error_of("\"a\nb\""), "a text does not end");
}

TEST(JsonEvents, EveryTruncationIsRefused) {
  const std::string text = R"({"a":[1.5e3,"x\u0041",{"b":false}],"c":""})";
  ASSERT_EQ(error_of(text), "");
  for (std::size_t size = 0; size < text.size(); ++size)
    EXPECT_NE(error_of(text.substr(0, size)), "") << size;
}

TEST(JsonEvents, NestingEndsAtItsLimit) {
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_EQ(error_of(nested(haptic::kDeepestJson)), "");
  EXPECT_EQ(error_of(nested(haptic::kDeepestJson + 1)), "nested too deeply");
  EXPECT_EQ(error_of(std::string(1'000'000, '[')), "nested too deeply");
}

TEST(JsonEvents, TextsEndAtTheirLimit) {
  const auto text = [](std::size_t size) { return "\"" + std::string(size, 'x') + "\""; };
  EXPECT_EQ(error_of(text(haptic::kLongestJsonText)), "");
  EXPECT_EQ(error_of(text(haptic::kLongestJsonText + 1)), "a text is too long");
  EXPECT_EQ(error_of(text(10'000'000)), "a text is too long");
  EXPECT_EQ(error_of("{" + text(haptic::kLongestJsonText + 1) + ":1}"), "a text is too long");
  std::string escaped = "\"";
  for (std::size_t i = 0; i < haptic::kLongestJsonText; ++i)
    escaped += "\\u0041";
  EXPECT_EQ(error_of(escaped + "\""), "") << "bytes are counted without their escapes";
}

TEST(JsonEvents, NumbersEndAtTheirLimit) {
  const std::string longest = "0." + std::string(haptic::kLongestJsonWord - 2, '1');
  EXPECT_EQ(error_of("[" + longest + ", " + longest + "]"), "");
  EXPECT_EQ(error_of(longest + "1"), "a number is too long");
  EXPECT_EQ(error_of("1." + std::string(10'000'000, '1')), "a number is too long");
  EXPECT_NE(error_of(std::string(10'000'000, '1')), "");
}

TEST(JsonEvents, AnObjectionEndsTheReadingAndSaysWhere) {
  Recorder recorder;
  const auto error = parse_json(R"(["go","stop","on"])", recorder);
  ASSERT_TRUE(error);
  EXPECT_STREQ(error->what, "stop was asked for");
  EXPECT_EQ(recorder.events, "['go''stop'");
  EXPECT_GE(error->offset, 6U);
  EXPECT_LE(error->offset, 12U);
}

} // namespace json_events_test
