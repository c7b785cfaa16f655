// SPDX-License-Identifier: LGPL-2.1-or-later
// One tick of the loop, or of the door for programs, with a device that does what neither may do:
// RealtimeSanitizer must report it. Usage: allocating-device loop|limits heap|mutex|sleep|nothing
#include "loop/haptic-loop.hpp"

#include <chrono>
#include <memory>
#include <mutex>
#include <spidar/limited-device.hpp>
#include <string>
#include <thread>
#include <vector>

namespace {

class Forbidden final : public spidar::HapticDevice {
public:
  explicit Forbidden(std::string action) : action_(std::move(action)) {}
  bool exchange(std::int64_t /*now*/) noexcept override {
    if (action_ == "heap")
      memory_.resize(64);
    else if (action_ == "mutex")
      const std::lock_guard lock(mutex_);
    else if (action_ == "sleep")
      std::this_thread::sleep_for(std::chrono::microseconds(1));
    return true;
  }
  bool connected() const noexcept override { return true; }
  void command(const spidar::Wrench & /*wrench*/) noexcept override {}
  void calibrate() noexcept override {}
  const spidar::DeviceState &state() const noexcept override { return state_; }
  const spidar::Vector3 &workspace_half() const noexcept override { return half_; }
  const spidar::DeviceLimits &limits() const noexcept override { return limits_; }
  std::string description() const override { return action_; }

private:
  std::string action_;
  std::vector<char> memory_;
  std::mutex mutex_;
  spidar::DeviceState state_;
  spidar::DeviceLimits limits_;
  spidar::Vector3 half_ = spidar::Vector3::Constant(0.1); // m
};

} // namespace

int main(int argc, char **argv) {
  if (argc != 3)
    return 1;
  Forbidden device(argv[2]);
  if (argv[1] == std::string("limits")) {
    spidar::LimitedDevice limited(device);
    limited.command({});
    limited.exchange(1'000'000); // ns
    return 0;
  }
  haptic::HapticLoop loop;
  loop.prepare({.device = &device});
  loop.tick(1'000'000, 1'000'000); // ns
}
