// SPDX-License-Identifier: LGPL-2.1-or-later
// How much of a force buzzes: the share of its energy above a frequency.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

namespace test {

/// Power of each bin 0 .. n/2 of the longest power of two of values, Hann window, mean removed.
inline std::vector<double> power_spectrum(std::span<const double> values) {
  std::size_t n = 1;
  while (2 * n <= values.size())
    n *= 2;
  double mean = 0;
  for (std::size_t i = 0; i < n; ++i)
    mean += values[i] / static_cast<double>(n);
  std::vector<std::complex<double>> x(n);
  for (std::size_t i = 0, reversed = 0; i < n; ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    x[reversed] = (values[i] - mean) * (0.5 - 0.5 * std::cos(phase));
    std::size_t bit = n / 2;
    for (; bit > 0 && (reversed & bit); bit /= 2)
      reversed ^= bit;
    reversed ^= bit;
  }
  for (std::size_t length = 2; length <= n; length *= 2)
    for (std::size_t begin = 0; begin < n; begin += length)
      for (std::size_t k = 0; k < length / 2; ++k) {
        const auto turn = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) /
                                              static_cast<double>(length));
        const auto even = x[begin + k];
        const auto odd = turn * x[begin + k + length / 2];
        x[begin + k] = even + odd;
        x[begin + k + length / 2] = even - odd;
      }
  std::vector<double> power(n / 2 + 1);
  for (std::size_t i = 0; i < power.size(); ++i)
    power[i] = std::norm(x[i]);
  return power;
}

/// dB; `rate` of the values and `frequency` in Hz.
inline double energy_above_db(std::span<const double> values, double rate, double frequency) {
  const auto power = power_spectrum(values);
  const double width = rate / 2 / static_cast<double>(power.size() - 1); // Hz per bin
  double all = 0;
  double above = 0;
  for (std::size_t i = 0; i < power.size(); ++i) {
    all += power[i];
    if (static_cast<double>(i) * width > frequency)
      above += power[i];
  }
  return 10 * std::log10(above / all);
}

/// Amplitude of the line at `frequency`, in the unit of the values.
inline double line_amplitude(std::span<const double> values, double rate, double frequency) {
  std::complex<double> sum = 0;
  double weights = 0;
  const auto n = static_cast<double>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double t = static_cast<double>(i);
    const double hann = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * t / n);
    sum += hann * values[i] * std::polar(1.0, -2 * std::numbers::pi * frequency * t / rate);
    weights += hann;
  }
  return 2 * std::abs(sum) / weights;
}

} // namespace test
