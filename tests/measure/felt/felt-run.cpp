// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs a method on the region of roitracker at places of a film:
//
//   felt-run METHOD FOLDER PLACES < film.y4m
//
// METHOD is one of roitracker (fast, opencv or layers), or one that the lab ships, such as
// Farneback. PLACES are "X,Y X,Y ...", 0 to 1 from the top left. FOLDER gets a text track X-Y.txt
// for each place. Prints the median of the processor time of a frame, in µs.
#include "cpu-time.hpp"
#include "forms/text-line.hpp"
#include "methods/methods.hpp"
#include "plane-source.hpp"
#include "tracking/region-tracker.hpp"
#include "tracking/region.hpp"
#include "y4m-reader.hpp"

#include <algorithm>
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

// What roitracker and velocityavg do with a frame, for its time: what a hand gets has the elements.
class Live final : public lab::Method {
public:
  explicit Live(haptic::TrackerMethod method) {
    tracker_.set_method(method, haptic::kUsualPatches);
  }

  lab::Reading measure(const lab::Task &task) override {
    constexpr std::uint64_t kInterval = 16'666'667; // ns
    const int width = task.current.cols;
    const int height = task.current.rows;
    const auto source = [](const cv::Mat &luma) {
      return test::PlaneSource(
          {luma.data, luma.cols, luma.rows, static_cast<std::ptrdiff_t>(luma.step)});
    };
    const haptic::Rectangle region =
        haptic::region_at(task.pointer.x, task.pointer.y, task.side, width, height);
    tracker_.compare(source(task.previous), source(task.current),
                     tracker_.areas(region, width, height), kInterval);
    return lab::estimate(tracker_.measurement(), region, task, {}, history_);
  }

private:
  haptic::RegionTracker tracker_;
  haptic::ModelHistory history_;
};

lab::Configuration shipped(const std::string &name) {
  using haptic::TrackerMethod;
  for (const auto &[own, method] : {std::pair{"fast", TrackerMethod::fast},
                                    {"opencv", TrackerMethod::opencv},
                                    {"layers", TrackerMethod::layers}})
    if (name == own)
      return {name, "", false, true, [method = method] { return std::make_unique<Live>(method); }};
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
  const auto side = static_cast<float>(haptic::default_region_side(frame.cols));
  const auto interval = static_cast<std::uint64_t>(std::llround(1e9 * seconds));
  haptic::TrackSample sample;
  sample.time = static_cast<std::uint64_t>(number) * interval;
  sample.duration = interval;
  haptic::MotionSample &motion = sample.motion;
  motion.velocity_x = static_cast<float>(velocity.x);
  motion.velocity_y = static_cast<float>(velocity.y);
  motion.pointer_x = static_cast<float>(place.pointer.x);
  motion.pointer_y = static_cast<float>(place.pointer.y);
  motion.region_width = side / static_cast<float>(frame.cols);
  motion.region_height = side / static_cast<float>(frame.rows);
  motion.confidence = static_cast<float>(reading.confidence);
  motion.interval = interval;
  motion.frame_width = static_cast<std::uint32_t>(frame.cols);
  motion.frame_height = static_cast<std::uint32_t>(frame.rows);
  motion.points = 1;
  motion.model = haptic::MotionModel::translation;
  place.lines += haptic::write_text_line(sample) + "\n";
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
