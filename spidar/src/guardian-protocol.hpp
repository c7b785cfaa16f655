// SPDX-License-Identifier: LGPL-2.1-or-later
// What a process and its guardian say to each other, in messages of a SOCK_SEQPACKET socket.
//
// First the endpoint (one byte) and the packet for it; the guardian answers kWatching and its
// process number. Then kForce or kRest every few milliseconds, and the other way kLetGo.
#pragma once

#include <cstdint>

namespace spidar {

// Descriptors that the guardian finds open.
inline constexpr int kGuardianControl = 3;
inline constexpr int kGuardianDevice = 4;

inline constexpr int kGuardianPatience = 10; ///< ms of silence under a force
inline constexpr int kLargestGuardedPacket = 512;

inline constexpr std::uint8_t kRest = 0;  ///< the motors have nothing but minimum tension
inline constexpr std::uint8_t kForce = 1; ///< they have more
inline constexpr std::uint8_t kLetGo = 2; ///< the guardian has put them at rest
inline constexpr std::uint8_t kWatching = 3;

} // namespace spidar
