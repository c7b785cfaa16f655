// SPDX-License-Identifier: LGPL-2.1-or-later
#include "truth.hpp"

#include "film-file.hpp"
#include "samples/region-size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <tuple>
#include <utility>

namespace film {
namespace {

// Moves with the pixel at the place: within this and a share of its own displacement.
constexpr float kAlike = 0.15F; // px
constexpr float kOfDisplacement = 0.25F;

Point displacement(const Motion &motion) {
  return Point{static_cast<float>(motion.x), static_cast<float>(motion.y)} * (1 / kMotionUnits);
}

float length(const Point &point) {
  return std::hypot(point.x, point.y);
}

} // namespace

Truth::Truth(const std::string &places, TruthOf of, int width, int height, int rate)
    : of_(of), width_(width), height_(height), rate_(rate) {
  const int side = haptic::default_region_side(width);
  std::istringstream words(places);
  for (std::string word; words >> word;) {
    Place place{word, 0, 0, 0, 0, 0, 0, {}};
    gchar *end = nullptr;
    place.x = g_ascii_strtod(word.c_str(), &end);
    if (*end == ',')
      place.y = g_ascii_strtod(end + 1, &end);
    if (*end != '\0' || word.find(',') == std::string::npos ||
        !(place.x >= 0 && place.x <= 1 && place.y >= 0 && place.y <= 1))
      throw FilmError("'" + word + "' is no place; write X,Y, each from 0 to 1, like 0.5,0.25");
    // As region_at() of roitracker.
    const auto interval = [side](double at, int length) {
      const int begin = static_cast<int>(std::lround(at * length - side / 2.0));
      return std::pair(std::clamp(begin, 0, length - 1), std::clamp(begin + side, 1, length));
    };
    std::tie(place.left, place.right) = interval(place.x, width);
    std::tie(place.top, place.bottom) = interval(place.y, height);
    place.name[word.find(',')] = '-';
    places_.push_back(place);
  }
  if (places_.empty())
    throw FilmError("--truth needs places: --places '0.5,0.5 0.25,0.75'");
}

std::vector<Point> Truth::measure(const Canvas &canvas) const {
  std::vector<Point> motions;
  for (const Place &place : places_) {
    const auto mean = [&](auto kept) {
      return canvas.mean_motion(place.left, place.top, place.right, place.bottom, kept) *
             static_cast<float>(rate_);
    };
    const auto pixel = [](double at, int length) {
      return std::min(static_cast<int>(at * length), length - 1);
    };
    const Point pointed =
        displacement(canvas.motion(pixel(place.x, width_), pixel(place.y, height_)));
    motions.push_back(mean([&](const Motion &motion) {
      return of_ == TruthOf::square ||
             length(displacement(motion) - pointed) <= kAlike + kOfDisplacement * length(pointed);
    }));
  }
  return motions;
}

void Truth::add(const std::vector<Point> &motions) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place &place = places_[i];
    const auto share = [](int length, int of) { return static_cast<double>(length) / of; };
    std::array<char, 400> line;
    // The numbers of text lines do not follow the locale, and neither does this program.
    std::snprintf(
        line.data(), line.size(),
        "hv1 point t=%.9f d=%.9f i=%.9f vx=%.9g vy=%.9g spin=0 div=0 x=%.9g y=%.9g w=%.9g h=%.9g "
        "conf=1 pic=%dx%d par=1:1 n=1 model=translation\n",
        static_cast<double>(count_) / rate_, 1.0 / rate_, 1.0 / rate_,
        static_cast<double>(motions[i].x), static_cast<double>(motions[i].y), place.x, place.y,
        share(place.right - place.left, width_), share(place.bottom - place.top, height_), width_,
        height_);
    places_[i].lines += line.data();
  }
  ++count_;
}

void Truth::write(const std::string &folder) const {
  g_mkdir_with_parents(folder.c_str(), 0777);
  for (const Place &place : places_) {
    const std::string path = folder + "/" + place.name + ".txt";
    if (!g_file_set_contents(path.c_str(), place.lines.c_str(),
                             static_cast<gssize>(place.lines.size()), nullptr))
      throw FilmError("'" + path + "' cannot be written; give another folder to --truth");
  }
}

} // namespace film
