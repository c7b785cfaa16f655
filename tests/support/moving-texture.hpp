// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames whose motion is known exactly: band-limited textures, painted at any fraction of a
// pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace test {

/// px, x to the right, y down.
struct Shift {
  double x = 0;
  double y = 0;
};

/// 8-bit luma.
struct Frame {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels; ///< width*height, row by row

  Frame() = default;
  Frame(int w, int h, std::uint8_t grey = 0)
      : width(w), height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), grey) {}

  std::uint8_t &at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// A sum of sine waves in random directions. None is shorter than `shortest` pixels, so that the
/// samples hold the texture whole and a shift by any fraction of a pixel is exact.
class Texture {
public:
  explicit Texture(unsigned seed, double shortest = 5, double contrast = 35) {
    constexpr int kWaves = 40;
    constexpr double kOctaves = 3.6;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    double power = 0;
    for (int i = 0; i < kWaves; ++i) {
      const double length = shortest * std::exp2(kOctaves * unit(random));
      const double direction = 2 * std::numbers::pi * unit(random);
      const double number = 2 * std::numbers::pi / length;
      const double amplitude = std::sqrt(length); // as in nature, coarse is stronger
      waves_.push_back({number * std::cos(direction), number * std::sin(direction),
                        2 * std::numbers::pi * unit(random), amplitude});
      power += amplitude * amplitude / 2;
    }
    for (Wave &wave : waves_)
      wave.amplitude *= contrast / std::sqrt(power);
  }

  /// Paints the columns left..right-1 (all by default) with the texture moved by `shift`.
  void paint(Frame &frame, Shift shift, int left = 0, int right = -1) const {
    if (right < 0)
      right = frame.width;
    const std::size_t columns = static_cast<std::size_t>(right - left);
    std::vector<double> row(columns);
    const auto along_x = phases(left, right, [&](const Wave &wave, double x) {
      return std::polar(wave.amplitude, wave.kx * (x - shift.x) + wave.phase);
    });
    const auto along_y = phases(0, frame.height, [&](const Wave &wave, double y) {
      return std::polar(1.0, wave.ky * (y - shift.y));
    });
    for (int y = 0; y < frame.height; ++y) {
      std::fill(row.begin(), row.end(), 128.0);
      for (std::size_t wave = 0; wave < waves_.size(); ++wave) {
        const auto factor = along_y[wave][static_cast<std::size_t>(y)];
        for (std::size_t i = 0; i < columns; ++i)
          row[i] +=
              along_x[wave][i].real() * factor.real() - along_x[wave][i].imag() * factor.imag();
      }
      for (std::size_t i = 0; i < columns; ++i)
        frame.at(left + static_cast<int>(i), y) =
            static_cast<std::uint8_t>(std::clamp(std::round(row[i]), 0.0, 255.0));
    }
  }

  /// Paints the texture `times` larger, its origin at the frame's.
  void paint_magnified(Frame &frame, int times) const {
    Texture larger = *this;
    for (Wave &wave : larger.waves_) {
      wave.kx /= times;
      wave.ky /= times;
    }
    larger.paint(frame, {});
  }

  /// The texture turned about the middle of the frame, radians, positive turns x towards y.
  Frame turned(int width, int height, double angle) const {
    Texture turned = *this;
    for (Wave &wave : turned.waves_) {
      const auto at_middle = [&] { return wave.kx * width / 2 + wave.ky * height / 2; };
      const double before = at_middle();
      const double kx = wave.kx;
      wave.kx = kx * std::cos(angle) - wave.ky * std::sin(angle);
      wave.ky = kx * std::sin(angle) + wave.ky * std::cos(angle);
      wave.phase += before - at_middle();
    }
    return turned.frame(width, height, {});
  }

  /// The texture `factor` times larger, about the middle of the frame.
  Frame zoomed(int width, int height, double factor) const {
    Texture zoomed = *this;
    for (Wave &wave : zoomed.waves_) {
      wave.phase += (1 - 1 / factor) * (wave.kx * width + wave.ky * height) / 2;
      wave.kx /= factor;
      wave.ky /= factor;
    }
    return zoomed.frame(width, height, {});
  }

  Frame frame(int width, int height, Shift shift) const {
    Frame frame(width, height);
    paint(frame, shift);
    return frame;
  }

private:
  struct Wave {
    double kx, ky, phase, amplitude;
  };

  // One list per wave, at the centres of the pixels begin..end-1.
  template <typename Function>
  std::vector<std::vector<std::complex<double>>> phases(int begin, int end,
                                                        const Function &at) const {
    std::vector<std::vector<std::complex<double>>> lists;
    for (const Wave &wave : waves_) {
      auto &list = lists.emplace_back();
      for (int i = begin; i < end; ++i)
        list.push_back(at(wave, i + 0.5));
    }
    return lists;
  }

  std::vector<Wave> waves_;
};

/// Gaussian noise of a camera, standard deviation in grey levels.
inline void add_noise(Frame &frame, double sigma, std::mt19937 &random) {
  std::normal_distribution<double> normal; // a standard deviation of 0 is not allowed
  for (auto &pixel : frame.pixels)
    pixel = static_cast<std::uint8_t>(
        std::clamp(std::round(pixel + sigma * normal(random)), 0.0, 255.0));
}

/// Calls `body(before, after, truth)` for displacements of 4 to 16 px in random directions, with
/// noise, of a square frame. Returns how many they were.
template <typename Body>
int for_large_displacements(int side, Body body) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi);
  int cases = 0;
  for (const double distance : {4.0, 8.0, 12.0, 13.33, 16.0})
    for (int i = 0; i < 40; ++i, ++cases) {
      const Texture texture(static_cast<unsigned>(random()));
      const double direction = turn(random);
      const Shift truth{distance * std::cos(direction), distance * std::sin(direction)};
      Frame before = texture.frame(side, side, {});
      Frame after = texture.frame(side, side, truth);
      add_noise(before, 1.5, random);
      add_noise(after, 1.5, random);
      body(before, after, truth);
    }
  return cases;
}

} // namespace test
