// SPDX-License-Identifier: LGPL-2.1-or-later
#include "truth.hpp"

#include "film-file.hpp"
#include "samples/region-size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace film {
namespace {

// Moves with the pixel in the middle: within this and a share of its own displacement.
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
    const auto from = [side](double at, int length) {
      return static_cast<int>(std::lround(at * length - side / 2.0));
    };
    const int left = from(place.x, width);
    const int top = from(place.y, height);
    place.left = std::clamp(left, 0, width - 1);
    place.top = std::clamp(top, 0, height - 1);
    place.right = std::clamp(place.left + side, 1, width);
    place.bottom = std::clamp(place.top + side, 1, height);
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
    const Point middle =
        displacement(canvas.motion((place.left + place.right) / 2, (place.top + place.bottom) / 2));
    motions.push_back(mean([&](const Motion &motion) {
      return of_ == TruthOf::square ||
             length(displacement(motion) - middle) <= kAlike + kOfDisplacement * length(middle);
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
