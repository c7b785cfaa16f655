// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes the message section of a page again, or prints it:
//
//   messages-page [PAGE]    PAGE contains the two markers, as docs/troubleshooting.md does
#include "messages-page.hpp"

#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>

int main(int argc, char **argv) {
  try {
    const std::string section = docs::messages_section(docs::message_tables());
    if (argc < 2) {
      std::cout << section;
      return EXIT_SUCCESS;
    }
    std::ifstream in(argv[1]);
    const std::string page(std::istreambuf_iterator<char>(in), {});
    const std::string result = docs::with_generated_part(page, section);
    std::ofstream out(argv[1]);
    out << result;
    return out.flush() ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const std::exception &error) {
    std::cerr << "messages-page: " << error.what() << "\n";
    return EXIT_FAILURE;
  }
}
