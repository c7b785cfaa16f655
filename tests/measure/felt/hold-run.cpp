// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs a tracker on points of a film:
//
//   hold-run TRACKER STARTS [AGAIN] < film.y4m > said.csv
//
// TRACKER is hold (this project's), lk, csrt, kcf, medianflow or mosse (OpenCV's). STARTS has a
// line "FRAME,X,Y" for each point: the frame in which it is taken and where, in px from the top
// left corner. In frame AGAIN each point that is held is taken anew where it is said to be. The
// table that is printed has a line for each point and frame from its start on: place, state (a
// number of HoldState), and processor time.
#include "cpu-time.hpp"
#include "hold/held-thing.hpp"
#include "plane-source.hpp"
#include "y4m-reader.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#ifdef HAVE_TRACKING
#include <opencv2/tracking.hpp>
#include <opencv2/tracking/tracking_legacy.hpp>
#endif
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Frame {
  cv::Mat luma;
  cv::Mat before;    // luma of the frame before
  cv::Mat colour;    // grey in three channels, as OpenCV's trackers want it
  float seconds = 0; // since the frame before
};

using haptic::HoldState;

struct Said {
  cv::Point2f place;
  HoldState state = HoldState::hidden;
};

class Follower {
public:
  virtual ~Follower() = default;
  virtual Said take(const Frame &frame, const cv::Point2f &place) = 0;
  virtual Said follow(const Frame &frame) = 0;
};

// hold_metric.py has these numbers.
static_assert(static_cast<int>(haptic::HoldState::held) == 1);
static_assert(static_cast<int>(haptic::HoldState::about) == 2);
static_assert(static_cast<int>(haptic::HoldState::hidden) == 3);

test::PlaneSource luma_of(const cv::Mat &frame) {
  return test::PlaneSource(
      {frame.data, frame.cols, frame.rows, static_cast<std::ptrdiff_t>(frame.step)});
}

class Holding : public Follower {
public:
  Said take(const Frame &frame, const cv::Point2f &place) override {
    return said(
        thing_.take(luma_of(frame.luma), frame.luma.cols, frame.luma.rows, place.x, place.y));
  }
  Said follow(const Frame &frame) override {
    return said(thing_.follow(luma_of(frame.luma), frame.seconds));
  }

private:
  static Said said(const haptic::HeldReport &report) {
    return {{report.x, report.y}, report.state};
  }
  haptic::HeldThing thing_;
};

// From frame to frame, and back to see whether it is the same point.
class Chained : public Follower {
public:
  Said take(const Frame & /*frame*/, const cv::Point2f &place) override {
    return said_ = {place, HoldState::held};
  }
  Said follow(const Frame &frame) override {
    constexpr int kSide = 192; // px, the smallest region that has four levels for this window
    const cv::Size window(21, 21);
    const cv::Rect region = cv::Rect(static_cast<int>(said_.place.x) - kSide / 2,
                                     static_cast<int>(said_.place.y) - kSide / 2, kSide, kSide) &
                            cv::Rect(0, 0, frame.luma.cols, frame.luma.rows);
    said_.state = HoldState::hidden;
    if (region.width < window.width || region.height < window.height)
      return said_;
    const cv::Point2f corner(region.tl());
    const std::vector from{said_.place - corner};
    std::vector<cv::Point2f> there;
    std::vector<cv::Point2f> back;
    std::vector<std::uint8_t> found;
    std::vector<std::uint8_t> found_back;
    cv::calcOpticalFlowPyrLK(frame.before(region), frame.luma(region), from, there, found,
                             cv::noArray(), window);
    cv::calcOpticalFlowPyrLK(frame.luma(region), frame.before(region), there, back, found_back,
                             cv::noArray(), window);
    said_.place = there[0] + corner;
    if (found[0] && found_back[0] && cv::norm(back[0] - from[0]) < 1)
      said_.state = HoldState::held;
    return said_;
  }

private:
  Said said_;
};

#ifdef HAVE_TRACKING
// A box of 48 px about the point.
class Boxed : public Follower {
public:
  explicit Boxed(cv::Ptr<cv::legacy::Tracker> tracker) : tracker_(std::move(tracker)) {}

  Said take(const Frame &frame, const cv::Point2f &place) override {
    constexpr int kSide = 48; // px: the patch of HeldThing covers ±20
    const cv::Rect inside(0, 0, frame.luma.cols - kSide, frame.luma.rows - kSide);
    box_ = {std::clamp(place.x - kSide / 2.0, 0.0, static_cast<double>(inside.width)),
            std::clamp(place.y - kSide / 2.0, 0.0, static_cast<double>(inside.height)), kSide,
            kSide};
    offset_ = place - centre();
    tracker_->init(frame.colour, box_);
    return {place, HoldState::held};
  }
  Said follow(const Frame &frame) override {
    // Some of them return an empty box with their failure.
    cv::Rect2d box = box_;
    const bool found = tracker_->update(frame.colour, box);
    if (found)
      box_ = box;
    return {centre() + offset_, found ? HoldState::held : HoldState::hidden};
  }

private:
  cv::Point2f centre() const {
    return {static_cast<float>(box_.x + box_.width / 2),
            static_cast<float>(box_.y + box_.height / 2)};
  }
  cv::Ptr<cv::legacy::Tracker> tracker_;
  cv::Rect2d box_;
  cv::Point2f offset_;
};
#endif

using Maker = std::function<std::unique_ptr<Follower>()>;

Maker maker_of(const std::string &name) {
  std::map<std::string, Maker> makers{
      {"hold", [] { return std::make_unique<Holding>(); }},
      {"lk", [] { return std::make_unique<Chained>(); }},
  };
#ifdef HAVE_TRACKING
  namespace peers = cv::legacy;
  makers["csrt"] = [] { return std::make_unique<Boxed>(peers::TrackerCSRT::create()); };
  makers["kcf"] = [] { return std::make_unique<Boxed>(peers::TrackerKCF::create()); };
  makers["medianflow"] = [] { return std::make_unique<Boxed>(peers::TrackerMedianFlow::create()); };
  makers["mosse"] = [] { return std::make_unique<Boxed>(peers::TrackerMOSSE::create()); };
#endif
  const auto found = makers.find(name);
  if (found == makers.end())
    throw std::runtime_error("there is no tracker '" + name +
                             "'; csrt, kcf, medianflow and mosse need libopencv-contrib-dev");
  return found->second;
}

struct Start {
  int frame = 0;
  cv::Point2f place;
};

std::vector<Start> read_starts(const char *path) {
  std::ifstream file(path);
  std::vector<Start> starts;
  Start read;
  for (char comma = 0; file >> read.frame >> comma >> read.place.x >> comma >> read.place.y;)
    starts.push_back(read);
  if (starts.empty())
    throw std::runtime_error(std::string("'") + path + "' has no points");
  return starts;
}

void run(const Maker &make, const std::vector<Start> &starts, int again) {
  std::ios::sync_with_stdio(false);
  test::Y4mReader reader(std::cin);
  std::vector<std::unique_ptr<Follower>> followers(starts.size());
  Frame frame;
  frame.seconds = reader.seconds;
  std::puts("frame,point,x,y,state,us");
  for (int number = 0; reader.next(frame.luma); ++number) {
    cv::cvtColor(frame.luma, frame.colour, cv::COLOR_GRAY2BGR);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      std::unique_ptr<Follower> &follower = followers[i];
      if (number < starts[i].frame)
        continue;
      Said said;
      const double begin = test::cpu_microseconds();
      if (follower) {
        said = follower->follow(frame);
      } else {
        follower = make();
        said = follower->take(frame, starts[i].place);
      }
      const double spent = test::cpu_microseconds() - begin;
      if (number == again && said.state == HoldState::held) {
        follower = make();
        follower->take(frame, said.place);
      }
      std::printf("%d,%zu,%.3f,%.3f,%d,%.1f\n", number, i, static_cast<double>(said.place.x),
                  static_cast<double>(said.place.y), static_cast<int>(said.state), spent);
    }
    cv::swap(frame.luma, frame.before);
  }
}

} // namespace

int main(int argc, char **argv) {
  try {
    if (argc < 3)
      throw std::runtime_error("give a tracker and the file of the starts");
    cv::setNumThreads(1);
    run(maker_of(argv[1]), read_starts(argv[2]), argc > 3 ? std::atoi(argv[3]) : -1);
    return EXIT_SUCCESS;
  } catch (const std::exception &wrong) {
    std::fprintf(stderr, "hold-run: %s\n", wrong.what());
    return EXIT_FAILURE;
  }
}
