// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/force-log.hpp"

#include "track-error.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <string_view>

namespace haptic {
namespace {

constexpr std::size_t kMostRows = 15'000'000;   // 4 h
constexpr std::streamsize kLongestLine = 65536; // bytes, with its end
constexpr double kLatest = 1e6;                 // s
constexpr double kStrongest = 1e3;              // N

enum Column : std::size_t { kTime, kForceX, kForceY, kForceZ, kX, kY, kZ, kColumns };
constexpr std::array<std::string_view, kColumns> kNames = {"time", "fx", "fy", "fz", "x", "y", "z"};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  line = line.substr(0, line.find_last_not_of("\r ") + 1);
  for (std::size_t at = 0, end = 0; end < line.size(); at = end + 1) {
    end = std::min(line.find(',', at), line.size());
    cells.push_back(line.substr(at, end - at));
  }
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

class LogReader {
public:
  explicit LogReader(const std::string &path) : path_(path), file_(path) {
    if (!file_)
      throw_error(messages::kFileIsMissing, path.c_str());
    if (!next_line())
      refuse("there is no header");
    places_ = places_in(line_.data());
    if (!has_force(places_))
      refuse("the header has no time, fx and fy");
  }

  ForceLog read() {
    ForceLog log;
    while (next_line()) {
      const auto cells = cells_of(line_.data());
      if (cells.empty())
        continue;
      read_row(cells);
      if (log.forces.size() >= kMostRows)
        refuse("the log is longer than 4 hours");
      append(log);
    }
    return log;
  }

private:
  bool next_line() {
    ++number_;
    if (file_.getline(line_.data(), kLongestLine))
      return true;
    if (!file_.eof())
      refuse("the line is too long");
    return false;
  }

  void read_row(const std::vector<std::string_view> &cells) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      double &value = values_.at(column) = 0;
      if (places_.at(column) == kNowhere)
        continue;
      if (places_.at(column) >= cells.size())
        refuse("columns are missing");
      const std::string_view text = cells[places_.at(column)];
      const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
      if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !std::isfinite(value))
        refuse("there is no number in a column");
    }
    const double force = std::hypot(values_[kForceX], values_[kForceY], values_[kForceZ]);
    if (!(std::abs(values_[kTime]) <= kLatest) || !(force <= kStrongest))
      refuse("a number is out of range");
  }

  void append(ForceLog &log) {
    const double time = values_[kTime];
    if (!log.forces.empty() && time < log.forces.back().time)
      refuse("the time goes back");
    if (!log.forces.empty() && time == log.forces.back().time) {
      log.forces.pop_back();
      if (!log.places.empty())
        log.places.pop_back();
    }
    const auto value = [&](Column column) { return static_cast<float>(values_[column]); };
    log.forces.push_back({time, {value(kForceX), value(kForceY), value(kForceZ)}});
    if (has(places_, {kX, kY})) // equation 1 of the paper
      log.places.push_back(
          {time, static_cast<float>(std::clamp(0.5 + values_[kX] / (2 * kWorkspaceHalf), 0.0, 1.0)),
           static_cast<float>(std::clamp(0.5 - values_[kY] / (2 * kWorkspaceHalf), 0.0, 1.0)),
           static_cast<float>(std::clamp(values_[kZ] / kWorkspaceHalf, -1.0, 1.0))});
  }

  [[noreturn]] void refuse(const char *what) const {
    throw_error(messages::kLogIsWrong, path_.c_str(), number_, what);
  }

  std::string path_;
  std::ifstream file_;
  std::size_t number_ = 0;
  std::vector<char> line_ = std::vector<char>(kLongestLine);
  Places places_ = {};
  std::array<double, kColumns> values_ = {};
};

} // namespace

bool is_force_log(const std::string &path) {
  std::ifstream file(path);
  std::array<char, 4096> line = {};
  file.getline(line.data(), line.size());
  return has_force(places_in(line.data()));
}

ForceLog read_force_log(const std::string &path) {
  return LogReader(path).read();
}

std::vector<TimedPlace> read_hand(const std::string &path) {
  auto hand = read_force_log(path).places;
  if (hand.empty())
    throw_error(messages::kHandIsMissing, path.c_str());
  return hand;
}

} // namespace haptic
