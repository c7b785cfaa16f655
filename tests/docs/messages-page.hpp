// SPDX-License-Identifier: LGPL-2.1-or-later
// The section of docs/troubleshooting.md that lists the messages, generated from the rooms' tables.
#pragma once

#include <string>
#include <vector>

namespace docs {

struct Message {
  std::string name;
  std::string text; ///< printf format
  std::string cure;
};

struct Table {
  std::string heading; ///< empty: messages of command line tools, which the page leaves out
  std::vector<Message> messages;
};

/// The tables of all rooms, in the order of the page.
std::vector<Table> message_tables();

/// The Markdown between the two markers: the first sentence of each message, with its arguments as
/// "…", and the cure. Messages with the same cure share a line.
std::string messages_section(const std::vector<Table> &tables);

/// Returns the text between the markers of a page. Throws std::runtime_error if one is missing.
std::string generated_part(const std::string &page);

/// Returns the page with another text between its markers.
std::string with_generated_part(const std::string &page, const std::string &section);

} // namespace docs
