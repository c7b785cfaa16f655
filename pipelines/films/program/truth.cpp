// SPDX-License-Identifier: LGPL-2.1-or-later
#include "program/truth.hpp"

#include "hold-point.hpp"
#include "program/film-file.hpp"
#include "samples/region-size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
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

constexpr std::array kKinds{Kind::crown_leaf, Kind::branch, Kind::grass, Kind::blade, Kind::flag};

const char *name_of(Kind kind) {
  constexpr std::array kNames{"other", "crown-leaf", "branch", "grass", "blade", "flag"};
  return kNames[static_cast<std::size_t>(kind)];
}

// Neighbouring parts of one thing move as one.
bool are_of_one_thing(const Thing &a, const Thing &b) {
  return a.kind == b.kind && a.number == b.number;
}

// What a person can point at: more than an edge, and of a leaf or a branch more than a speck.
std::vector<MaterialPoint> candidates_in(const Canvas &canvas, Kind kind) {
  const float scale = static_cast<float>(canvas.height()) / 540;
  const auto margin = static_cast<int>(12 * scale); // px, within which a thing soon leaves
  // Of a frame 1080 px high, 2 px of the thing on all sides, 1 px of a thin one.
  const auto reach = static_cast<int>(
      std::lround(kind == Kind::branch || kind == Kind::blade ? scale / 2 : scale));
  const bool is_thin = kind == Kind::blade;
  // 140 px of a frame 1080 px high, 240 of a branch.
  const auto enough = kind == Kind::crown_leaf ? 35 * scale * scale
                      : kind == Kind::branch   ? 60 * scale * scale
                                               : 0;
  std::map<std::uint32_t, long> area;
  for (int y = 0; y < canvas.height(); ++y)
    for (int x = 0; x < canvas.width(); ++x)
      if (const Thing &thing = canvas.material(x, y).thing; thing.kind == kind)
        ++area[thing.number];
  std::vector<MaterialPoint> found;
  for (int y = margin; y < canvas.height() - margin; ++y)
    for (int x = margin; x < canvas.width() - margin; ++x) {
      const MaterialPoint &here = canvas.material(x, y);
      if (here.thing.kind != kind || static_cast<float>(area[here.thing.number]) < enough)
        continue;
      bool inside = true;
      for (int d = -reach; d <= reach; ++d)
        inside &= are_of_one_thing(here.thing, canvas.material(x + d, y).thing) &&
                  (is_thin || are_of_one_thing(here.thing, canvas.material(x, y + d).thing));
      if (inside)
        found.push_back(here);
    }
  return found;
}

} // namespace

Truth::Truth(const std::string &places, TruthOf of, int width, int height, int rate)
    : of_(of), width_(width), height_(height), rate_(rate) {
  const int side = haptic::default_region_side(width);
  std::istringstream words(places);
  for (std::string word; words >> word;) {
    Place place{word, 0, 0, 0, 0, 0, 0, {}};
    const auto point = haptic::read_hold_point(word);
    if (!point || word.find('@') != std::string::npos)
      throw FilmError("'" + word + "' is no place; write X,Y, each from 0 to 1, like 0.5,0.25");
    place.x = point->x;
    place.y = point->y;
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

MaterialPoints::MaterialPoints(const Scene &scene, int width, int height, std::uint64_t seed) {
  Canvas first(width, height);
  first.follow({});
  scene.draw(first, 0, 1);
  Random random(seed ^ 0x706f696e);
  for (const Kind kind : kKinds) {
    std::vector<MaterialPoint> found = candidates_in(first, kind);
    for (int i = 0; i < kOfEachKind && !found.empty(); ++i) {
      const auto chosen = found.begin() + random.below(static_cast<int>(found.size()));
      points_.push_back(*chosen);
      *chosen = found.back();
      found.pop_back();
    }
  }
}

std::vector<MaterialPoints::Seen> MaterialPoints::measure(const Canvas &canvas) const {
  std::vector<Seen> all;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const MaterialPoint &point = points_[i];
    const Point &place = canvas.points()[i];
    const auto x = static_cast<int>(std::lround(place.x));
    const auto y = static_cast<int>(std::lround(place.y));
    const auto shows = [&](int column, int line) {
      if (column < 0 || column >= canvas.width() || line < 0 || line >= canvas.height())
        return false;
      const MaterialPoint &there = canvas.material(column, line);
      // The cloth can fold over itself.
      constexpr float kSameTexels = 4;
      return are_of_one_thing(there.thing, point.thing) &&
             (point.thing.kind != Kind::flag || length(there.texel - point.texel) < kSameTexels);
    };
    // At an edge, which thing makes a pixel more than half covered is chance.
    const int around = shows(x - 1, y) + shows(x + 1, y) + shows(x, y - 1) + shows(x, y + 1);
    constexpr Point kCentre{0.5F, 0.5F}; // of the top left pixel, from the corner
    all.push_back({place + kCentre, shows(x, y) || around >= 2});
  }
  return all;
}

void MaterialPoints::add(const std::vector<Seen> &seen) {
  for (std::size_t i = 0; i < seen.size(); ++i) {
    std::array<char, 100> line;
    std::snprintf(line.data(), line.size(), "%ld,%zu,%s,%.3f,%.3f,%d\n", count_, i,
                  name_of(points_[i].thing.kind), static_cast<double>(seen[i].place.x),
                  static_cast<double>(seen[i].place.y), seen[i].visible);
    lines_ += line.data();
  }
  ++count_;
}

void MaterialPoints::write(const std::string &path) const {
  const std::string table = "frame,point,kind,x,y,visible\n" + lines_;
  if (!g_file_set_contents(path.c_str(), table.c_str(), static_cast<gssize>(table.size()), nullptr))
    throw FilmError("'" + path + "' cannot be written; give another file to --points");
}

} // namespace film
