// SPDX-License-Identifier: LGPL-2.1-or-later
#include "guarded-motors.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

namespace spidar {

namespace {

constexpr unsigned kWriteTime = 5;  // ms for one attempt
constexpr unsigned kReadTime = 1;   // ms; what waits is there at once
constexpr int kMostReplies = 64;    // read at once
constexpr int kBetweenAttempts = 1; // ms
constexpr int kWritesAtTheEnd = 2;  // a controller may lose one
constexpr int kAttemptsAtRest = 10;

} // namespace

bool GuardedMotors::receive_order() noexcept {
  std::array<unsigned char, sizeof(GuardianOrder) + kLargestGuardedPacket> bytes{};
  alignas(cmsghdr) std::array<unsigned char, CMSG_SPACE(sizeof(int))> extra{};
  iovec part{.iov_base = bytes.data(), .iov_len = bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = extra.data();
  message.msg_controllen = extra.size();
  const ssize_t size = recvmsg(control_, &message, 0);
  if (size < 1)
    return false;
  accept_device(message);
  GuardianOrder order;
  if (bytes[0] != order.version) {
    notify(kOtherVersion, 0);
    return false;
  }
  if (size <= static_cast<ssize_t>(sizeof order))
    return false;
  std::memcpy(&order, bytes.data(), sizeof order);
  endpoint_ = order.endpoint;
  reply_endpoint_ = order.reply_endpoint;
  patience_ = order.patience;
  size_ = static_cast<unsigned>(size) - static_cast<unsigned>(sizeof order);
  std::memcpy(packet_, bytes.data() + sizeof order, size_);
  struct stat status = {};
  if (fstat(device_, &status) != 0)
    return false;
  is_socket_ = S_ISSOCK(status.st_mode);
  return true;
}

void GuardedMotors::accept_device(msghdr &message) noexcept {
  const cmsghdr *header = CMSG_FIRSTHDR(&message);
  if (header && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS)
    std::memcpy(&device_, CMSG_DATA(header), sizeof device_);
}

bool GuardedMotors::notify(std::uint8_t kind, std::uint32_t value) const noexcept {
  const GuardianNotice notice{
      .kind = kind, .intervention = intervention_, .value = value, .replies = replies_};
  return send(control_, &notice, sizeof notice, MSG_NOSIGNAL | MSG_DONTWAIT) == sizeof notice;
}

void GuardedMotors::guard() noexcept {
  if (notify(kWatching, static_cast<std::uint32_t>(getpid())))
    watch();
  end_at_rest();
}

/// Watches until the process ends.
void GuardedMotors::watch() noexcept {
  for (;;) {
    pollfd control{.fd = control_, .events = POLLIN, .revents = 0};
    const int ready = poll(&control, 1, silence_);
    if (ready < 0 && errno == EINTR)
      continue;
    if (ready == 0)
      intervene();
    else if (ready < 0 || !hear())
      return;
  }
}

/// Puts the motors at rest, and will do so again until the process knows of it.
void GuardedMotors::intervene() noexcept {
  if (!intervenes_) {
    intervenes_ = true;
    ++intervention_;
    answer(); // before it writes: the process must tell the replies apart
  }
  switch (rest()) {
  case Written::delivered:
    silence_ = kGuardianRepeat;
    break;
  case Written::refused:
    silence_ = kBetweenAttempts;
    break;
  case Written::gone:
    intervenes_ = force_ = false;
    silence_ = -1;
    answer();
  }
}

/// Receives a word and answers it. False if the process has ended.
bool GuardedMotors::hear() noexcept {
  GuardianWord word;
  if (recv(control_, &word, sizeof word, 0) != sizeof word)
    return false;
  force_ = word.state == kForce;
  intervenes_ = intervenes_ && word.intervention != intervention_;
  if (!intervenes_)
    silence_ = force_ ? patience_ : -1;
  answer();
  return true;
}

/// Writes the rest packet until it was delivered, or the device is gone.
void GuardedMotors::end_at_rest() noexcept {
  constexpr timespec kPause{.tv_sec = 0, .tv_nsec = kBetweenAttempts * 1'000'000L};
  const bool force = force_ || intervenes_;
  int delivered = 0;
  for (int attempt = 0; delivered < kWritesAtTheEnd; ++attempt) {
    const Written written = rest();
    if (written == Written::gone)
      return;
    if (written == Written::delivered) {
      ++delivered;
      continue;
    }
    // At rest already, or for the second one, a limit: a device that takes nothing stays claimed.
    if ((!force || delivered > 0) && attempt >= kAttemptsAtRest)
      return;
    nanosleep(&kPause, nullptr);
  }
}

GuardedMotors::Written GuardedMotors::rest() noexcept {
  if (write()) {
    ++delivered_;
    return Written::delivered;
  }
  switch (errno) {
  case ENODEV:
  case ECONNRESET:
  case ENOTCONN:
  case ENOTTY: // the four after these: no attempt can ever succeed
  case EBADF:
  case EINVAL:
  case ENOENT:
    return Written::gone;
  case EPIPE:
    if (is_socket_)
      return Written::gone;
    ioctl(device_, USBDEVFS_CLEAR_HALT, &endpoint_);
    return Written::refused;
  default: // of an unplugged device, ESHUTDOWN comes once, and then ENODEV
    read_replies();
    return Written::refused;
  }
}

bool GuardedMotors::write() noexcept {
  if (is_socket_)
    return send(device_, packet_, size_, MSG_NOSIGNAL | MSG_DONTWAIT) ==
           static_cast<ssize_t>(size_);
  usbdevfs_bulktransfer transfer{
      .ep = endpoint_, .len = size_, .timeout = kWriteTime, .data = packet_};
  return ioctl(device_, USBDEVFS_BULK, &transfer) == static_cast<int>(size_);
}

/// A controller takes no more packets while its replies wait, and a stopped process reads none.
void GuardedMotors::read_replies() noexcept {
  if (reply_endpoint_ == 0)
    return;
  unsigned char reply[kLargestGuardedPacket];
  usbdevfs_bulktransfer transfer{
      .ep = reply_endpoint_, .len = sizeof reply, .timeout = kReadTime, .data = reply};
  for (int i = 0; i < kMostReplies && ioctl(device_, USBDEVFS_BULK, &transfer) >= 0; ++i)
    ++replies_;
}

} // namespace spidar
