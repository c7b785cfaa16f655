// SPDX-License-Identifier: LGPL-2.1-or-later
// Messages between a process and its guardian, on a SOCK_SEQPACKET socket.
//
// The process first sends a GuardianOrder with the rest packet behind it; to a service, also the
// descriptor of the device. The guardian answers kWatching, or kOtherVersion. Then the process
// sends kForce or kRest, one byte, every few milliseconds, and the guardian answers each with a
// GuardianNotice. It sends kWriting before it writes the rest packet, and kLetGo after each one
// that was delivered.
#pragma once

#include <cstdint>

namespace spidar {

// Descriptors that the guardian finds open. A service gets only the first, as systemd passes it.
inline constexpr int kGuardianControl = 3;
inline constexpr int kGuardianDevice = 4;

/// Name of the service's socket in $XDG_RUNTIME_DIR.
inline constexpr char kGuardianSocket[] = "spidar-guardian";

/// Changes with these messages. Above every endpoint number: version 1 sent that instead.
inline constexpr std::uint8_t kGuardianVersion = 0x13;

/// ms of silence under a force, with exchanges of 2 ms
inline constexpr int kGuardianPatience = 10;
inline constexpr int kLargestGuardedPacket = 512;

struct GuardianOrder {
  std::uint8_t version = kGuardianVersion;
  std::uint8_t endpoint = 0;
  std::uint16_t patience = kGuardianPatience; ///< ms
};

// Of the process: what was delivered to the motors last.
inline constexpr std::uint8_t kRest = 0;  ///< the motors have minimum tension
inline constexpr std::uint8_t kForce = 1; ///< they have more, or may have

// Of the guardian.
inline constexpr std::uint8_t kLetGo = 2;        ///< a rest packet was delivered
inline constexpr std::uint8_t kWatching = 3;     ///< `value` is its process number
inline constexpr std::uint8_t kHere = 4;         ///< the answer to a sign of life
inline constexpr std::uint8_t kWriting = 5;      ///< the same, while it tries to write
inline constexpr std::uint8_t kOtherVersion = 6; ///< of the order

struct GuardianNotice {
  std::uint8_t kind = 0;
  std::uint8_t version = kGuardianVersion;
  std::uint16_t unused = 0;
  std::uint32_t value = 0; ///< rest packets delivered so far
};

} // namespace spidar
