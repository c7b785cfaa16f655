// SPDX-License-Identifier: LGPL-2.1-or-later
// The binary stream of MPEG haptics (ISO/IEC 23090-31, "MIHS"; media type haptics/hmpg of RFC
// 9695): units and packets as bytes. What they mean for a motion track: hmpg-track.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace haptic {

enum class UnitType : std::uint8_t { initialization, temporal, spatial, silent };

struct UnitHeader {
  UnitType type = UnitType::initialization;
  bool dependent = false;
  std::uint8_t layer = 0;     ///< 0..15, 0 most important
  std::uint32_t duration = 0; ///< ticks, below 2^24
  std::uint32_t length = 0;   ///< bytes behind the header

  bool operator==(const UnitHeader &) const = default;
};

inline constexpr std::size_t kUnitHeaderSize = 9;
/// Far above any real one: a claim beyond it is damage.
inline constexpr std::size_t kLongestUnit = std::size_t{1} << 20; // bytes
inline constexpr std::uint32_t kHighestTimescale = 48000;         // ticks/s

/// Perception modalities that this project speaks about.
inline constexpr std::uint8_t kModalityForce = 9;

enum class BandType : std::uint8_t { transient, curve, vectorial, wavelet };

struct HmpgPerception {
  std::uint8_t id = 0;
  std::uint8_t modality = kModalityForce;
  std::int8_t exponent = 0; ///< of the perception's unit, power of ten
  std::string description;

  bool operator==(const HmpgPerception &) const = default;
};

struct HmpgChannel {
  std::uint16_t id = 0;
  std::uint8_t perception = 0;
  double gain = 1;
  std::optional<std::array<std::int8_t, 3>> direction; ///< of length 127
  std::string description;

  bool operator==(const HmpgChannel &) const = default;
};

struct HmpgBand {
  std::uint8_t id = 0;
  std::uint8_t perception = 0;
  std::uint16_t channel = 0;
  BandType type = BandType::curve;
  std::uint8_t curve = 2; ///< 2: linear

  bool operator==(const HmpgBand &) const = default;
};

/// What an initialization unit says.
struct HmpgExperience {
  std::uint32_t time = 0;      ///< ticks
  std::uint32_t timescale = 0; ///< ticks/s
  std::uint32_t nominal = 0;   ///< ticks, usual duration of a unit
  std::uint32_t deviation = 0; ///< ticks
  std::string version = "2023";
  std::string profile = "Main";
  std::uint8_t level = 1;
  std::string date;
  std::string description;
  std::vector<HmpgPerception> perceptions;
  std::vector<HmpgChannel> channels;
  std::vector<HmpgBand> bands;

  bool operator==(const HmpgExperience &) const = default;
};

struct HmpgKeyframe {
  std::int32_t position = 0;  ///< ticks from the beginning of the unit
  std::uint8_t amplitude = 0; ///< see amplitude_of_code()

  bool operator==(const HmpgKeyframe &) const = default;
};

/// One effect of a curve band.
struct HmpgCurve {
  std::uint8_t perception = 0;
  std::uint16_t channel = 0;
  std::uint8_t band = 0;
  std::uint16_t effect = 0;
  std::vector<HmpgKeyframe> keyframes; ///< 65535 at most, from the first on in 65535 ticks

  bool operator==(const HmpgCurve &) const = default;
};

/// -1..1 to 0..255, to the nearest.
std::uint8_t code_of_amplitude(double amplitude) noexcept;
/// The other way; the two codes next to zero, which has none of its own, are zero.
double amplitude_of_code(std::uint8_t code) noexcept;

// ---- writing ------------------------------------------------------------------------------------

std::vector<std::uint8_t> write_initialization_unit(const HmpgExperience &experience);
/// Independent. The duration is 1 to 2^24-1 ticks.
std::vector<std::uint8_t> write_temporal_unit(std::uint32_t duration,
                                              std::span<const HmpgCurve> curves);
std::vector<std::uint8_t> write_silent_unit(std::uint32_t duration);

// ---- reading ------------------------------------------------------------------------------------

struct HmpgError {
  const char *what;
  std::size_t offset; ///< bytes from the beginning of the unit
};

/// Nothing if there are too few bytes, or a field is impossible.
std::optional<UnitHeader> read_unit_header(std::span<const std::uint8_t> bytes) noexcept;

/// Whether a unit may begin here: its header, and that of its first packet. Where a stream is
/// entered in the middle, other bytes hardly ever do. Needs kUnitHeadSize bytes, unless the unit is
/// empty.
bool looks_like_unit(std::span<const std::uint8_t> bytes) noexcept;
inline constexpr std::size_t kUnitHeadSize = kUnitHeaderSize + 3;

struct HmpgUnit {
  UnitHeader header;
  std::optional<HmpgExperience> experience; ///< of an initialization unit
  std::vector<HmpgCurve> curves;            ///< of a temporal unit
  std::optional<HmpgError> error;           ///< then the rest is empty
};

/// Exactly one unit. A temporal unit needs the experience it belongs to. Bands that are no curves,
/// effects that refer to a library, and checksums are passed over.
HmpgUnit read_unit(std::span<const std::uint8_t> bytes, const HmpgExperience *experience);

} // namespace haptic
