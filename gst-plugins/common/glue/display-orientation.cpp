// SPDX-License-Identifier: LGPL-2.1-or-later
#include "glue/display-orientation.hpp"

#include <algorithm>
#include <array>
#include <fstream>

namespace haptic {
namespace {

// As in pipelines/shared/common.sh. Each picture has a message.
constexpr std::size_t kHeadSize = 1 << 20; // bytes

struct Turn {
  std::string_view orientation;
  const char *direction;
  std::uint8_t code; // anticlockwise, in the message
};

// Cancel and flip flags 0, then the angle in 16 bits, 2^16 a turn.
constexpr std::array<Turn, 3> kTurns = {
    {{"rotate-90", "90r", 0x18}, {"rotate-180", "180", 0x10}, {"rotate-270", "90l", 0x08}}};

const Turn *find_turn(std::string_view orientation) {
  const auto *const turn = std::ranges::find(kTurns, orientation, &Turn::orientation);
  return turn == kTurns.end() ? nullptr : turn;
}

} // namespace

const char *direction_of(std::string_view orientation) {
  const Turn *turn = find_turn(orientation);
  return turn ? turn->direction : "auto";
}

std::vector<std::uint8_t> orientation_unit(std::string_view orientation, bool is_h265) {
  const Turn *turn = find_turn(orientation);
  if (!turn)
    return {};
  // ITU-T H.265, D.2.17: the message holds on. ITU-T H.264, D.1.27: repetition period 1, no
  // extension.
  if (is_h265)
    return {0x4E, 0x01, 0x2F, 3, turn->code, 0, 0x18, 0x80};
  return {0x06, 0x2F, 3, turn->code, 0, 0x09, 0x80};
}

std::string orientation_in(const std::string &path) {
  std::string head(kHeadSize, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  for (const Turn &turn : kTurns)
    for (const bool is_h265 : {false, true}) {
      const auto unit = orientation_unit(turn.orientation, is_h265);
      if (head.find(std::string(unit.begin(), unit.end())) != head.npos)
        return std::string(turn.orientation);
    }
  return {};
}

} // namespace haptic
