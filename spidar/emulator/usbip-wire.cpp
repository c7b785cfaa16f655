// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usbip-wire.hpp"

#include <algorithm>

namespace emulator::usbip {

namespace {

constexpr std::uint32_t kVersion = 0x0111;
constexpr std::uint32_t kListRequest = 0x8005;
constexpr std::uint32_t kImportRequest = 0x8003;
constexpr std::uint32_t kListReply = 0x0005;
constexpr std::uint32_t kImportReply = 0x0003;
constexpr std::uint32_t kSubmit = 1;
constexpr std::uint32_t kUnlink = 2;
constexpr std::uint32_t kSubmitted = 3;
constexpr std::uint32_t kUnlinked = 4;
constexpr std::uint32_t kHighSpeed = 3; // the kernel's enum usb_device_speed
constexpr std::uint32_t kNotIsochronous = 0xffffffff;
constexpr std::size_t kPath = 256;

std::uint32_t number(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes)
    value = value << 8 | byte;
  return value;
}

void put(Bytes &out, std::uint32_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8)
    out.push_back(static_cast<std::uint8_t>(value >> shift & 0xff));
}

/// With at least one zero byte at its end.
void put_text(Bytes &out, const std::string &text, std::size_t size) {
  const std::size_t used = std::min(text.size(), size - 1);
  out.insert(out.end(), text.begin(), text.begin() + static_cast<std::ptrdiff_t>(used));
  out.insert(out.end(), size - used, 0);
}

void put_header(Bytes &out, std::uint32_t code, ImportStatus status) {
  put(out, kVersion, 2);
  put(out, code, 2);
  put(out, static_cast<std::uint32_t>(status), 4);
}

void put_device(Bytes &out, const DeviceRecord &device) {
  put_text(out, "/sys/devices/spidar-emulator/usb1/" + device.bus_id, kPath);
  put_text(out, device.bus_id, kBusId);
  put(out, device.bus, 4);
  put(out, device.device, 4);
  put(out, kHighSpeed, 4);
  put(out, device.vendor, 2);
  put(out, device.product, 2);
  put(out, device.release, 2);
  put(out, device.device_class, 1);
  put(out, 0, 2); // subclass, protocol
  put(out, 1, 1); // the value of the present configuration
  put(out, 1, 1); // configurations
  put(out, 1, 1); // interfaces
}

/// The part that both replies share; a reply names no device, direction or endpoint.
void put_reply_header(Bytes &out, std::uint32_t code, std::uint32_t sequence, std::int32_t status) {
  put(out, code, 4);
  put(out, sequence, 4);
  out.insert(out.end(), 12, 0);
  put(out, static_cast<std::uint32_t>(status), 4);
}

} // namespace

std::optional<Request> parse_request(std::span<const std::uint8_t, kRequestHeader> bytes) noexcept {
  if (number(bytes.first(2)) != kVersion)
    return std::nullopt;
  switch (number(bytes.subspan(2, 2))) {
  case kListRequest:
    return Request::list;
  case kImportRequest:
    return Request::import;
  default:
    return std::nullopt;
  }
}

std::string parse_bus_id(std::span<const std::uint8_t, kBusId> bytes) {
  return {bytes.begin(), std::find(bytes.begin(), bytes.end(), 0)};
}

void put_list(Bytes &out, std::span<const DeviceRecord> devices) {
  put_header(out, kListReply, ImportStatus::ok);
  put(out, static_cast<std::uint32_t>(devices.size()), 4);
  for (const DeviceRecord &device : devices) {
    put_device(out, device);
    put(out, device.interface_class, 1);
    put(out, 0, 3); // subclass, protocol, padding
  }
}

void put_imported(Bytes &out, const DeviceRecord &device) {
  put_header(out, kImportReply, ImportStatus::ok);
  put_device(out, device);
}

void put_refused(Bytes &out, ImportStatus status) {
  put_header(out, kImportReply, status);
}

std::optional<Command> parse_command(std::span<const std::uint8_t, kCommand> bytes) noexcept {
  const auto field = [&](std::size_t offset) { return number(bytes.subspan(offset, 4)); };
  Command command;
  command.sequence = field(4);
  switch (field(0)) {
  case kUnlink:
    command.kind = Command::Kind::unlink;
    command.victim = field(0x14);
    return command;
  case kSubmit:
    break;
  default:
    return std::nullopt;
  }
  const std::uint32_t direction = field(0xc);
  const std::uint32_t endpoint = field(0x10);
  const std::uint32_t packets = field(0x20);
  command.length = field(0x18);
  if (direction > 1 || endpoint > 15 || command.length > kLargestTransfer ||
      (packets != 0 && packets != kNotIsochronous))
    return std::nullopt;
  command.in = direction == 1;
  command.endpoint = static_cast<std::uint8_t>(endpoint);
  std::copy_n(bytes.begin() + 0x28, command.setup.size(), command.setup.begin());
  return command;
}

void put_submitted(Bytes &out, std::uint32_t sequence, std::int32_t status, std::uint32_t actual,
                   std::span<const std::uint8_t> data) {
  put_reply_header(out, kSubmitted, sequence, status);
  put(out, actual, 4);
  put(out, 0, 4); // first frame
  put(out, kNotIsochronous, 4);
  out.insert(out.end(), 12, 0); // errors, padding
  out.insert(out.end(), data.begin(), data.end());
}

void put_unlinked(Bytes &out, std::uint32_t sequence, std::int32_t status) {
  put_reply_header(out, kUnlinked, sequence, status);
  out.insert(out.end(), 24, 0);
}

} // namespace emulator::usbip
