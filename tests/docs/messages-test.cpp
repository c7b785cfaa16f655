// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that a user can see stands in a table with its cure, and docs/troubleshooting.md
// shows these tables.
#include "messages-page.hpp"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <regex>
#include <set>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = SOURCE_ROOT;

std::string contents(const fs::path &path) {
  std::ifstream file(path);
  EXPECT_TRUE(file.is_open()) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Messages, EveryRoomHasSome) {
  EXPECT_EQ(docs::message_tables().size(), 6U); // five rooms, one of them with tools
  for (const docs::Table &table : docs::message_tables())
    EXPECT_FALSE(table.messages.empty()) << table.heading;
}

TEST(Messages, EveryCureIsASentence) {
  for (const docs::Table &table : docs::message_tables())
    for (const docs::Message &message : table.messages) {
      SCOPED_TRACE(message.name);
      ASSERT_FALSE(message.cure.empty());
      EXPECT_FALSE(std::islower(static_cast<unsigned char>(message.cure.front())));
      EXPECT_EQ(message.cure.back(), '.');
      EXPECT_NE(message.cure.find(' '), std::string::npos) << "one word is no cure";
      EXPECT_EQ(message.cure.find('%'), std::string::npos) << "a cure takes no arguments";
    }
}

TEST(Messages, NoNameRepeats) {
  std::set<std::string> names;
  for (const docs::Table &table : docs::message_tables())
    for (const docs::Message &message : table.messages)
      EXPECT_TRUE(names.insert(message.name).second) << message.name;
}

TEST(Messages, TroubleshootingShowsTheTables) {
  EXPECT_EQ(docs::generated_part(contents(kRoot / "docs/troubleshooting.md")),
            docs::messages_section(docs::message_tables()))
      << "Write it again: build/tests/docs/messages-page docs/troubleshooting.md";
}

// GST_ELEMENT_ERROR(element, domain, code, (text, ...), (debug text, ...)). The text "%s" hands on
// another's text.
TEST(Messages, NoElementPostsALiteralText) {
  static const std::regex literal(
      R"re(GST_ELEMENT_(?:ERROR|WARNING|INFO)\s*\([^,]*,\s*\w+,\s*\w+,\s*\(\s*"((?:[^"\\]|\\.)*)")re");
  for (const auto &entry : fs::recursive_directory_iterator(kRoot / "gst-plugins")) {
    const fs::path &path = entry.path();
    if (path.extension() != ".cpp" && path.extension() != ".hpp")
      continue;
    const std::string source = contents(path);
    for (std::sregex_iterator match(source.begin(), source.end(), literal), end; match != end;
         ++match)
      EXPECT_EQ(match->str(1), "%s") << path << ": put the text into messages.hpp";
  }
}

} // namespace
