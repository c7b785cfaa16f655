// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-info: lists the controllers found, or shows the values that one measures.
#include "fail.hpp"
#include "tool.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <Eigen/Geometry>
#include <numbers>
#include <spidar/limited-device.hpp>
#include <spidar/usb.hpp>
#include <thread>

using namespace spidar_tools;
using namespace std::chrono_literals;
namespace messages = spidar::messages;

namespace {

constexpr auto kTick = 1ms;
constexpr int kTicksPerLine = 100;

std::atomic<bool> interrupted = false;

ExitStatus list() {
  const std::vector<spidar::UsbUnit> units = spidar::list_usb();
  if (units.empty()) {
    std::printf(messages::kNotOnUsb, "", "");
    std::printf("\nTo try without one: --device sim --watch\n");
    return kNotFound;
  }
  ExitStatus worst = kFine;
  for (const spidar::UsbUnit &unit : units) {
    std::printf("SPIDAR-G, controller %s, USB bus %d device %d (port %s), ", unit.model.c_str(),
                unit.bus, unit.address, unit.port.c_str());
    if (unit.problem) {
      std::printf("cannot be used:\n  %s\n", unit.problem->what());
      worst = worst == kFine ? status_of(*unit.problem) : worst;
    } else {
      std::printf("rotary switch %d: device=usb:%d\n", *unit.switch_at, *unit.switch_at);
    }
    for (const spidar::UsbUnit &other : units)
      if (&other != &unit && unit.switch_at && other.switch_at == unit.switch_at) {
        std::printf("  %s\n", messages::kToolSameSwitch);
        worst = worst == kFine ? kUsage : worst;
      }
  }
  return worst;
}

void show(const char *name, const char *unit, const spidar::StringLengths &values, double scale) {
  std::printf("  %-8s", name);
  for (const double value : values)
    std::printf(" %9.3f", value * scale);
  std::printf("  %s\n", unit);
}

void show(double time, const spidar::Device &device) {
  const spidar::DeviceState &state = device.state();
  const Eigen::AngleAxisd turn(state.pose.rotation);
  const spidar::Vector3 angles = turn.angle() * turn.axis() * 180 / std::numbers::pi;
  const spidar::Vector3 millimetres = state.pose.position * 1e3;
  std::printf("%.1f s  position %.2f %.2f %.2f mm  turned %.2f %.2f %.2f degrees%s\n", time,
              millimetres.x(), millimetres.y(), millimetres.z(), angles.x(), angles.y(), angles.z(),
              state.valid ? "" : "  (not to be trusted: does a string hang loose?)");
  std::printf("  counts  ");
  for (const std::int32_t count : state.counts)
    std::printf(" %9d", count);
  std::printf("\n  inputs   0x%04x%s\n", device.inputs(),
              device.geometry().button ? state.pressed ? "  pressed" : "  not pressed" : "");
  show("lengths", "mm", state.lengths, 1e3);
  show("tensions", "N", state.tensions, 1);
  std::fflush(stdout);
}

ExitStatus watch(const Choice &choice, double seconds) {
  const auto device = open_device(choice);
  std::printf("%s\n", device->description().c_str());
  print_remark(*device);
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = true; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  spidar::LimitedDevice limited(*device);
  const auto begin = std::chrono::steady_clock::now();
  int silent = 0;
  for (long tick = 0; !interrupted && (seconds <= 0 || static_cast<double>(tick) < seconds * 1e3);
       ++tick) {
    std::this_thread::sleep_until(begin + tick * kTick);
    silent = limited.exchange(spidar::monotonic_time()) ? 0 : silent + 1;
    if (!device->connected() || silent >= 100)
      spidar::fail(spidar::Cause::io, messages::kToolSilent);
    limited.command({});
    if (tick % kTicksPerLine == 0)
      show(static_cast<double>(tick) * 1e-3, *device);
  }
  return kFine;
}

} // namespace

int main(int argc, char **argv) {
  gboolean watching = FALSE;
  double seconds = 0;
  const GOptionEntry own[] = {
      {"watch", 'w', 0, G_OPTION_ARG_NONE, &watching,
       "show counts, string lengths, pose and tensions ten times a second, until Ctrl-C. Hold the "
       "grip in the centre when it begins",
       nullptr},
      {"seconds", 's', 0, G_OPTION_ARG_DOUBLE, &seconds, "watch for S seconds", "S"},
      {}};
  Options options("",
                  "Lists the SPIDAR-G controllers on USB. With --device it shows once what that "
                  "device measures.\n\nExample: spidar-info --watch --device sim",
                  own);
  if (!options.parse(argc, argv))
    return kUsage;
  return run([&] {
    const Choice choice = options.choice();
    if (watching || seconds > 0)
      return watch(choice, seconds);
    return choice.device_named ? watch(choice, 1e-3) : list();
  });
}
