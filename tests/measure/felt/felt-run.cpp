// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs a method of the lab, as it is shipped, on the region of roitracker at places of a film:
//
//   felt-run METHOD FOLDER PLACES < film.y4m
//
// METHOD is a name of the lab, such as Farneback; PLACES are "X,Y X,Y ...", 0 to 1 from the top
// left. FOLDER gets a text track X-Y.txt for each place. Prints the median of the processor time
// of a frame, in µs.
#include "cpu-time.hpp"
#include "methods/methods.hpp"
#include "tracking/region.hpp"
#include "y4m-reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <iostream>

namespace {

struct Place {
  std::string name; // of its file
  lab::Vector pointer;
  std::unique_ptr<lab::Method> method;
  std::string lines;
};

lab::Configuration shipped(const std::string &name) {
  auto list = lab::configurations(true);
  const auto found = std::ranges::find_if(
      list, [&](const auto &one) { return one.is_default && one.method == name; });
  if (found == list.end())
    throw std::runtime_error("the lab has no method '" + name + "'");
  return *found;
}

std::vector<Place> read_places(const std::string &text, const lab::Configuration &configuration) {
  std::vector<Place> places;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    Place place{word, {}, configuration.make(), {}};
    if (std::sscanf(word.c_str(), "%lf,%lf", &place.pointer.x, &place.pointer.y) != 2)
      throw std::runtime_error("'" + word + "' is no place; write X,Y");
    std::ranges::replace(place.name, ',', '-');
    places.push_back(std::move(place));
  }
  return places;
}

void write_line(Place &place, int number, double seconds, const cv::Mat &frame,
                const lab::Reading &reading) {
  const lab::Vector velocity = reading.velocity / seconds;
  const double side = haptic::default_region_side(frame.cols);
  std::array<char, 400> line;
  std::snprintf(line.data(), line.size(),
                "hv1 point t=%.9f d=%.9f i=%.9f vx=%.9g vy=%.9g spin=0 div=0 x=%.9g y=%.9g w=%.9g "
                "h=%.9g conf=%g pic=%dx%d par=1:1 n=1 model=translation\n",
                number * seconds, seconds, seconds, velocity.x, velocity.y, place.pointer.x,
                place.pointer.y, side / frame.cols, side / frame.rows, reading.confidence,
                frame.cols, frame.rows);
  place.lines += line.data();
}

void run(std::vector<Place> &places) {
  std::ios::sync_with_stdio(false);
  test::Y4mReader reader(std::cin);
  cv::Mat frame;
  cv::Mat before;
  std::vector<double> times;
  for (int number = 0; reader.next(frame); ++number) {
    for (Place &place : places) {
      lab::Reading reading;
      if (number > 0) {
        const double begin = test::cpu_microseconds();
        reading = place.method->measure({.previous = before,
                                         .current = frame,
                                         .pointer = place.pointer,
                                         .side = haptic::default_region_side(frame.cols),
                                         .continues = number > 1});
        times.push_back(test::cpu_microseconds() - begin);
      }
      write_line(place, number, static_cast<double>(reader.seconds), frame, reading);
    }
    cv::swap(frame, before);
  }
  if (times.empty())
    throw std::runtime_error("the film has no two frames");
  std::ranges::nth_element(times, times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2));
  std::printf("%.1f\n", times[times.size() / 2]);
}

} // namespace

int main(int argc, char **argv) {
  try {
    if (argc != 4)
      throw std::runtime_error("give a method, a folder and the places");
    cv::setNumThreads(1);
    std::vector<Place> places = read_places(argv[3], shipped(argv[1]));
    run(places);
    for (const Place &place : places)
      if (!(std::ofstream(std::string(argv[2]) + "/" + place.name + ".txt") << place.lines))
        throw std::runtime_error(std::string("'") + argv[2] + "' cannot be written to");
    return EXIT_SUCCESS;
  } catch (const std::exception &wrong) {
    std::fprintf(stderr, "felt-run: %s\n", wrong.what());
    return EXIT_FAILURE;
  }
}
