// SPDX-License-Identifier: LGPL-2.1-or-later
// Builds and parses the messages of USB/IP, version 1.1.1: pure functions of bytes. Source:
// Documentation/usb/usbip_protocol of the Linux kernel. All numbers are big-endian.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace emulator::usbip {

using Bytes = std::vector<std::uint8_t>;

inline constexpr std::size_t kRequestHeader = 8;
inline constexpr std::size_t kBusId = 32; ///< follows the header of a request to import
inline constexpr std::size_t kCommand = 48;

/// Larger transfers are refused: no packet for this device is so large.
inline constexpr std::uint32_t kLargestTransfer = 1 << 20;

enum class Request { list, import };

/// Returns nothing for another version or an unknown code.
std::optional<Request> parse_request(std::span<const std::uint8_t, kRequestHeader> bytes) noexcept;

/// The text before the first zero byte, which need not be there.
std::string parse_bus_id(std::span<const std::uint8_t, kBusId> bytes);

enum class ImportStatus : std::uint32_t { ok = 0, busy = 2, no_device = 4 };

/// One exported device with one interface.
struct DeviceRecord {
  std::string bus_id;
  std::uint32_t bus = 0;
  std::uint32_t device = 0;
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint16_t release = 0;
  std::uint8_t device_class = 0;
  std::uint8_t interface_class = 0;
};

void put_list(Bytes &out, std::span<const DeviceRecord> devices);
void put_imported(Bytes &out, const DeviceRecord &device);
void put_refused(Bytes &out, ImportStatus status);

struct Command {
  enum class Kind { submit, unlink };
  Kind kind = Kind::submit;
  std::uint32_t sequence = 0;
  bool in = false;
  std::uint8_t endpoint = 0; ///< number without the direction
  std::uint32_t length = 0;  ///< submit: of the data, which follow the command when going out
  std::uint32_t victim = 0;  ///< unlink: the sequence number of the transfer to give up
  std::array<std::uint8_t, 8> setup{};
};

/// Returns nothing for unknown commands, isochronous transfers, and endpoint numbers or lengths out
/// of range.
std::optional<Command> parse_command(std::span<const std::uint8_t, kCommand> bytes) noexcept;

/// `status` is 0 or a negative errno of Linux. `data` only of a transfer to the host.
void put_submitted(Bytes &out, std::uint32_t sequence, std::int32_t status, std::uint32_t actual,
                   std::span<const std::uint8_t> data);
void put_unlinked(Bytes &out, std::uint32_t sequence, std::int32_t status);

} // namespace emulator::usbip
