// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers of the packets in .hmpg, for its reader and its writer.
#pragma once

#include <cstddef>
#include <cstdint>

namespace haptic {

// Types of MIHS packets. A packet header has type 6 bits, length 17, reserved 1.
enum PacketType : std::uint8_t {
  kTiming,
  kMetadataHaptics,
  kMetadataPerception,
  kMetadataChannel,
  kMetadataBand,
  kData,
  kEffectLibrary,
  kCrc32,
  kCrc16,
  kGlobalCrc16,
  kGlobalCrc32,
  kInitializationTiming,
  kPacketTypes
};

inline constexpr std::size_t kPacketHeaderSize = 3;
inline constexpr std::uint8_t kNoDevice = 255;
inline constexpr std::int8_t kUnitExponent = -3; // the format's default
inline constexpr double kWidestGain = 10000;
inline constexpr double kCodes32 = 4294967295.0; // 2^32 - 1
inline constexpr unsigned kOptionBodyMask = 1;
inline constexpr unsigned kOptionResolution = 2;
inline constexpr unsigned kOptionDirection = 4;
inline constexpr std::uint32_t kHighestFrequency = 10000; // Hz
inline constexpr std::uint32_t kForceBandwidth = 1000;    // Hz, what a haptic loop can follow
inline constexpr unsigned kBasisEffect = 0;
inline constexpr unsigned kReferenceEffect = 1;
inline constexpr int kDeepestEffect = 4; // composite effects of composite ones
inline constexpr unsigned kMaskPosition = 1;
inline constexpr unsigned kMaskAmplitude = 2;
inline constexpr unsigned kMaskFrequency = 4;
inline constexpr unsigned kEffectTypes = 3;
inline constexpr unsigned kCurveKeyframeBits = 24;

} // namespace haptic
