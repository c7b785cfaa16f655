// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/force-log.hpp"

#include "part-file.hpp"
#include "track-error.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <ranges>
#include <string_view>

namespace haptic {
namespace {

constexpr std::streamsize kLongestLine = 65536; // bytes, with its end
constexpr double kLatest = 1e6;                 // s
constexpr double kStrongest = 1e3;              // N

enum Column : std::size_t { kTime, kForceX, kForceY, kForceZ, kX, kY, kZ, kColumns };
constexpr std::array<std::string_view, kColumns> kNames = {"time", "fx", "fy", "fz", "x", "y", "z"};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  line = line.substr(0, line.find_last_not_of("\r ") + 1);
  for (const auto cell : line | std::views::split(','))
    cells.emplace_back(cell.begin(), cell.end());
  return cells;
}

// Where the columns stand in a line, or nowhere.
using Places = std::array<std::size_t, kColumns>;
constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

Places places_in(std::string_view header) {
  const auto cells = cells_of(header);
  Places places;
  std::ranges::transform(kNames, places.begin(), [&](std::string_view name) {
    const auto found = std::ranges::find(cells, name);
    return found == cells.end() ? kNowhere : static_cast<std::size_t>(found - cells.begin());
  });
  return places;
}

bool has(const Places &places, std::initializer_list<Column> columns) {
  return std::ranges::none_of(columns, [&](Column one) { return places[one] == kNowhere; });
}

bool has_force(const Places &places) {
  return has(places, {kTime, kForceX, kForceY});
}

} // namespace

bool is_force_log(const std::string &path) {
  const std::string start = read_start(path, 4096);
  return has_force(places_in(start.substr(0, start.find('\n'))));
}

ForceLog read_force_log(const std::string &path) {
  std::ifstream file(path);
  if (!file)
    throw_error(messages::kFileIsMissing, path.c_str());
  std::size_t number = 1; // of the line
  const auto refuse = [&](const char *what) {
    throw_error(messages::kLogIsWrong, path.c_str(), number, what);
  };
  std::vector<char> line(kLongestLine);
  file.getline(line.data(), kLongestLine);
  const Places places = places_in(line.data());
  if (!has_force(places))
    refuse("the header has no time, fx and fy");
  ForceLog log;
  for (++number; file.getline(line.data(), kLongestLine); ++number) {
    const auto cells = cells_of(line.data());
    if (cells.empty())
      continue;
    std::array<double, kColumns> values = {};
    for (std::size_t column = 0; column < kColumns; ++column) {
      if (places.at(column) == kNowhere)
        continue;
      if (places.at(column) >= cells.size())
        refuse("columns are missing");
      const std::string_view text = cells[places.at(column)];
      double &value = values.at(column);
      const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
      if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !std::isfinite(value))
        refuse("there is no number in a column");
    }
    const double time = values[kTime];
    const double force = std::hypot(values[kForceX], values[kForceY], values[kForceZ]);
    if (!(std::abs(time) <= kLatest) || !(force <= kStrongest))
      refuse("a number is out of range");
    if (!log.forces.empty() && time < log.forces.back().time)
      refuse("the time goes back");
    if (!log.forces.empty() && time == log.forces.back().time) {
      log.forces.pop_back();
      if (!log.places.empty())
        log.places.pop_back();
    }
    const auto value = [&](Column column) { return static_cast<float>(values[column]); };
    log.forces.push_back({time, {value(kForceX), value(kForceY), value(kForceZ)}});
    if (has(places, {kX, kY})) // equation 1 of the paper
      log.places.push_back(
          {time, static_cast<float>(std::clamp(0.5 + values[kX] / (2 * kWorkspaceHalf), 0.0, 1.0)),
           static_cast<float>(std::clamp(0.5 - values[kY] / (2 * kWorkspaceHalf), 0.0, 1.0)),
           static_cast<float>(std::clamp(values[kZ] / kWorkspaceHalf, -1.0, 1.0))});
  }
  if (!file.eof())
    refuse("the line is too long");
  return log;
}

std::vector<TimedPlace> read_hand(const std::string &path, double begin) {
  auto hand = read_force_log(path).places;
  if (hand.empty())
    throw_error(messages::kHandIsMissing, path.c_str());
  for (TimedPlace &place : hand)
    place.time += begin;
  return hand;
}

} // namespace haptic
