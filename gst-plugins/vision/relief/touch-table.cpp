// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief/touch-table.hpp"

#include "builtin-tables.hpp"
#include "key-file.hpp"
#include "messages.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic {
namespace {

constexpr KeyFileMessages kMessages = {messages::kTableUnknown, messages::kTableUnreadable,
                                       messages::kTableKeyMissing, messages::kTableKeyUnknown,
                                       messages::kTableNumber};

// "#rrggbb" to the place of a colour, or nothing.
std::optional<LabColour> parse_colour(const std::string &text) {
  if (text.size() != 7 || text[0] != '#' ||
      !std::all_of(text.begin() + 1, text.end(), [](char c) { return g_ascii_isxdigit(c); }))
    return std::nullopt;
  const auto component = [&](std::size_t at) {
    const int value = 16 * g_ascii_xdigit_value(text[at]) + g_ascii_xdigit_value(text[at + 1]);
    return static_cast<double>(linear_light()[static_cast<std::size_t>(value)]);
  };
  return lab_of({component(1), component(3), component(5)});
}

TouchEntry read_entry(KeyFile &file, double unit) {
  TouchEntry entry;
  const std::string colour = file.need("colour", file.text("colour"));
  const auto place = parse_colour(colour);
  if (!place)
    file.refuse(messages::kTableColour, colour.c_str());
  entry.colour = *place;
  const double most = static_cast<double>(kMostReliefHeight) / unit;
  entry.height = unit * file.need("height", file.number("height", -most, most));
  entry.stiffness = file.need("stiffness", file.number("stiffness", 0, kMostReliefStiffness));
  entry.friction = file.need("friction", file.number("friction", 0, kMostReliefFriction));
  return entry;
}

double squared_distance(const LabColour &p, const LabColour &q) {
  const double lightness = p.lightness - q.lightness;
  return lightness * lightness + (p.a - q.a) * (p.a - q.a) + (p.b - q.b) * (p.b - q.b);
}

// Sums of what entries say, each with its weight.
class Mix {
public:
  void add(const TouchEntry &entry, double weight) {
    weight_ += weight;
    height_ += weight * entry.height;
    stiffness_ += weight * entry.stiffness;
    friction_ += weight * entry.friction;
  }
  ReliefCell mean() const {
    return {static_cast<float>(height_ / weight_), static_cast<float>(stiffness_ / weight_),
            static_cast<float>(friction_ / weight_), 1};
  }

private:
  double weight_ = 0;
  double height_ = 0;
  double stiffness_ = 0;
  double friction_ = 0;
};

} // namespace

// IEC 61966-2-1, section 5.2.
const std::array<float, 256> &linear_light() {
  static const auto table = [] {
    std::array<float, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double value = static_cast<double>(i) / 255;
      light[i] = static_cast<float>(value <= 0.04045 ? value / 12.92
                                                     : std::pow((value + 0.055) / 1.055, 2.4));
    }
    return light;
  }();
  return table;
}

// X, Y, Z of sRGB relative to its white (IEC 61966-2-1), then L* = 116 f(Y) - 16,
// a* = 500 (f(X) - f(Y)), b* = 200 (f(Y) - f(Z)) with f(t) = t^(1/3), and its tangent below
// (6/29)^3 (ISO/CIE 11664-4).
LabColour lab_of(const LinearColour &colour) {
  constexpr double kKnee = 6.0 / 29;
  const auto f = [](double t) {
    return t > kKnee * kKnee * kKnee ? std::cbrt(t) : t / (3 * kKnee * kKnee) + 4.0 / 29;
  };
  const auto &[red, green, blue] = colour;
  const double x = f((0.4124 * red + 0.3576 * green + 0.1805 * blue) / 0.9505);
  const double y = f(0.2126 * red + 0.7152 * green + 0.0722 * blue);
  const double z = f((0.0193 * red + 0.1192 * green + 0.9505 * blue) / 1.089);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

TouchTable::TouchTable(std::vector<TouchEntry> entries, bool by_lightness)
    : entries_(std::move(entries)), by_lightness_(by_lightness) {
  if (by_lightness)
    std::ranges::stable_sort(entries_, {},
                             [](const TouchEntry &entry) { return entry.colour.lightness; });
}

// By colour: the mean with the weights d^-4, d the distance in CIELAB (D. Shepard, "A
// two-dimensional interpolation function for irregularly-spaced data", 1968). The exponent is above
// the three dimensions, so that far entries do not outweigh near ones by their number.
ReliefCell TouchTable::at(const LabColour &colour) const {
  Mix mix;
  if (by_lightness_) {
    const auto above =
        std::ranges::upper_bound(entries_, colour.lightness, {},
                                 [](const TouchEntry &entry) { return entry.colour.lightness; });
    if (above == entries_.begin() || above == entries_.end()) {
      mix.add(above == entries_.begin() ? entries_.front() : entries_.back(), 1);
      return mix.mean();
    }
    const TouchEntry &below = *(above - 1);
    const double part = (colour.lightness - below.colour.lightness) /
                        (above->colour.lightness - below.colour.lightness);
    mix.add(below, 1 - part);
    mix.add(*above, part);
    return mix.mean();
  }
  constexpr double kSame = 0.01; // squared; a tenth of a just noticeable difference
  for (const TouchEntry &entry : entries_) {
    const double distance = std::max(squared_distance(colour, entry.colour), kSame);
    mix.add(entry, 1 / (distance * distance));
  }
  return mix.mean();
}

TouchTable load_touch_table(const std::string &name) {
  KeyFile file(name, kBuiltinTables, kMessages);
  file.enter("table");
  const auto unit = file.unit("unit");
  if (!unit)
    file.refuse(messages::kTableUnit);
  const std::string by = file.text("by").value_or("colour");
  if (by != "colour" && by != "lightness")
    file.refuse(messages::kTableBy, by.c_str());
  std::vector<TouchEntry> entries;
  while (file.enter("entry-" + std::to_string(entries.size() + 1)))
    entries.push_back(read_entry(file, *unit));
  file.refuse_unknown();
  if (entries.empty() || entries.size() > kMostTouchEntries)
    file.refuse(messages::kTableCount, entries.size());
  return {std::move(entries), by == "lightness"};
}

} // namespace haptic
