// SPDX-License-Identifier: LGPL-2.1-or-later
// How fast a SPIDAR-G on USB can be driven: one tick after the other, each an exchange, the pose, a
// force that turns round and its tensions.
//
// Usage: usb-ticks SECONDS [ID]   ID: rotary switch. SIGTERM ends it early. Prints
//                                 "driving" when it begins to measure, and at the end one line
//                                 NAME VALUE NAME VALUE ...:
//                                 ticks, ticks a second on average and in the slowest second, lost
//                                 exchanges, of these at the end, poses not believed, and the
//                                 duration of a tick in µs
//        usb-ticks probe          Prints how long an exchange takes on this machine, without
//                                 libspidar: the median in µs
//
// Exit status: 1 the device cannot be opened, 2 it has gone for good.
#include "spidar/device.hpp"
#include "spidar/error.hpp"
#include "spidar/usb.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <libusb.h>
#include <stdexcept>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Microseconds = std::chrono::duration<double, std::micro>;

constexpr double kForce = 0.5;                             // N
constexpr auto kLongestSilence = std::chrono::seconds(10); // a slow machine injects faults slowly

volatile std::sig_atomic_t ended = 0;

double quantile(const std::vector<double> &sorted, std::size_t percent) {
  return sorted[(sorted.size() - 1) * percent / 100];
}

int run(int seconds, const std::string &id) {
  spidar::Device device(spidar::open_usb(id), spidar::load_geometry(spidar::kDefaultGeometry));
  std::vector<double> times; // µs
  times.reserve(static_cast<std::size_t>(seconds) * 10000);
  std::vector<std::size_t> per_second(static_cast<std::size_t>(seconds));
  std::size_t lost = 0;
  std::size_t lost_at_the_end = 0;
  std::size_t not_believed = 0;
  std::printf("driving\n"); // what happens before is not measured
  std::fflush(stdout);
  const auto start = Clock::now();
  auto answered = start;
  bool gone = false;
  for (auto now = start; now - start < std::chrono::seconds(seconds) && !gone && !ended;) {
    if (device.exchange(spidar::monotonic_time())) {
      lost_at_the_end = 0;
      answered = now;
      ++per_second[static_cast<std::size_t>((now - start) / std::chrono::seconds(1))];
      not_believed += device.state().valid ? 0 : 1;
    } else {
      ++lost;
      ++lost_at_the_end;
      gone = !device.connected() || now - answered > kLongestSilence;
    }
    const double angle = std::chrono::duration<double>(now - start).count();
    device.command({kForce * spidar::Vector3(std::cos(angle), std::sin(angle), 0), {0, 0, 0}});
    const auto end = Clock::now();
    times.push_back(Microseconds(end - now).count());
    now = end;
  }
  std::sort(times.begin(), times.end());
  std::printf("ticks %zu rate %zu slowest-second %zu lost %zu lost-at-the-end %zu not-believed %zu "
              "p50 %.0f p99 %.0f largest %.0f\n",
              times.size(), times.size() / static_cast<std::size_t>(seconds),
              *std::min_element(per_second.begin(), per_second.end()), lost, lost_at_the_end,
              not_believed, quantile(times, 50), quantile(times, 99), times.back());
  return gone ? 2 : 0;
}

/// Latches and fetches the counters of a USB2.0 Simple: two transfers.
void probe() {
  libusb_context *context = nullptr;
  libusb_init(&context);
  libusb_device_handle *handle = libusb_open_device_with_vid_pid(context, 0x0cec, 0x0203);
  if (!handle || libusb_claim_interface(handle, 0) != 0)
    throw std::runtime_error("there is no 0cec:0203 to probe");
  std::vector<double> times;
  const auto start = Clock::now();
  for (auto now = start; now - start < std::chrono::seconds(1);) {
    std::array<unsigned char, 32> latch = {0x51};
    std::array<unsigned char, 512> reply;
    int size = 0;
    if (libusb_bulk_transfer(handle, 0x02, latch.data(), latch.size(), &size, 1000) != 0 ||
        libusb_bulk_transfer(handle, 0x86, reply.data(), reply.size(), &size, 1000) != 0)
      throw std::runtime_error("0cec:0203 does not answer");
    const auto end = Clock::now();
    times.push_back(Microseconds(end - now).count());
    now = end;
  }
  libusb_close(handle);
  libusb_exit(context);
  std::sort(times.begin(), times.end());
  std::printf("%.0f\n", quantile(times, 50));
}

} // namespace

int main(int argc, char **argv) {
  int seconds = 0;
  const bool wants_probe = argc == 2 && std::strcmp(argv[1], "probe") == 0;
  if (!wants_probe &&
      (argc < 2 || argc > 3 ||
       std::from_chars(argv[1], argv[1] + std::strlen(argv[1]), seconds).ec != std::errc() ||
       seconds < 1 || seconds > 3600)) {
    std::fprintf(stderr, "usage: usb-ticks SECONDS [ID] | usb-ticks probe\n");
    return 1;
  }
  std::signal(SIGTERM, [](int) { ended = 1; });
  try {
    if (!wants_probe)
      return run(seconds, argc > 2 ? argv[2] : "");
    probe();
    return 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "usb-ticks: %s\n", error.what());
    return 1;
  }
}
