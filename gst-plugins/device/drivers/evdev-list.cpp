// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/evdev-list.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <fstream>
#include <linux/input.h>
#include <system_error>

namespace haptic {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path &file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

// The kernel writes a set of bits as words of a long, the highest first.
bool has_bit(const std::string &words, unsigned bit) {
  constexpr unsigned kBits = 8 * sizeof(unsigned long);
  std::size_t end = words.size();
  for (unsigned word = 0; end != std::string::npos && end > 0; ++word) {
    const std::size_t space = words.rfind(' ', end - 1);
    const std::size_t begin = space == std::string::npos ? 0 : space + 1;
    if (word == bit / kBits) {
      unsigned long value = 0;
      std::from_chars(words.data() + begin, words.data() + end, value, 16);
      return value >> (bit % kBits) & 1;
    }
    end = space;
  }
  return false;
}

int number_of(const std::string &path) {
  int number = 0;
  const std::size_t digits = path.find_last_not_of("0123456789") + 1;
  std::from_chars(path.data() + digits, path.data() + path.size(), number);
  return number;
}

std::string identity_of(const fs::path &device) {
  std::string identity;
  for (const char *file : {"id/bustype", "id/vendor", "id/product", "id/version", "uniq", "name"})
    identity += (identity.empty() ? "" : " ") + first_line(device / file);
  return identity;
}

} // namespace

EvdevUnits list_evdev(const fs::path &input_class) {
  EvdevUnits units;
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(input_class, error)) {
    const std::string node = entry.path().filename();
    if (!node.starts_with("event"))
      continue;
    const fs::path device = entry.path() / "device";
    const std::string axes = first_line(device / "capabilities/abs");
    const std::string keys = first_line(device / "capabilities/key");
    const bool stick = has_bit(axes, ABS_X) || has_bit(axes, ABS_WHEEL);
    const bool buttons =
        has_bit(keys, BTN_JOYSTICK) || has_bit(keys, BTN_GAMEPAD) || has_bit(keys, BTN_WHEEL);
    const std::string forces = first_line(device / "capabilities/ff");
    const bool force = has_bit(forces, FF_CONSTANT) || has_bit(forces, FF_RUMBLE);
    const EvdevUnit unit{"/dev/input/" + node, first_line(device / "name"), identity_of(device)};
    if (stick && force)
      units.with_force.push_back(unit);
    else if (stick && buttons)
      units.without.push_back(unit);
  }
  for (auto *list : {&units.with_force, &units.without})
    std::ranges::sort(*list, {}, [](const EvdevUnit &unit) { return number_of(unit.path); });
  return units;
}

std::string find_evdev(const std::string &identity, const fs::path &input_class) {
  const std::vector<EvdevUnit> units = list_evdev(input_class).with_force;
  const auto found = std::ranges::find(units, identity, &EvdevUnit::identity);
  return found == units.end() ? "" : found->path;
}

} // namespace haptic
