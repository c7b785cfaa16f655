// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes raw 8-bit grey frames of known motion to the standard output.
//
//   make-clip WIDTH HEIGHT FRAMES-PER-SECOND SECONDS SCENE
//
// SCENE is `uniform:VX,VY`, everything moving at so many px/s (x right, y down),
// `halves:VX,VY,VX,VY`, the left half moving one way and the right half another, or `leaf`,
// everything swinging to the left and right like a leaf in the wind.
#include "leaf.hpp"
#include "moving-texture.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

struct Velocity {
  double x = 0; // px/s
  double y = 0; // px/s
};

// One velocity for each part of the frame, from left to right; none if the text is no scene.
std::vector<Velocity> parse_scene(const char *scene) {
  Velocity a;
  Velocity b;
  char rest = 0;
  if (std::sscanf(scene, "uniform:%lf,%lf%c", &a.x, &a.y, &rest) == 2) {
    return {a};
  }
  if (std::sscanf(scene, "halves:%lf,%lf,%lf,%lf%c", &a.x, &a.y, &b.x, &b.y, &rest) == 4) {
    return {a, b};
  }
  return {};
}

int write_clip(int width, int height, double rate, double seconds,
               const std::vector<Velocity> &parts, bool is_leaf) {
  const test::Texture texture(7);
  test::Frame frame(width, height);
  const int frames = static_cast<int>(std::lround(rate * seconds));
  const int count = static_cast<int>(parts.size());
  for (int index = 0; index < frames; ++index) {
    const double time = index / rate;
    for (int i = 0; i < count; ++i) {
      const double swing = is_leaf ? test::Leaf::position(time) : 0;
      texture.paint(frame, {parts[i].x * time + swing, parts[i].y * time}, i * width / count,
                    (i + 1) * width / count);
    }
    const auto &pixels = frame.pixels;
    if (std::fwrite(pixels.data(), 1, pixels.size(), stdout) != pixels.size()) {
      return EXIT_FAILURE;
    }
  }
  return std::fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

} // namespace

int main(int argc, char **argv) {
  if (argc == 6) {
    const int width = std::atoi(argv[1]);
    const int height = std::atoi(argv[2]);
    const double rate = std::atof(argv[3]);
    const double seconds = std::atof(argv[4]);
    const bool is_leaf = std::strcmp(argv[5], "leaf") == 0;
    const auto parts = is_leaf ? std::vector<Velocity>(1) : parse_scene(argv[5]);
    if (width > 0 && height > 0 && rate > 0 && seconds > 0 && !parts.empty()) {
      return write_clip(width, height, rate, seconds, parts, is_leaf);
    }
  }
  std::fputs("usage: make-clip WIDTH HEIGHT FRAMES-PER-SECOND SECONDS "
             "uniform:VX,VY | halves:VX,VY,VX,VY | leaf\n",
             stderr);
  return EXIT_FAILURE;
}
