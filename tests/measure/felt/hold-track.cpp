// SPDX-License-Identifier: LGPL-2.1-or-later
// Holds points of a track as hapticsink does:
//
//   hold-track TRACK RATE STARTS > said.csv
//
// TRACK has motion fields, with the things that `haptic-track author --hold` followed. RATE is the
// number of frames a second. STARTS and the table that is printed are those of hold-run.
#include "cpu-time.hpp"
#include "motion/field-hold.hpp"
#include "tracks/field-track.hpp"
#include "tracks/track-file.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <gst/gst.h>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Point {
  long frame = 0; // in which it is pressed
  double x = 0;   // px
  double y = 0;
  haptic::FieldHold hold;
};

std::vector<Point> read_starts(const char *path) {
  std::ifstream file(path);
  std::vector<Point> points;
  Point read;
  for (char comma = 0; file >> read.frame >> comma >> read.x >> comma >> read.y;)
    points.push_back(read);
  if (points.empty())
    throw std::runtime_error(std::string("'") + path + "' has no points");
  return points;
}

void hold(Point &point, std::size_t index, long frame, const haptic::MotionField &field) {
  if (frame < point.frame)
    return;
  const double begin = test::cpu_microseconds();
  if (point.hold.is_pressed())
    point.hold.step(field);
  else
    point.hold.press({.x = point.x / field.frame_width, .y = point.y / field.frame_height}, field);
  const double spent = test::cpu_microseconds() - begin;
  const haptic::HeldPlace &held = point.hold.sample().held;
  std::printf(
      "%ld,%zu,%.3f,%.3f,%d,%.1f\n", frame, index, static_cast<double>(held.x) * field.frame_width,
      static_cast<double>(held.y) * field.frame_height, static_cast<int>(held.state), spent);
}

void run(const char *path, double rate, std::vector<Point> points) {
  const haptic::TrackFile track = haptic::read_track_file(path);
  const std::uint64_t origin =
      track.film_begin == haptic::kNoTime ? track.fields.at(0).time : track.film_begin;
  std::puts("frame,point,x,y,state,us");
  haptic::for_each_field(track.fields, [&](const haptic::MotionField &field, std::uint64_t time) {
    const auto since = static_cast<std::int64_t>(time - origin);
    const long frame = std::lround(1e-9 * static_cast<double>(since) * rate);
    for (std::size_t i = 0; i < points.size(); ++i)
      hold(points[i], i, frame, field);
  });
}

} // namespace

int main(int argc, char **argv) {
  try {
    gst_init(nullptr, nullptr);
    const double rate = argc == 4 ? std::atof(argv[2]) : 0;
    if (!(rate > 0))
      throw std::runtime_error("give a track, the frames a second, and the file of the starts");
    run(argv[1], rate, read_starts(argv[3]));
    return EXIT_SUCCESS;
  } catch (const std::exception &wrong) {
    std::fprintf(stderr, "hold-track: %s\n", wrong.what());
    return EXIT_FAILURE;
  }
}
