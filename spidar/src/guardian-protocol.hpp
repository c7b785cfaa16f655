// SPDX-License-Identifier: LGPL-2.1-or-later
// Messages between a process and its guardian, on a SOCK_SEQPACKET socket.
//
// The process first sends the endpoint (one byte) and the rest packet; the guardian answers
// kWatching and its process number. Then the process sends kForce or kRest every few milliseconds,
// and the guardian kLetGo each time that it has written the rest packet.
#pragma once

#include <cstdint>

namespace spidar {

// Descriptors that the guardian finds open.
inline constexpr int kGuardianControl = 3;
inline constexpr int kGuardianDevice = 4;

inline constexpr int kGuardianPatience = 10; ///< ms of silence under a force
inline constexpr int kLargestGuardedPacket = 512;

inline constexpr std::uint8_t kRest = 0;  ///< the motors have minimum tension
inline constexpr std::uint8_t kForce = 1; ///< they have more
inline constexpr std::uint8_t kLetGo = 2; ///< the guardian has put them at rest
inline constexpr std::uint8_t kWatching = 3;

} // namespace spidar
