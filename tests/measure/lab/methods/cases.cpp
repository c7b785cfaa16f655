// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/cases.hpp"

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace lab {
namespace {

const cv::Size kCif(352, 288);
constexpr int kSide = 30;

Case make_case(const Movie &movie, Random &random, cv::Size size = kCif, int side = kSide) {
  Case result;
  result.bound = cramer_rao_bound(movie.light(0), side, movie.noise);
  const auto [previous, current] = expose_pair(movie, random);
  result.task = {embed(previous, size), embed(current, size), {0.5, 0.5}, side};
  result.truth = movie.velocity;
  result.is_unseen = movie.is_unseen;
  return result;
}

template <typename Make>
CaseSet set_of(const std::string &name, double x, int count, const Make &make, cv::Size size = kCif,
               int side = kSide) {
  CaseSet set{name, {}, x};
  Random random(seed_of(name + std::to_string(x)));
  for (int i = 0; i < count; ++i) {
    set.cases.push_back(make_case(make(random), random, size, side));
    set.cases.back().block = i;
  }
  return set;
}

} // namespace

std::uint64_t seed_of(const std::string &name) {
  std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a
  for (const char c : name)
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

CaseSet hard_set(int per_scene, int number) {
  CaseSet all{"hard", {}};
  for (const Scene &scene : hard_scenes(kSide)) {
    CaseSet some = set_of(scene.name, number, per_scene, scene.make);
    for (Case &one : some.cases) {
      one.scene = scene.name;
      one.block = static_cast<int>(all.cases.size());
      all.cases.push_back(std::move(one));
    }
  }
  return all;
}

// Regions on a raster. Leaves out a region with a part of unknown flow, unless the whole truth is
// sparse.
CaseSet pairs_set(const std::vector<TruePair> &pairs, int raster) {
  constexpr int kFromBorder = 4;       // px
  constexpr int kBlock = 60;           // px; regions this far apart have nothing in common
  constexpr double kLeastKnown = 0.95; // of a region's pixels where the truth is dense
  constexpr double kLeastSparse = 0.2;
  CaseSet set{"pairs", {}};
  int block_base = 0;
  for (const TruePair &pair : pairs) {
    const cv::Size size = pair.previous.size();
    cv::Mat1b known(size);
    cv::Mat2f flow = pair.flow.clone();
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        known(y, x) = std::isfinite(flow(y, x)[0]) ? 255 : 0;
        if (!known(y, x))
          flow(y, x) = {};
      }
    const double overall = cv::countNonZero(known) / static_cast<double>(known.total());
    const double least = overall > 0.6 ? kLeastKnown : kLeastSparse;
    const int across = size.width / kBlock + 1;
    for (int y = kFromBorder; y + kSide + kFromBorder <= size.height; y += raster)
      for (int x = kFromBorder; x + kSide + kFromBorder <= size.width; x += raster) {
        const cv::Rect region(x, y, kSide, kSide);
        if (cv::countNonZero(known(region)) < least * kSide * kSide)
          continue;
        const cv::Scalar mean = cv::mean(flow(region), known(region));
        Case one;
        one.task = {pair.previous,
                    pair.current,
                    {(x + kSide / 2.0) / size.width, (y + kSide / 2.0) / size.height},
                    kSide};
        one.truth = {mean[0], mean[1]};
        one.block = block_base + y / kBlock * across + x / kBlock;
        one.scene = pair.name;
        set.cases.push_back(std::move(one));
      }
    block_base += across * (size.height / kBlock + 1);
  }
  return set;
}

std::vector<CaseSet> strata(bool quick, const std::vector<TruePair> &pairs) {
  const int count = quick ? 24 : 200;
  std::vector<CaseSet> all;
  all.push_back(
      set_of("translation", 0, count, [](Random &r) { return uniform_translation(r, 3); }));
  all.push_back(set_of("wide", 0, count, [](Random &r) { return uniform_translation(r, 12); }));
  if (!pairs.empty())
    all.push_back(pairs_set(pairs, quick ? 45 : 15));
  all.push_back(hard_set(quick ? 1 : 6));
  return all;
}

std::vector<Series> all_series(bool quick) {
  const int count = quick ? 6 : 30;
  const auto varied = [&](const std::string &name, const std::vector<double> &values,
                          const auto &make) {
    Series series{name, {}};
    for (const double x : values)
      series.sets.push_back(set_of(name, x, count, [&](Random &r) { return make(r, x); }));
    return series;
  };
  std::vector<Series> all;
  all.push_back(
      varied("displacement",
             quick ? std::vector<double>{1, 8, 16, 24}
                   : std::vector<double>{0.5, 1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32},
             [](Random &r, double distance) {
               const Vector velocity = on_circle(r, distance);
               return translation(r, velocity);
             }));
  std::vector<double> phases;
  for (int i = 0; i < 16; i += quick ? 4 : 1)
    phases.push_back(i / 16.0);
  all.push_back(varied("phase", phases, [](Random &r, double phase) {
    return translation(r, {1 + phase, -phase});
  }));
  all.push_back(varied("noise",
                       quick ? std::vector<double>{1.5, 10}
                             : std::vector<double>{0, 1.5, 3, 5, 7, 10, 15, 20},
                       [](Random &r, double sigma) { return uniform_translation(r, 3, sigma); }));
  all.push_back(varied("contrast",
                       quick ? std::vector<double>{0.05, 1}
                             : std::vector<double>{0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1},
                       [](Random &r, double contrast) {
                         const Vector velocity(r.uniform(-3, 3), r.uniform(-3, 3));
                         return translation(r, velocity, contrast);
                       }));
  Series frame{"frame", {}};
  for (const cv::Size size : {cv::Size(352, 288), cv::Size(640, 480), cv::Size(1280, 720),
                              cv::Size(1920, 1080), cv::Size(3840, 2160)})
    if (!quick || size.width <= 640)
      frame.sets.push_back(set_of(
          "frame", size.area() / 1e6, quick ? 4 : 10,
          [](Random &r) { return uniform_translation(r, 3); }, size));
  all.push_back(std::move(frame));
  Series region{"region", {}};
  for (const int side : {16, 24, 30, 45, 64, 96, 128})
    if (!quick || side <= 30)
      region.sets.push_back(set_of(
          "region", side, quick ? 4 : 12,
          [side](Random &r) {
            const Vector velocity(r.uniform(-3, 3), r.uniform(-3, 3));
            return translation(r, velocity, 1, std::max(kWindow, 5 * side / 2));
          },
          cv::Size(640, 480), side));
  all.push_back(std::move(region));
  return all;
}

CaseSet points_set(bool quick) {
  constexpr int kLarge = 60; // px
  return set_of("points", 0, quick ? 6 : 30, scene_named(hard_scenes(kLarge), "rotation").make,
                kCif, kLarge);
}

std::vector<Stream> streams(bool quick) {
  const int per_scene = quick ? 1 : 6;
  constexpr int kFrames = 10;
  const auto scenes = hard_scenes(kSide);
  std::vector<Stream> all;
  const auto add = [&](const std::string &name, const auto &make, bool duplicate = false) {
    Random random(seed_of("stream " + name));
    for (int i = 0; i < per_scene; ++i) {
      const Movie movie = make(random);
      Stream stream{name, {}};
      for (int time = 0; time < kFrames; ++time)
        stream.frames.push_back(duplicate && time > 0 ? stream.frames.front().clone()
                                                      : embed(expose(movie, time, random), kCif));
      all.push_back(std::move(stream));
    }
  };
  const auto gentle = [](Random &r) { return uniform_translation(r, 3); };
  add("same pixels", gentle, true);
  add("still noise", scene_named(scenes, "still noise 1.5").make);
  add("no texture", scene_named(scenes, "textureless").make);
  add("translation", gentle);
  add("rotation", scene_named(scenes, "rotation").make);
  add("affine", scene_named(scenes, "affine").make);
  add("two motions", scene_named(scenes, "two motions").make);
  add("bars", scene_named(scenes, "aperture").make);
  // Each frame shows another scene.
  add("cuts", [](Random &r) {
    const std::uint64_t seed = r.bits();
    return Movie{.light = [seed](double time) {
      Random own(seed + static_cast<std::uint64_t>(time));
      return DeadLeaves(own).render({});
    }};
  });
  return all;
}

std::vector<ClipCase> clip_cases(const std::vector<Clip> &clips) {
  // Means over 2x2 pixels: a shift by one original pixel is then exactly half a pixel.
  constexpr int kFiner = 2;
  constexpr int kMost = 3 * kFiner; // original pixels
  constexpr int kRaster = 60;
  Random random(seed_of("clips"));
  std::vector<ClipCase> all;
  int block = 0;
  for (const Clip &clip : clips)
    for (std::size_t i = 1; i < clip.frames.size(); ++i) {
      const cv::Size inner((clip.frames[0].cols - 2 * kMost) / kFiner * kFiner,
                           (clip.frames[0].rows - 2 * kMost) / kFiner * kFiner);
      const auto reduced = [&](const cv::Mat &frame, cv::Point from) {
        cv::Mat small;
        cv::resize(frame(cv::Rect(from, inner)), small, inner / kFiner, 0, 0, cv::INTER_AREA);
        return small;
      };
      const auto any = [&] { return static_cast<int>(random.index(2 * kMost + 1)) - kMost; };
      const int right = any();
      const int down = any();
      const cv::Mat before = reduced(clip.frames[i - 1], {kMost, kMost});
      const cv::Mat after = reduced(clip.frames[i], {kMost, kMost});
      const cv::Mat moved = reduced(clip.frames[i], {kMost - right, kMost - down});
      for (int y = kSide; y + kSide <= before.rows; y += kRaster)
        for (int x = kSide; x + kSide <= before.cols; x += kRaster) {
          const Vector pointer(static_cast<double>(x) / before.cols,
                               static_cast<double>(y) / before.rows);
          all.push_back({clip.name,
                         {before, after, pointer, kSide},
                         {before, moved, pointer, kSide},
                         {after, before, pointer, kSide},
                         Vector(right, down) / kFiner,
                         block++});
        }
    }
  return all;
}

} // namespace lab
