// SPDX-License-Identifier: LGPL-2.1-or-later
// Messages between a process and its guardian, on a SOCK_SEQPACKET socket.
//
// The process first sends a GuardianOrder with the rest packet behind it; to a service, also the
// descriptor of the device. The guardian answers kWatching, or kOtherVersion. Then the process
// sends a GuardianWord every few milliseconds, and the guardian answers each with a GuardianNotice,
// which tells its whole state. After silence under a force it begins an intervention: it sends
// kResting, and then writes the rest packet again and again, until a word knows of this
// intervention. A process that was stopped may still write what it had decided before, however
// often it is stopped.
//
// guardian/guardian.pml is the model of this version, 0x14, with the reasons.
#pragma once

#include <cstdint>

namespace spidar {

// Descriptors that the guardian finds open. A service gets only the first, as systemd passes it.
inline constexpr int kGuardianControl = 3;
inline constexpr int kGuardianDevice = 4;

/// Name of the service's socket in $XDG_RUNTIME_DIR.
inline constexpr char kGuardianSocket[] = "spidar-guardian";

/// Changes with these messages. Above every endpoint number: version 1 sent that instead.
inline constexpr std::uint8_t kGuardianVersion = 0x14;

/// ms of silence under a force, with exchanges of 2 ms
inline constexpr int kGuardianPatience = 10;
/// ms between two rest packets of an intervention
inline constexpr int kGuardianRepeat = 5;
inline constexpr int kLargestGuardedPacket = 512;

struct GuardianOrder {
  std::uint8_t version = kGuardianVersion;
  std::uint8_t endpoint = 0;
  std::uint16_t patience = kGuardianPatience; ///< ms
  std::uint8_t reply_endpoint = 0;            ///< of the replies to the rest packet; 0: none come
  std::uint8_t unused = 0;
};

// Of the process: what was delivered to the motors last.
inline constexpr std::uint8_t kRest = 0;  ///< the motors have minimum tension
inline constexpr std::uint8_t kForce = 1; ///< they have more, or may have

struct GuardianWord {
  std::uint8_t state = kRest;
  std::uint8_t intervention = 0; ///< the newest that the process knows of
};

// Of the guardian.
inline constexpr std::uint8_t kWatching = 3;     ///< `value` is its process number
inline constexpr std::uint8_t kHere = 4;         ///< the answer to a word
inline constexpr std::uint8_t kResting = 5;      ///< it intervenes; also the answer to a word then
inline constexpr std::uint8_t kOtherVersion = 6; ///< of the order

struct GuardianNotice {
  std::uint8_t kind = 0;
  std::uint8_t version = kGuardianVersion;
  std::uint8_t intervention = 0; ///< number of the newest; the first is 1, 0 follows 255
  std::uint8_t unused = 0;
  std::uint32_t value = 0;   ///< rest packets delivered so far
  std::uint32_t replies = 0; ///< replies to any packet that the guardian has read so far
};

} // namespace spidar
