// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mock-bus.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

namespace test {

namespace {

constexpr std::uint8_t kIn = 0x86;

// An endpoint before the known ones, as the units have.
Bytes descriptors(std::uint16_t vendor, std::uint16_t product) {
  const auto low = [](std::uint16_t word) { return static_cast<std::uint8_t>(word); };
  const auto high = [](std::uint16_t word) { return static_cast<std::uint8_t>(word >> 8); };
  return {
      18,
      1,
      0x00,
      0x02,
      0xff,
      0,
      0,
      64,
      low(vendor),
      high(vendor),
      low(product),
      high(product),
      0x00,
      0x01,
      0,
      0,
      0,
      1, // device
      9,
      2,
      39,
      0,
      1,
      1,
      0,
      0x80,
      50, // configuration
      9,
      4,
      0,
      0,
      3,
      0xff,
      0,
      0,
      0, // interface
      7,
      5,
      0x81,
      0x02,
      0x00,
      0x02,
      0, // bulk endpoints
      7,
      5,
      0x02,
      0x02,
      0x00,
      0x02,
      0, //
      7,
      5,
      0x86,
      0x02,
      0x00,
      0x02,
      0, //
  };
}

std::string hexadecimal(const Bytes &bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    std::array<char, 3> digits;
    std::snprintf(digits.data(), digits.size(), "%02X", byte);
    text += digits.data();
  }
  return text;
}

/// What an ioctl() comes to.
struct Outcome {
  int error = 0;
  int result = 0;
};

template <class T>
T &as(void *argument) {
  return *static_cast<T *>(argument);
}

} // namespace

bool mocking() noexcept {
  const char *loaded = std::getenv("LD_PRELOAD");
  return loaded && std::strstr(loaded, "umockdev");
}

/// The kernel's side of one device.
struct MockBus::Socket {
  MockBus *bus;
  int device;
  std::shared_ptr<MockUnit> unit;
  UMockdevIoctlBase *handler;
  std::string path; ///< in sysfs
  ino_t inode = 0;
  std::atomic<bool> here = true;
  std::atomic<bool> held = false;

  struct Flying {
    const void *client;
    usbdevfs_urb *urb;
  };
  std::mutex mutex;
  std::deque<Flying> flying;
  std::deque<Flying> landed;
  const void *claimed_by = nullptr;

  ~Socket() { g_object_unref(handler); }

  void land(const Flying &one, int status, int length) {
    one.urb->status = status;
    one.urb->actual_length = length;
    landed.push_back(one);
  }

  /// Moves what can move.
  void work() {
    std::deque<Flying> left;
    bool out_waits = false;
    for (const Flying &one : flying) {
      const bool in = one.urb->endpoint == kIn;
      if (!here) {
        land(one, -ESHUTDOWN, 0);
      } else if (!in && !out_waits && !unit->blocked()) {
        const auto *bytes = static_cast<const std::uint8_t *>(one.urb->buffer);
        unit->take(Bytes(bytes, bytes + one.urb->buffer_length));
        land(one, 0, one.urb->buffer_length);
      } else if (in && unit->has_answer()) {
        receive(one);
      } else {
        out_waits = out_waits || !in;
        left.push_back(one);
      }
    }
    flying = std::move(left);
  }

  void receive(const Flying &one) {
    const MockUnit::Answer answer = unit->answer();
    if (answer.stall)
      return land(one, -EPIPE, 0);
    const auto room = static_cast<std::size_t>(one.urb->buffer_length);
    const std::size_t size = std::min(answer.bytes.size(), room);
    std::memcpy(one.urb->buffer, answer.bytes.data(), size);
    land(one, answer.bytes.size() > room ? -EOVERFLOW : 0, static_cast<int>(size));
  }

  Outcome reap(const void *client, void *argument) {
    work();
    const auto ours = std::find_if(landed.begin(), landed.end(),
                                   [&](const Flying &one) { return one.client == client; });
    if (ours == landed.end())
      return {here ? EAGAIN : ENODEV};
    as<void *>(argument) = ours->urb;
    landed.erase(ours);
    return {};
  }

  Outcome discard(const void *wanted) {
    const auto found = std::find_if(flying.begin(), flying.end(),
                                    [&](const Flying &one) { return one.urb == wanted; });
    if (found == flying.end())
      return {EINVAL};
    land(*found, -ENOENT, 0);
    flying.erase(found);
    return {};
  }

  /// `client` tells those who have the device open apart.
  Outcome handle(const void *client, unsigned long request, void *argument) {
    const std::lock_guard lock(mutex);
    if (request == USBDEVFS_REAPURBNDELAY || request == USBDEVFS_REAPURB)
      return reap(client, argument);
    if (!here)
      return {ENODEV};
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      as<std::uint32_t>(argument) =
          USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_BULK_CONTINUATION |
          USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      return {};
    case USBDEVFS_CONNECTINFO:
      as<usbdevfs_connectinfo>(argument) = {.devnum = static_cast<unsigned>(device), .slow = 0};
      return {};
    case USBDEVFS_GET_SPEED:
      return {0, 3};         // high
    case USBDEVFS_CONTROL: { // the active configuration
      auto &transfer = as<usbdevfs_ctrltransfer>(argument);
      *static_cast<std::uint8_t *>(transfer.data) = 1;
      return {0, 1};
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      if (held || (claimed_by && claimed_by != client))
        return {EBUSY};
      claimed_by = client;
      return {};
    case USBDEVFS_RELEASEINTERFACE:
      claimed_by = nullptr;
      return {};
    case USBDEVFS_CLEAR_HALT:
      ++bus->halts_cleared;
      unit->clear_halt();
      return {};
    case USBDEVFS_GETDRIVER:
      return {ENODATA};
    case USBDEVFS_SUBMITURB:
      flying.push_back({client, &as<usbdevfs_urb>(argument)});
      work();
      return {};
    case USBDEVFS_DISCARDURB:
      return discard(argument);
    default:
      return {ENOTTY};
    }
  }
};

MockBus::MockBus() : testbed_(umockdev_testbed_new()) {}

MockBus::~MockBus() {
  g_object_unref(testbed_);
}

std::string MockBus::node(int device) {
  std::array<char, 64> path;
  std::snprintf(path.data(), path.size(), "/dev/bus/usb/001/%03d", device);
  return path.data();
}

std::string MockBus::root() const {
  gchar *directory = umockdev_testbed_get_root_dir(testbed_);
  std::string result = directory;
  g_free(directory);
  return result;
}

std::optional<int> MockBus::ioctl(int descriptor, unsigned long request, void *argument) {
  struct stat file {};
  if (_IOC_TYPE(request) != 'U' || fstat(descriptor, &file) != 0)
    return std::nullopt;
  Socket *wanted = nullptr;
  {
    const std::lock_guard lock(mutex_);
    for (const auto &socket : unplugged_)
      if (socket->inode == file.st_ino)
        wanted = socket.get();
    for (const auto &[device, socket] : sockets_) // a newer one may have got the number again
      if (socket->inode == file.st_ino)
        wanted = socket.get();
  }
  if (!wanted)
    return std::nullopt;
  const auto *client = reinterpret_cast<const void *>(static_cast<std::intptr_t>(descriptor));
  const Outcome outcome = wanted->handle(client, request, argument);
  errno = outcome.error ? outcome.error : errno;
  return outcome.error ? -1 : outcome.result;
}

gboolean MockBus::on_ioctl(UMockdevIoctlBase *, UMockdevIoctlClient *client, gpointer socket) {
  // The client is this process: its memory needs no copying.
  void *argument = nullptr;
  std::memcpy(&argument, umockdev_ioctl_client_get_arg(client)->data, sizeof argument);
  const Outcome outcome = static_cast<Socket *>(socket)->handle(
      client, umockdev_ioctl_client_get_request(client), argument);
  umockdev_ioctl_client_complete(client, outcome.error ? -1 : outcome.result, outcome.error);
  return TRUE;
}

void MockBus::on_vanished(UMockdevIoctlBase *, UMockdevIoctlClient *client, gpointer data) {
  auto &socket = *static_cast<Socket *>(data);
  const std::lock_guard lock(socket.mutex);
  if (socket.claimed_by == client)
    socket.claimed_by = nullptr;
  const auto theirs = [client](const Socket::Flying &one) { return one.client == client; };
  std::erase_if(socket.flying, theirs);
  std::erase_if(socket.landed, theirs);
}

int MockBus::plug(std::shared_ptr<MockUnit> unit, std::uint16_t vendor, std::uint16_t product) {
  if (product == 0)
    product = unit->model() == Model::sh4 ? 0x0205 : 0x0203;
  while (sockets_.count(next_device_))
    next_device_ = next_device_ % 127 + 1;
  const int device = next_device_;
  next_device_ = next_device_ % 127 + 1; // another number each time, as in the kernel
  auto socket = std::make_unique<Socket>();
  socket->bus = this;
  socket->device = device;
  socket->unit = std::move(unit);
  socket->handler = umockdev_ioctl_base_new();
  socket->path = "/devices/usb1/1-" + std::to_string(device);
  g_signal_connect(socket->handler, "handle-ioctl", G_CALLBACK(on_ioctl), socket.get());
  g_signal_connect(socket->handler, "client-vanished", G_CALLBACK(on_vanished), socket.get());
  const std::string number = std::to_string(device);
  umockdev_testbed_attach_ioctl(testbed_, node(device).c_str(), socket->handler, nullptr);
  const std::string bytes = hexadecimal(descriptors(vendor, product));
  const std::string record =
      "P: " + socket->path + "\nN: " + node(device).substr(5) + "=" + bytes +
      "\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=" + node(device).substr(17) +
      "\nE: DEVNAME=" + node(device) +
      "\nE: DEVTYPE=usb_device\nA: bConfigurationValue=1\\n\nA: busnum=1\\n"
      "\nA: devnum=" +
      number + "\\n\nA: speed=480\\n\nH: descriptors=" + bytes + "\n";
  GError *error = nullptr;
  if (!umockdev_testbed_add_from_string(testbed_, record.c_str(), &error))
    g_error("%s", error->message);
  const std::lock_guard lock(mutex_);
  struct stat file {};
  stat((root() + node(device)).c_str(), &file);
  socket->inode = file.st_ino;
  sockets_[device] = std::move(socket);
  return device;
}

std::chrono::steady_clock::time_point MockBus::unplug(int device) {
  std::unique_ptr<Socket> &socket = sockets_.at(device);
  socket->here = false;
  const auto instant = std::chrono::steady_clock::now();
  umockdev_testbed_uevent(testbed_, ("/sys" + socket->path).c_str(), "remove");
  umockdev_testbed_remove_device(testbed_, ("/sys" + socket->path).c_str());
  remove((root() + node(device)).c_str());
  umockdev_testbed_detach_ioctl(testbed_, node(device).c_str(), nullptr);
  const std::lock_guard lock(mutex_);
  unplugged_.push_back(std::move(socket));
  sockets_.erase(device);
  return instant;
}

void MockBus::hold(int device, bool held) {
  sockets_.at(device)->held = held;
}

void MockBus::forbid(int device) {
  chmod(root().c_str(), 0777); // a test may give up being root, to whom nothing is forbidden
  chmod((root() + "/ioctl" + node(device)).c_str(), 0777);
  chmod((root() + node(device)).c_str(), 0);
}

} // namespace test
