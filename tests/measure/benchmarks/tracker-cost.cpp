// SPDX-License-Identifier: LGPL-2.1-or-later
// What the trackers and the elements around them cost. Run by hand on an idle machine:
//   meson devenv -C BUILD tests/measure/benchmarks/tracker-cost [FRAMES|field|formats|layers]
// Region of 30 px; `layers`: of 60 px.
// Targets on a 2-core machine with AVX-512: unchanged 0.5 us, translation 4 us, full 8 us; AVX2
// twice that, the portable code 50 us; 99.9 % of a million frames below 40 us; with method=fast
// both elements 25 us per frame of 1080p more than an identity; the field of 1080p, 32 columns, 240
// frames a second on one core; hapticoverlay 1 ms with the copy of the frame; packed formats twice
// I420; layers 60 us, with the patches of the frame.
#include "field-frames.hpp"
#include "instruction-sets.hpp"
#include "plane-source.hpp"
#include "processor.hpp"
#include "tracking/patch-tracker.hpp"
#include "tracking/region-tracker.hpp"
#include "tracking/region.hpp"
#include "velocity/velocity-estimate.hpp"
#include "video-harness.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <gst/gst.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Frames = std::vector<test::Frame>;

constexpr int kSide = 140;
constexpr haptic::Rectangle kRegion{55, 55, 30, 30};
constexpr int kFrames = 16; // shown back and forth

double microseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

double percentile(std::vector<double> &times, double share) {
  std::ranges::sort(times);
  return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
}

// The left half moves by `left` px per frame and the right half by `right`.
Frames scene(test::Shift left, test::Shift right, double noise) {
  const test::Texture left_texture(1);
  const test::Texture right_texture(2);
  std::mt19937 random(3);
  Frames frames;
  for (int i = 0; i < kFrames; ++i) {
    test::Frame &frame = frames.emplace_back(kSide, kSide);
    left_texture.paint(frame, {left.x * i, left.y * i});
    if (left.x != right.x || left.y != right.y)
      right_texture.paint(frame, {right.x * i, right.y * i}, kSide / 2);
    test::add_noise(frame, noise, random);
  }
  return frames;
}

// Tracker and estimate for each pair of consecutive frames, as in the elements.
std::vector<double> times_of(Frames &frames, int count) {
  const auto tracker = haptic::make_fast_tracker();
  const haptic::Rectangle crop =
      haptic::crop_around(kRegion, tracker->margin(kRegion.width), kSide, kSide);
  haptic::Measurement measurement;
  haptic::ModelHistory history;
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(count));
  int at = 0;
  int step = 1;
  for (int i = 0; i < count; ++i) {
    if (at + step < 0 || at + step >= kFrames)
      step = -step;
    const auto view = [&](int index) {
      return haptic::LumaView{&frames[static_cast<std::size_t>(index)].at(crop.x, crop.y),
                              crop.width, crop.height, kSide};
    };
    const auto begin = Clock::now();
    tracker->measure({view(at), view(at + step), crop, kRegion, i > 0}, measurement);
    if (measurement.count > 0)
      history =
          haptic::estimate_velocity({.patches = measurement.view(),
                                     .candidates = measurement.candidates,
                                     .pointer_x = kSide / 2.0F,
                                     .pointer_y = kSide / 2.0F,
                                     .interval = 1.0 / 30,
                                     .region_x = static_cast<float>(kRegion.x),
                                     .region_y = static_cast<float>(kRegion.y),
                                     .region_width = static_cast<float>(kRegion.width),
                                     .region_height = static_cast<float>(kRegion.height)},
                                    haptic::Average::model, haptic::ModelChoice::automatic, history)
              .history;
    times.push_back(microseconds_since(begin));
    at += step;
  }
  return times;
}

void compare_instruction_sets(Frames &still, Frames &moving, Frames &two) {
  constexpr int kCount = 4000;
  std::printf("\n%-14s %10s %14s %10s   median us per frame\n", "", "unchanged", "translation",
              "full");
  test::for_instruction_sets([&](const char *name) {
    std::printf("%-14s", name);
    for (Frames *frames : {&still, &moving, &two}) {
      std::vector<double> times = times_of(*frames, kCount);
      std::printf(" %10.2f   ", percentile(times, 0.5));
    }
    std::printf("\n");
  });
}

// The whole of method=layers, in frames of 640x360 whose upper half is a smooth sky.
void measure_layers() {
  constexpr int kWidth = 640;
  constexpr int kHeight = 360;
  constexpr haptic::Rectangle kLarge{290, 150, 60, 60};
  constexpr int kCount = 4000;
  const test::Texture clouds(1, 60, 12);
  const test::Texture leaves(2);
  Frames film;
  for (int i = 0; i < kFrames; ++i) {
    test::Frame &frame = film.emplace_back(clouds.frame(kWidth, kHeight, {0.1 * i, 0}));
    const test::Frame lower = leaves.frame(kWidth, kHeight, {0.8 * i, 0.3 * i});
    std::copy(lower.pixels.begin() + kWidth * kHeight / 2, lower.pixels.end(),
              frame.pixels.begin() + kWidth * kHeight / 2);
  }
  std::printf("\nlayers, region of 60 px, us per frame\n");
  test::for_instruction_sets([&](const char *name) {
    haptic::RegionTracker tracker;
    tracker.set_method(haptic::TrackerMethod::layers, haptic::kUsualPatches);
    const haptic::Areas areas = tracker.areas(kLarge, kWidth, kHeight);
    std::vector<double> times;
    int at = 0;
    int step = 1;
    for (int i = 0; i < kCount; ++i) {
      if (at + step < 0 || at + step >= kFrames)
        step = -step;
      const test::PlaneSource earlier(film[static_cast<std::size_t>(at)]);
      const test::PlaneSource later(film[static_cast<std::size_t>(at + step)]);
      const auto begin = Clock::now();
      tracker.compare(earlier, later, areas, GST_SECOND / 60);
      times.push_back(microseconds_since(begin));
      at += step;
    }
    std::printf("%-14s median %6.1f, 99 %% below %6.1f, 99.9 %% below %6.1f\n", name,
                percentile(times, 0.5), percentile(times, 0.99), percentile(times, 0.999));
  });
}

void run_long(Frames &two, int count) {
  std::vector<double> times = times_of(two, count);
  std::printf("\n%d frames, full:", count);
  for (const double share : {0.5, 0.99, 0.999, 1.0})
    std::printf(" %g %% below %.1f us,", 100 * share, percentile(times, share));
  std::printf("\n");
}

GstHarness *harness_of(const char *line, const GstVideoInfo &info) {
  GstHarness *harness = gst_harness_new_parse(line);
  gst_harness_set_src_caps(harness, gst_video_info_to_caps(&info));
  gst_harness_set_drop_buffers(harness, TRUE);
  return harness;
}

// Microseconds that one line takes for the frame.
double push_time(GstHarness *harness, GstBuffer *frame, int index) {
  GstBuffer *buffer = gst_buffer_copy(frame);
  GST_BUFFER_PTS(buffer) = gst_util_uint64_scale(static_cast<guint64>(index), GST_SECOND, 30);
  const auto begin = Clock::now();
  gst_harness_push(harness, buffer);
  return microseconds_since(begin);
}

// Pushes each frame of 1080p through all lines in turn, so that other load on the machine slows all
// of them equally.
void compare_elements() {
  constexpr int kCount = 2000;
  const GstVideoInfo info = test::video_info(GST_VIDEO_FORMAT_I420, 1920, 1080);
  const test::Texture texture(4);
  std::vector<haptic::BufferPtr> buffers;
  for (int i = 0; i < 4; ++i)
    buffers.push_back(test::to_buffer(texture.frame(1920, 1080, {1.3 * i, 0.4 * i}), info));
  const char *const lines[] = {"identity", "roitracker roi-size=30 ! velocityavg", "roitracker",
                               "roitracker ! hapticoverlay",
                               "roitracker method=fast roi-size=30 ! velocityavg"};
  std::vector<GstHarness *> harnesses;
  for (const char *line : lines)
    harnesses.push_back(harness_of(line, info));
  std::vector<double> times[std::size(lines)];
  for (int i = 0; i < kCount; ++i)
    for (std::size_t line = 0; line < harnesses.size(); ++line)
      times[line].push_back(
          push_time(harnesses[line], buffers[static_cast<std::size_t>(i % 4)].get(), i));
  const double identity = percentile(times[0], 0.5);
  std::printf("\n1080p: identity %.1f us; roitracker ! velocityavg %.1f us more, with method=fast "
              "%.1f us more\n",
              identity, percentile(times[1], 0.5) - identity, percentile(times[4], 0.5) - identity);
  std::vector<double> copies;
  const haptic::BufferPtr copy(
      gst_buffer_new_allocate(nullptr, GST_VIDEO_INFO_SIZE(&info), nullptr));
  GstMapInfo from;
  GstMapInfo to;
  gst_buffer_map(buffers[0].get(), &from, GST_MAP_READ);
  gst_buffer_map(copy.get(), &to, GST_MAP_WRITE);
  for (int i = 0; i < kCount; ++i) {
    const auto begin = Clock::now();
    std::copy_n(from.data, from.size, to.data);
    copies.push_back(microseconds_since(begin));
  }
  gst_buffer_unmap(copy.get(), &to);
  gst_buffer_unmap(buffers[0].get(), &from);
  std::printf("1080p, region of 164 px: hapticoverlay %.0f us, of which the copy of the frame "
              "takes %.0f us\n",
              percentile(times[3], 0.5) - percentile(times[2], 0.5), percentile(copies, 0.5));
  for (GstHarness *harness : harnesses)
    gst_harness_teardown(harness);
}

constexpr GstVideoFormat kFormats[] = {GST_VIDEO_FORMAT_I420,      GST_VIDEO_FORMAT_YUY2,
                                       GST_VIDEO_FORMAT_RGB,       GST_VIDEO_FORMAT_BGRx,
                                       GST_VIDEO_FORMAT_I420_10LE, GST_VIDEO_FORMAT_v210};
using FormatTimes = std::array<double, std::size(kFormats)>;

// Median us of an element for the same frames in each of the formats in turn. A pointer moves by
// `speed` px per frame.
FormatTimes times_by_format(const char *element, const Frames &frames, int speed, int count) {
  const int width = frames[0].width;
  GstHarness *harnesses[std::size(kFormats)];
  std::vector<haptic::BufferPtr> buffers[std::size(kFormats)];
  std::vector<double> times[std::size(kFormats)];
  for (std::size_t k = 0; k < std::size(kFormats); ++k) {
    const GstVideoInfo info = test::video_info(kFormats[k], width, frames[0].height);
    harnesses[k] = harness_of(element, info);
    for (const test::Frame &frame : frames)
      buffers[k].push_back(test::to_buffer(frame, info));
  }
  for (int i = 0; i < count; ++i)
    for (std::size_t k = 0; k < std::size(kFormats); ++k) {
      if (speed != 0) {
        const haptic::ElementPtr tracker(gst_harness_find_element(harnesses[k], "roitracker"));
        g_object_set(tracker.get(), "pointer-x",
                     0.5 + static_cast<double>(speed * (i % 16)) / width, nullptr);
      }
      times[k].push_back(push_time(
          harnesses[k], buffers[k][static_cast<std::size_t>(i) % frames.size()].get(), i));
    }
  FormatTimes medians;
  for (std::size_t k = 0; k < std::size(kFormats); ++k) {
    medians[k] = percentile(times[k], 0.5);
    gst_harness_teardown(harnesses[k]);
  }
  return medians;
}

// roitracker with its usual region, which grows with the frame, and motionfield.
void compare_formats(int width, int height) {
  const test::Texture texture(4);
  Frames frames;
  for (int i = 0; i < 4; ++i)
    frames.push_back(texture.frame(width, height, {1.3 * i, 0.4 * i}));
  const FormatTimes columns[] = {times_by_format("roitracker method=fast", frames, 0, 400),
                                 times_by_format("roitracker method=fast", frames, 8, 400),
                                 times_by_format("motionfield", frames, 0, 40)};
  std::printf("\n%d x %d, median us per frame\n%-9s %17s %17s %17s\n", width, height, "",
              "roitracker", "pointer at 8 px", "motionfield");
  for (std::size_t k = 0; k < std::size(kFormats); ++k) {
    std::printf("%-9s", gst_video_format_to_string(kFormats[k]));
    for (const FormatTimes &times : columns)
      std::printf(" %8.0f (x %4.2f)", times[k], times[k] / times[0]);
    std::printf("\n");
  }
}

// Median ms of follow(frame) over the frames, back and forth.
template <typename Follow>
double median_ms(const Frames &frames, Follow &&follow) {
  constexpr int kRounds = 4;
  std::vector<double> times;
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto begin = Clock::now();
      follow(frames[round % 2 == 0 ? i : frames.size() - 1 - i]);
      times.push_back(microseconds_since(begin) / 1000);
    }
  return percentile(times, 0.5);
}

// The field of 1080p from luma to cells, beside dense flow of the same frames. These are reduced
// beforehand in the same ratio.
void compare_fields() {
  constexpr int kWidth = 1920;
  constexpr int kHeight = 1080;
  constexpr int kReduced = 2; // as FieldTracker does it for cells of 60 px
  cv::setNumThreads(1);
  std::mt19937 random(5);
  Frames moving;
  const test::Texture left(6, 10);
  const test::Texture right(7, 10);
  for (int i = 0; i < 6; ++i) {
    test::Frame &frame = moving.emplace_back(kWidth, kHeight);
    left.paint(frame, {4.3 * i, -1.2 * i});
    right.paint(frame, {-2.8 * i, 0.9 * i}, kWidth / 2);
    test::add_noise(frame, 1.5, random);
  }
  const Frames still(6, moving.front());
  const auto field_ms = [&](const Frames &frames) {
    test::Field field(kWidth, kHeight);
    return median_ms(frames, [&](const test::Frame &frame) { field.follow(frame); });
  };
  const double own = field_ms(moving);
  const auto line = [&](const char *name, double ms) {
    std::printf("%-22s %8.2f ms  %6.0f per second  %5.1f times the field's\n", name, ms, 1000 / ms,
                ms / own);
  };
  std::printf("\n1080p, 32 columns, one core\n");
  line("field, moving", own);
  line("field, still", field_ms(still));

  Frames reduced;
  for (test::Frame &frame : moving) {
    test::Frame &small = reduced.emplace_back(kWidth / kReduced, kHeight / kReduced);
    cv::Mat target(small.height, small.width, CV_8U, small.pixels.data());
    cv::resize(cv::Mat(kHeight, kWidth, CV_8U, frame.pixels.data()), target, target.size(), 0, 0,
               cv::INTER_AREA);
  }
  const auto peer_ms = [&](auto &&calculate) {
    cv::Mat previous;
    cv::Mat flow;
    return median_ms(reduced, [&](const test::Frame &frame) {
      const cv::Mat current(frame.height, frame.width, CV_8U,
                            const_cast<std::uint8_t *>(frame.pixels.data()));
      if (!previous.empty())
        calculate(previous, current, flow);
      previous = current;
    });
  };
  for (const auto &[name, preset] :
       {std::pair("DIS ultrafast", cv::DISOpticalFlow::PRESET_ULTRAFAST),
        std::pair("DIS fast", cv::DISOpticalFlow::PRESET_FAST)}) {
    const auto dis = cv::DISOpticalFlow::create(preset);
    line(name, peer_ms([&](const cv::Mat &previous, const cv::Mat &current, cv::Mat &flow) {
           dis->calc(previous, current, flow);
         }));
  }
  line("Farneback", peer_ms([](const cv::Mat &previous, const cv::Mat &current, cv::Mat &flow) {
         cv::calcOpticalFlowFarneback(previous, current, flow, 0.5, 5, 13, 1, 5, 1.1, 0);
       }));
}

} // namespace

int main(int argc, char **argv) {
  gst_init(nullptr, nullptr);
  std::printf("%s, compiler %s\n", test::processor().c_str(), __VERSION__);
  if (argc > 1 && std::string(argv[1]) == "field") {
    compare_fields();
    return EXIT_SUCCESS;
  }
  if (argc > 1 && std::string(argv[1]) == "formats") {
    compare_formats(1920, 1080);
    compare_formats(3840, 2160);
    return EXIT_SUCCESS;
  }
  if (argc > 1 && std::string(argv[1]) == "layers") {
    measure_layers();
    return EXIT_SUCCESS;
  }
  const int count = argc > 1 ? std::atoi(argv[1]) : 1'000'000;
  Frames still = scene({0, 0}, {0, 0}, 0);
  Frames moving = scene({1.7, -0.6}, {1.7, -0.6}, 1.5);
  Frames two = scene({1.7, -0.6}, {-1.2, 0.9}, 1.5);
  compare_instruction_sets(still, moving, two);
  compare_elements();
  compare_fields();
  run_long(two, count);
  return EXIT_SUCCESS;
}
