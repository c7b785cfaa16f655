// SPDX-License-Identifier: LGPL-2.1-or-later
// The binary stream of MPEG haptics (MPEG-I Haptic Stream, MIHS; media type haptics/hmpg of RFC
// 9695): units and packets as bytes. hmpg-track.hpp says what they mean for a motion track.
//
// Clause numbers are those of ISO/IEC 23090-31:2025, whose clause 5 is the data model. The layout
// of the bits is that of the standard's reference software, byte for byte (docs/formats/hmpg.md).
#pragma once

#include "mpeg-haptics/curve-interpolation.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace haptic {

/// RFC 9993, section 4.2, describes the four types. A spatial unit has no duration.
enum class UnitType : std::uint8_t { initialization, temporal, spatial, silent };

/// MIHS unit header: type 6 bits, sync 2, layer 4, duration 24, length 32, reserved 4.
struct UnitHeader {
  UnitType type = UnitType::initialization;
  bool dependent = false;
  std::uint8_t layer = 0;     ///< 0..15, 0 most important
  std::uint32_t duration = 0; ///< ticks, below 2^24
  std::uint32_t length = 0;   ///< bytes behind the header

  bool operator==(const UnitHeader &) const = default;
};

inline constexpr std::size_t kUnitHeaderSize = 9;
/// Far above any real unit. A longer one is taken for damage.
inline constexpr std::size_t kLongestUnit = std::size_t{1} << 20; // bytes
inline constexpr std::uint32_t kHighestTimescale = 48000;         // ticks/s

/// The perception modality Force (clause 5.4, haptic perception).
inline constexpr std::uint8_t kModalityForce = 9;

/// Clause 5.7, haptic band.
enum class BandType : std::uint8_t { transient, curve, vectorial, wavelet };

/// Clause 5.4, haptic perception.
struct HmpgPerception {
  std::uint8_t id = 0;
  std::uint8_t modality = kModalityForce;
  std::int8_t exponent = 0; ///< of the perception's unit, power of ten
  std::string description;

  bool operator==(const HmpgPerception &) const = default;
};

/// Clause 5.6, haptic channel.
struct HmpgChannel {
  std::uint16_t id = 0;
  std::uint8_t perception = 0;
  double gain = 1;
  std::optional<std::array<std::int8_t, 3>> direction; ///< of length 127
  std::string description;

  bool operator==(const HmpgChannel &) const = default;
};

/// Clause 5.7, haptic band.
struct HmpgBand {
  std::uint8_t id = 0;
  std::uint8_t perception = 0;
  std::uint16_t channel = 0;
  BandType type = BandType::curve;
  CurveType curve = CurveType::linear;

  bool operator==(const HmpgBand &) const = default;
};

/// Clause 5.9, haptic keyframe.
struct HmpgKeyframe {
  std::int32_t position = 0;  ///< ticks from the beginning of the unit, or of a library's effect
  std::uint8_t amplitude = 0; ///< see amplitude_of_code()

  bool operator==(const HmpgKeyframe &) const = default;
};

/// Clause 5.8, haptic effect: one that others name by its id, a curve.
struct HmpgLibraryEffect {
  std::uint8_t perception = 0;
  std::uint16_t id = 0;
  std::vector<HmpgKeyframe> keyframes;

  bool operator==(const HmpgLibraryEffect &) const = default;
};

/// The order of a library.
inline std::pair<std::uint8_t, std::uint16_t> id_in_library(const HmpgLibraryEffect &effect) {
  return {effect.perception, effect.id};
}

/// Clause 5.2, haptic experience: the content of an initialization unit.
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
  std::vector<HmpgLibraryEffect> library; ///< by id_in_library()

  bool operator==(const HmpgExperience &) const = default;
};

/// Clause 5.8, haptic effect: one of a curve band.
struct HmpgCurve {
  std::uint8_t perception = 0;
  std::uint16_t channel = 0;
  std::uint8_t band = 0;
  std::uint16_t effect = 0;              ///< id, or that of an effect in the library
  std::vector<HmpgKeyframe> keyframes;   ///< 65535 at most, from the first on in 65535 ticks
  std::optional<std::int32_t> reference; ///< ticks: where the effect of the library begins
  std::int32_t begin = 0;                ///< ticks from the unit's beginning; before it: continued

  bool operator==(const HmpgCurve &) const = default;
};

/// Returns the code 0..255 of an amplitude -1..1: (a + 1) / 2 * 255, to the nearest.
std::uint8_t code_of_amplitude(double amplitude) noexcept;
/// Returns the amplitude of a code. Zero has no code of its own: 127 and 128 are read as zero.
double amplitude_of_code(std::uint8_t code) noexcept;

// ---- writing ------------------------------------------------------------------------------------

std::vector<std::uint8_t> write_initialization_unit(const HmpgExperience &experience);
/// Returns an independent unit. The duration is 1 to 2^24-1 ticks.
std::vector<std::uint8_t> write_temporal_unit(std::uint32_t duration,
                                              std::span<const HmpgCurve> curves);
std::vector<std::uint8_t> write_silent_unit(std::uint32_t duration);

/// Replaces the time (ticks) of an initialization unit, and nothing else. Returns false if it has
/// none.
bool set_initialization_time(std::span<std::uint8_t> unit, std::uint32_t time) noexcept;

// ---- reading ------------------------------------------------------------------------------------

struct HmpgError {
  const char *what;
  std::size_t offset; ///< bytes from the beginning of the unit
};

/// Returns nothing if there are too few bytes or a field is impossible.
std::optional<UnitHeader> read_unit_header(std::span<const std::uint8_t> bytes) noexcept;

/// Returns whether a unit may begin here, by its header and that of its first packet. Other bytes
/// of a stream hardly ever look like this. Needs kUnitHeadSize bytes, unless the unit is empty.
bool looks_like_unit(std::span<const std::uint8_t> bytes) noexcept;
inline constexpr std::size_t kUnitHeadSize = kUnitHeaderSize + 3;

struct HmpgUnit {
  UnitHeader header;
  std::optional<HmpgExperience> experience; ///< of an initialization unit
  std::vector<HmpgCurve> curves;            ///< of a temporal unit
  bool has_composite = false;               ///< effects made of others were passed over
  std::optional<HmpgError> error;           ///< then the rest is empty
};

/// Reads exactly one unit. A temporal unit needs the experience that it belongs to. Bands that are
/// no curves, composite effects, and checksums are passed over.
HmpgUnit read_unit(std::span<const std::uint8_t> bytes, const HmpgExperience *experience);

} // namespace haptic
