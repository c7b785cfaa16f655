// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages-page.hpp"

#include <cinttypes>
#include <gst/gst.h>
#include <map>
#include <regex>
#include <stdexcept>

#include "gst-plugins/common/glue/messages.hpp"
#include "gst-plugins/device/messages.hpp"
#include "gst-plugins/track/messages.hpp"
#include "gst-plugins/vision/messages.hpp"
#include "spidar/src/messages.hpp"

namespace docs {
namespace {

constexpr const char *kBegin = "<!-- messages: begin -->\n";
constexpr const char *kEnd = "<!-- messages: end -->\n";

// Replaces each printf conversion by an ellipsis.
std::string readable(const std::string &format) {
  static const std::regex conversion(
      R"(%[-+ #0]*[0-9*]*(\.[0-9*]+)?(hh|h|ll|l|z|j|t|L)?[diouxXeEfgGcsp])");
  static const std::regex percent("%%");
  return std::regex_replace(std::regex_replace(format, conversion, "…"), percent, "%");
}

// Escapes the characters with a meaning in Markdown or HTML.
std::string escaped(const std::string &text) {
  static const std::regex special(R"([\\`*_\[\]<>|])");
  return std::regex_replace(text, special, R"(\$&)");
}

// The text up to its first full stop, semicolon or colon that follows at least three words.
std::string first_sentence(const std::string &text) {
  static const std::regex sentence(R"(^(\S+ ){2}.*?[.;:](?= ))");
  std::smatch match;
  if (!std::regex_search(text, match, sentence))
    return text;
  std::string result = match.str();
  result.back() = '.';
  return result;
}

std::string on_one_line(const std::string &text) {
  static const std::regex line_break(R"(\s*\n\s*)");
  return std::regex_replace(text, line_break, " ");
}

// spidar's table holds the messages of its tools and its C API too.
bool is_of_tool(const Message &message) {
  for (const char *prefix : {"kTool", "kEmulator", "kCheck", "kCode"})
    if (message.name.starts_with(prefix))
      return true;
  return false;
}

struct Extent {
  std::size_t begin;
  std::size_t end;
};

Extent find_generated_part(const std::string &page) {
  const std::size_t begin = page.find(kBegin);
  const std::size_t end = page.find(kEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    throw std::runtime_error("the page lacks the markers of the generated section");
  return {begin + std::string(kBegin).size(), end};
}

} // namespace

std::vector<Table> message_tables() {
#define ROW(name, text, cure) {#name, text, cure},
  std::vector<Table> tables{
      {"Device and force", {DEVICE_MESSAGES(ROW)}},
      {"SPIDAR-G", {SPIDAR_MESSAGES(ROW)}},
      {"Video and motion", {VISION_MESSAGES(ROW)}},
      {"Haptic tracks", {TRACK_ELEMENT_MESSAGES(ROW)}},
      {"", {TRACK_TOOL_MESSAGES(ROW)}},
      {"Every element", {COMMON_MESSAGES(ROW)}},
  };
#undef ROW
  return tables;
}

std::string messages_section(const std::vector<Table> &tables) {
  std::string section;
  for (const Table &table : tables) {
    if (table.heading.empty())
      continue;
    section += "\n### " + table.heading + "\n\n";
    std::vector<std::string> cures; // in the order of their first message
    std::map<std::string, std::string> texts;
    for (const Message &message : table.messages) {
      if (is_of_tool(message))
        continue;
      std::string &line = texts[message.cure];
      if (line.empty())
        cures.push_back(message.cure);
      line += "*" + escaped(first_sentence(readable(message.text))) + "* ";
    }
    for (const std::string &cure : cures)
      section += "* " + texts[cure] + escaped(on_one_line(cure)) + "\n";
  }
  return section + "\n";
}

std::string generated_part(const std::string &page) {
  const Extent part = find_generated_part(page);
  return page.substr(part.begin, part.end - part.begin);
}

std::string with_generated_part(const std::string &page, const std::string &section) {
  const Extent part = find_generated_part(page);
  return page.substr(0, part.begin) + section + page.substr(part.end);
}

} // namespace docs
