// SPDX-License-Identifier: LGPL-2.1-or-later
#include "fail.hpp"
#include "spidar/simulator.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

namespace spidar {

namespace {

std::string_view trimmed(std::string_view text) {
  constexpr const char *kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos)
    return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

/// Numbers separated by commas; empty if any of them is not a finite number.
std::vector<double> numbers(std::string_view text) {
  std::vector<double> values;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::string_view part = trimmed(text.substr(0, comma));
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size() || !std::isfinite(value))
      return {};
    values.push_back(value);
    if (comma == std::string_view::npos)
      return values;
    text.remove_prefix(comma + 1);
  }
}

bool within_workspace(double value) {
  return std::abs(value) <= 1;
}

class Free final : public HandScript {
public:
  bool target(double, const Vector3 &, Vector3 &) const noexcept override { return false; }
};

class Hold final : public HandScript {
public:
  explicit Hold(const Vector3 &place) : place_(place) {}
  bool target(double, const Vector3 &half, Vector3 &target) const noexcept override {
    target = place_.cwiseProduct(half);
    return true;
  }

private:
  Vector3 place_;
};

class Circle final : public HandScript {
public:
  Circle(double radius, double period) : radius_(radius), period_(period) {}
  bool target(double time, const Vector3 &half, Vector3 &target) const noexcept override {
    const double angle = 2 * std::numbers::pi * time / period_;
    target = radius_ * Vector3(std::cos(angle), std::sin(angle), 0).cwiseProduct(half);
    return true;
  }

private:
  double radius_;
  double period_;
};

class Recorded final : public HandScript {
public:
  struct Point {
    double time;
    Vector3 place;
    bool presses; ///< from this time on
  };
  explicit Recorded(std::vector<Point> points) : points_(std::move(points)) {}

  bool target(double time, const Vector3 &half, Vector3 &target) const noexcept override {
    const auto next = std::upper_bound(points_.begin(), points_.end(), time,
                                       [](double t, const Point &point) { return t < point.time; });
    Vector3 place;
    if (next == points_.begin()) {
      place = next->place;
    } else if (next == points_.end()) {
      place = points_.back().place;
    } else {
      const Point &before = *(next - 1);
      const double share = (time - before.time) / (next->time - before.time);
      place = before.place + share * (next->place - before.place);
    }
    target = place.cwiseProduct(half);
    return true;
  }
  bool presses(double time) const noexcept override {
    const auto next = std::upper_bound(points_.begin(), points_.end(), time,
                                       [](double t, const Point &point) { return t < point.time; });
    return next != points_.begin() && (next - 1)->presses;
  }

private:
  std::vector<Point> points_; ///< never empty, times increasing
};

std::unique_ptr<HandScript> read_file(const std::string &path) {
  std::error_code unknown;
  std::ifstream file;
  if (!std::filesystem::is_fifo(path, unknown)) // opening it would wait for a writer
    file.open(path);
  if (!file.is_open())
    fail(Cause::not_found, messages::kHandScriptMissing, path.c_str());
  std::vector<Recorded::Point> points;
  std::size_t number = 0;
  const auto refuse = [&](const char *reason) {
    fail(Cause::argument, messages::kHandScriptLine, path.c_str(), number, reason);
  };
  std::array<char, 512> line; // what is longer is no hand script
  while (file.getline(line.data(), line.size()) || file.gcount() > 0) {
    ++number;
    if (!file && !file.eof())
      refuse("too long");
    const std::string_view text = trimmed(line.data());
    if (text.empty() || text.front() == '#')
      continue;
    const std::vector<double> values = numbers(text);
    if (values.size() != 4 && values.size() != 5)
      refuse("expected four numbers t,x,y,z, or five with pressed");
    if (!points.empty() && values[0] <= points.back().time)
      refuse("the time must be later than in the line before");
    if (!std::all_of(values.begin() + 1, values.begin() + 4, within_workspace))
      refuse("x, y and z must be from -1 to 1");
    const double presses = values.size() == 5 ? values[4] : 0;
    if (presses != 0 && presses != 1)
      refuse("pressed must be 0 or 1");
    points.push_back({values[0], {values[1], values[2], values[3]}, presses == 1});
  }
  if (file.bad() || points.empty())
    fail(Cause::argument, messages::kHandScriptEmpty, path.c_str());
  return std::make_unique<Recorded>(std::move(points));
}

} // namespace

std::unique_ptr<HandScript> parse_hand_script(const std::string &text) {
  const auto refuse = [&](const std::string &reason) {
    fail(Cause::argument, messages::kHandScript, text.c_str(), reason.c_str());
  };
  if (text == "free")
    return std::make_unique<Free>();
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (kind == "hold") {
    const std::vector<double> place = numbers(rest);
    if (place.size() != 3 || !std::all_of(place.begin(), place.end(), within_workspace))
      refuse("hold needs three numbers from -1 to 1");
    return std::make_unique<Hold>(Vector3(place[0], place[1], place[2]));
  }
  if (kind == "circle") {
    const std::vector<double> values = numbers(rest);
    if (values.size() != 2 || !within_workspace(values[0]))
      refuse("circle needs a radius from -1 to 1 and a period");
    if (values[1] < 0.1)
      refuse("the period must be at least 0.1 s");
    return std::make_unique<Circle>(values[0], values[1]);
  }
  if (kind == "file") {
    if (rest.empty())
      refuse("file needs a path");
    return read_file(rest);
  }
  refuse("nothing known by the name '" + kind + "'");
  return nullptr;
}

} // namespace spidar
