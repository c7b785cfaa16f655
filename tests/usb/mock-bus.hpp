// SPDX-License-Identifier: LGPL-2.1-or-later
// A mocked USB bus: umockdev shows it to the real libusb, and this program answers the ioctl()s of
// usbfs from another thread. Behind each device is the emulator's model of a controller.
#pragma once

#include "mock-unit.hpp"

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <umockdev.h>

namespace test {

/// Whether this process runs under umockdev-wrapper.
bool mocking() noexcept;

class MockBus {
public:
  MockBus();
  ~MockBus();
  MockBus(const MockBus &) = delete;
  MockBus &operator=(const MockBus &) = delete;

  /// Plugs `unit` in and returns its device number.
  int plug(std::shared_ptr<MockUnit> unit, std::uint16_t vendor = 0x0cec,
           std::uint16_t product = 0);
  /// Unplugs at once, whatever is under way. Returns the instant.
  std::chrono::steady_clock::time_point unplug(int device);

  /// As if another program had the device: claiming it fails.
  void hold(int device, bool held);
  /// As if the node belonged to somebody else.
  void forbid(int device);
  static std::string node(int device);

  /// Answers an ioctl() of this process as usbfs would, without the two context switches that
  /// umockdev needs. Returns nothing for a descriptor that is not on this bus.
  std::optional<int> ioctl(int descriptor, unsigned long request, void *argument);

  /// Moves packets that are on their way: what the kernel does while every program stands still.
  void work();

  /// Called before each ioctl() that a program makes here itself, in its thread: there it may stand
  /// still. Set it while nobody makes any.
  std::function<void()> before_ioctl;

  std::atomic<int> resets = 0;
  std::atomic<int> halts_cleared = 0;

private:
  struct Socket;

  static gboolean on_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client,
                           gpointer socket);
  static void on_vanished(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer socket);

  std::string root() const;
  void show(const Socket &socket, std::uint16_t vendor, std::uint16_t product);

  UMockdevTestbed *testbed_;
  std::mutex mutex_; ///< of the two lists
  std::map<int, std::unique_ptr<Socket>> sockets_;
  std::vector<std::unique_ptr<Socket>> unplugged_; ///< programs may still have them open
  int next_device_ = 5;
};

} // namespace test
