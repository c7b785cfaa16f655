// SPDX-License-Identifier: LGPL-2.1-or-later
// A USB bus that is not there: umockdev shows it to the real libusb, and what usbfs would do is
// done here, in another thread of the same process.
#pragma once

#include "mock-unit.hpp"

#include <atomic>
#include <chrono>
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
  /// At whatever instant it is called; returns the instant.
  std::chrono::steady_clock::time_point unplug(int device);

  /// As if another program had the device: claiming it fails.
  void hold(int device, bool held);
  /// As if the node belonged to somebody else.
  void forbid(int device);
  static std::string node(int device);

  /// What usbfs says to an ioctl() in this process, without the two context switches that umockdev
  /// needs to say the same. Nothing for a descriptor that is not on this bus.
  std::optional<int> ioctl(int descriptor, unsigned long request, void *argument);

  std::atomic<int> resets = 0;
  std::atomic<int> halts_cleared = 0;

private:
  struct Socket;

  static gboolean on_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client,
                           gpointer socket);
  static void on_vanished(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer socket);

  std::string root() const;

  UMockdevTestbed *testbed_;
  std::mutex mutex_; ///< of the two lists
  std::map<int, std::unique_ptr<Socket>> sockets_;
  std::vector<std::unique_ptr<Socket>> unplugged_; ///< programs may still have them open
  int next_device_ = 5;
};

} // namespace test
