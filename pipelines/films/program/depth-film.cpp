// SPDX-License-Identifier: LGPL-2.1-or-later
// Draws a moving scene with its exact depth to the right of it, white is near:
// depth-film --help says how it is used. The colours are BT.601.
//
// A luma of 240 is 20 mm above the middle of the workspace, 17 as much below.
#include "program/depth-scene.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

namespace {

using film::DepthScene;

constexpr int kWidth = 2 * DepthScene::kWidth;
constexpr int kHeight = DepthScene::kHeight;
constexpr std::size_t kPixels = static_cast<std::size_t>(kWidth) * kHeight;
constexpr float kLowest = 17; // luma of the depth; black, 16, would be unknown
constexpr float kHighest = 240;
constexpr double kLongest = 3600; // s

// Mean of two rays, which smooths edges.
DepthScene::Colour colour_of(int x, int y, const DepthScene::Balls &balls) {
  DepthScene::Colour mean{};
  for (const double offset : {0.25, 0.75}) {
    const DepthScene::Colour one = DepthScene::colour(x + offset, y + offset, balls);
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += std::min(one[i], 1.0F) / 2;
  }
  return mean;
}

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::lround(value));
}

std::uint8_t depth_luma(int x, int y, const DepthScene::Balls &balls) {
  const float height = DepthScene::height(DepthScene::depth(x + 0.5, y + 0.5, balls));
  const float share = height / static_cast<float>(DepthScene::kRange) + 0.5F;
  return byte_of(kLowest + (kHighest - kLowest) * std::clamp(share, 0.0F, 1.0F));
}

// Two rows of luma and one of each colour difference.
void draw_rows(std::span<std::uint8_t> frame, int y, const DepthScene::Balls &balls) {
  std::uint8_t *luma = frame.data() + static_cast<std::ptrdiff_t>(y) * kWidth;
  std::uint8_t *blue = frame.data() + kPixels + static_cast<std::ptrdiff_t>(y / 2) * kWidth / 2;
  std::uint8_t *red = blue + kPixels / 4;
  for (int x = 0; x < DepthScene::kWidth; x += 2) {
    DepthScene::Colour sum{};
    for (int i = 0; i < 4; ++i) {
      const int row = i / 2;
      const DepthScene::Colour c = colour_of(x + i % 2, y + row, balls);
      luma[row * kWidth + x + i % 2] =
          byte_of(16 + 65.481F * c[0] + 128.553F * c[1] + 24.966F * c[2]);
      luma[row * kWidth + DepthScene::kWidth + x + i % 2] = depth_luma(x + i % 2, y + row, balls);
      for (std::size_t j = 0; j < sum.size(); ++j)
        sum[j] += c[j] / 4;
    }
    blue[x / 2] = byte_of(128 - 37.797F * sum[0] - 74.203F * sum[1] + 112 * sum[2]);
    red[x / 2] = byte_of(128 + 112 * sum[0] - 93.786F * sum[1] - 18.214F * sum[2]);
    blue[(DepthScene::kWidth + x) / 2] = red[(DepthScene::kWidth + x) / 2] = 128;
  }
}

std::vector<std::uint8_t> draw(int index) {
  std::vector<std::uint8_t> frame(kPixels * 3 / 2);
  const DepthScene::Balls balls = DepthScene::balls(static_cast<double>(index) / DepthScene::kRate);
  for (int y = 0; y < kHeight; y += 2)
    draw_rows(frame, y, balls);
  return frame;
}

// As many frames at once as there are processors.
bool write_frames(int count) {
  const int at_once = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  for (int first = 0; first < count; first += at_once) {
    std::vector<std::future<std::vector<std::uint8_t>>> drawn;
    for (int i = first; i < std::min(count, first + at_once); ++i)
      drawn.push_back(std::async(std::launch::async, draw, i));
    for (auto &frame : drawn) {
      const std::vector<std::uint8_t> bytes = frame.get();
      if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size())
        return false;
    }
  }
  return true;
}

void print_heights(int count, double x, double y) {
  for (int i = 0; i < count; ++i) {
    const double time = static_cast<double>(i) / DepthScene::kRate;
    const auto height = static_cast<double>(DepthScene::height(DepthScene::depth(x, y, time)));
    std::printf("%.6f %.6f\n", time, height);
  }
}

} // namespace

int main(int argc, char **argv) {
  constexpr char kUsage[] =
      "Usage: depth-film SECONDS\n"
      "       depth-film SECONDS X Y\n\n"
      "Draws balls that bounce, circle and roll, with their depth to the right of them.\n"
      "Writes raw frames to the standard output: I420, 1280x360 px, 30 a second, 3600 s at most.\n"
      "With X and Y it prints time (s) and height (m) at this pixel for each frame instead.\n\n"
      "Example: depth-film 3 600 332 > heights.txt\n";
  if (argc == 2 && std::string_view(argv[1]) == "--help")
    return std::fputs(kUsage, stdout) < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
  const double seconds = argc > 1 ? std::strtod(argv[1], nullptr) : 0;
  if ((argc != 2 && argc != 4) || !(seconds > 0 && seconds <= kLongest)) {
    std::fputs(kUsage, stderr);
    return EXIT_FAILURE;
  }
  const int count = static_cast<int>(std::ceil(seconds * DepthScene::kRate));
  if (argc == 4)
    print_heights(count, std::strtod(argv[2], nullptr), std::strtod(argv[3], nullptr));
  else if (!write_frames(count))
    return EXIT_FAILURE;
  return std::fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
