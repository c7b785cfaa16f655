// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mock-bus.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <linux/usb/ch9.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <thread>
#include <utility>

namespace test {

namespace {

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

/// The kernel's side of one device: ioctl()s of usbfs in, transfers of the unit out.
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
  std::uint32_t next_sequence = 1;
  std::map<std::uint32_t, Flying> flying;
  std::deque<Flying> landed;
  const void *claimed_by = nullptr;

  ~Socket() { g_object_unref(handler); }

  void land(const Flying &one, int status, int length) {
    one.urb->status = status;
    one.urb->actual_length = length;
    landed.push_back(one);
  }

  void land(const std::vector<emulator::Completion> &done) {
    for (const emulator::Completion &completion : done) {
      const auto node = flying.extract(completion.sequence);
      std::copy(completion.data.begin(), completion.data.end(),
                static_cast<std::uint8_t *>(node.mapped().urb->buffer));
      land(node.mapped(), completion.status, static_cast<int>(completion.actual));
    }
  }

  void submit(const void *client, usbdevfs_urb &urb) {
    const std::uint32_t sequence = next_sequence++;
    flying[sequence] = {client, &urb};
    const bool in = (urb.endpoint & USB_DIR_IN) != 0;
    const auto size = static_cast<std::size_t>(urb.buffer_length);
    emulator::Transfer transfer{.sequence = sequence,
                                .in = in,
                                .endpoint = static_cast<std::uint8_t>(urb.endpoint & 0x0f),
                                .length = static_cast<std::uint32_t>(size)};
    if (!in)
      transfer.data = {static_cast<const std::uint8_t *>(urb.buffer), size};
    std::vector<emulator::Completion> done;
    unit->use([&](emulator::Unit &u) { u.submit(transfer, emulator::Clock::now(), done); });
    land(done);
  }

  /// Moves what can move.
  void work() {
    if (!here) {
      for (const auto &[sequence, one] : std::exchange(flying, {}))
        land(one, -ESHUTDOWN, 0);
      return;
    }
    std::vector<emulator::Completion> done;
    unit->use([&](emulator::Unit &u) { u.collect(emulator::Clock::now(), done); });
    land(done);
  }

  /// A control transfer: bytes transferred, or nothing if the unit refused it.
  std::optional<int> control(const usbdevfs_ctrltransfer &request) {
    const auto low = [](std::uint16_t word) { return static_cast<std::uint8_t>(word & 0xff); };
    const auto high = [](std::uint16_t word) { return static_cast<std::uint8_t>(word >> 8); };
    const emulator::Transfer transfer{.in = (request.bRequestType & USB_DIR_IN) != 0,
                                      .length = request.wLength,
                                      .setup = {request.bRequestType, request.bRequest,
                                                low(request.wValue), high(request.wValue),
                                                low(request.wIndex), high(request.wIndex),
                                                low(request.wLength), high(request.wLength)}};
    std::vector<emulator::Completion> done;
    unit->use([&](emulator::Unit &u) { u.submit(transfer, emulator::Clock::now(), done); });
    if (done.front().status != 0)
      return std::nullopt;
    std::copy(done.front().data.begin(), done.front().data.end(),
              static_cast<std::uint8_t *>(request.data));
    return static_cast<int>(done.front().actual);
  }

  /// A transfer that its thread waits for.
  Outcome bulk(const void *client, const usbdevfs_bulktransfer &transfer) {
    usbdevfs_urb urb;
    std::memset(&urb, 0, sizeof urb); // it ends with an array that has no size, so no braces
    const auto is_ours = [wanted = &urb](const Flying &one) { return one.urb == wanted; };
    urb.endpoint = static_cast<unsigned char>(transfer.ep);
    urb.buffer = transfer.data;
    urb.buffer_length = static_cast<int>(transfer.len);
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(transfer.timeout);
    for (bool submitted = false;; std::this_thread::sleep_for(std::chrono::microseconds(50))) {
      const std::lock_guard lock(mutex);
      if (!std::exchange(submitted, true)) {
        if (!here)
          return {ENODEV};
        submit(client, urb);
      }
      work();
      if (std::erase_if(landed, is_ours) > 0)
        return urb.status != 0 ? Outcome{-urb.status} : Outcome{0, urb.actual_length};
      if (std::chrono::steady_clock::now() >= end) {
        discard(&urb);
        std::erase_if(landed, is_ours);
        return {ETIMEDOUT};
      }
    }
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
                                    [&](const auto &one) { return one.second.urb == wanted; });
    if (found == flying.end())
      return {EINVAL};
    unit->use([&](emulator::Unit &u) { return u.unlink(found->first); });
    land(found->second, -ENOENT, 0);
    flying.erase(found);
    return {};
  }

  Outcome claim(const void *client) {
    if (held || (claimed_by && claimed_by != client))
      return {EBUSY};
    claimed_by = client;
    return {};
  }

  Outcome clear_halt(unsigned endpoint) {
    ++bus->halts_cleared;
    control({.bRequestType = USB_RECIP_ENDPOINT,
             .bRequest = USB_REQ_CLEAR_FEATURE,
             .wValue = USB_ENDPOINT_HALT,
             .wIndex = static_cast<std::uint16_t>(endpoint)});
    return {};
  }

  /// Drops the transfers of a program that has closed the device.
  void forget(const void *client) {
    if (claimed_by == client)
      claimed_by = nullptr;
    for (auto one = flying.begin(); one != flying.end();) {
      const auto next = std::next(one);
      if (one->second.client == client) {
        unit->use([&](emulator::Unit &u) { return u.unlink(one->first); });
        flying.erase(one);
      }
      one = next;
    }
    std::erase_if(landed, [client](const Flying &one) { return one.client == client; });
  }

  /// `client` tells those who have the device open apart.
  Outcome handle(const void *client, unsigned long request, void *argument) {
    if (request == USBDEVFS_BULK)
      return bulk(client, as<usbdevfs_bulktransfer>(argument));
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
      return {0, USB_SPEED_HIGH};
    case USBDEVFS_CONTROL: {
      const auto size = control(as<usbdevfs_ctrltransfer>(argument));
      return size ? Outcome{0, *size} : Outcome{EPIPE};
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      return claim(client);
    case USBDEVFS_RELEASEINTERFACE: // ends the transfers of all who have the device open
      claimed_by = nullptr;
      for (const auto &[sequence, one] : std::exchange(flying, {})) {
        unit->use([&](emulator::Unit &u) { return u.unlink(sequence); });
        land(one, -ESHUTDOWN, 0);
      }
      return {};
    case USBDEVFS_CLEAR_HALT:
      return clear_halt(as<unsigned>(argument));
    case USBDEVFS_GETDRIVER:
      return {ENODATA};
    case USBDEVFS_SUBMITURB:
      submit(client, as<usbdevfs_urb>(argument));
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
  struct stat file = {};
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
  if (before_ioctl)
    before_ioctl();
  const auto *client = reinterpret_cast<const void *>(static_cast<std::intptr_t>(descriptor));
  const Outcome outcome = wanted->handle(client, request, argument);
  errno = outcome.error ? outcome.error : errno;
  return outcome.error ? -1 : outcome.result;
}

void MockBus::work() {
  const std::lock_guard lock(mutex_);
  for (const auto &[device, socket] : sockets_) {
    const std::lock_guard socket_lock(socket->mutex);
    socket->work();
  }
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
  socket.forget(client);
}

/// Shows the device in /dev, and in sysfs with the attributes that libusb reads.
void MockBus::show(const Socket &socket, std::uint16_t vendor, std::uint16_t product) {
  const std::string file = node(socket.device);
  const std::string bytes = hexadecimal(emulator::device_descriptor(vendor, product, false)) +
                            hexadecimal(emulator::configuration_descriptor());
  const std::string record =
      "P: " + socket.path + "\nN: " + file.substr(5) + "=" + bytes +
      "\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=" + file.substr(17) +
      "\nE: DEVNAME=" + file +
      "\nE: DEVTYPE=usb_device\nA: bConfigurationValue=1\\n\nA: busnum=1\\n"
      "\nA: devnum=" +
      std::to_string(socket.device) + "\\n\nA: speed=480\\n\nH: descriptors=" + bytes + "\n";
  GError *error = nullptr;
  if (!umockdev_testbed_add_from_string(testbed_, record.c_str(), &error))
    g_error("%s", error->message);
}

int MockBus::plug(std::shared_ptr<MockUnit> unit, std::uint16_t vendor, std::uint16_t product) {
  if (product == 0)
    product = emulator::product_id(unit->model());
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
  socket->unit->use([](emulator::Unit &u) { u.attach(emulator::Clock::now()); });
  socket->control({.bRequest = USB_REQ_SET_CONFIGURATION, .wValue = 1}); // the kernel's choice
  g_signal_connect(socket->handler, "handle-ioctl", G_CALLBACK(on_ioctl), socket.get());
  g_signal_connect(socket->handler, "client-vanished", G_CALLBACK(on_vanished), socket.get());
  umockdev_testbed_attach_ioctl(testbed_, node(device).c_str(), socket->handler, nullptr);
  show(*socket, vendor, product);
  const std::lock_guard lock(mutex_);
  struct stat file = {};
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
