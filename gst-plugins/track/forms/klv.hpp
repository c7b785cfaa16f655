// SPDX-License-Identifier: LGPL-2.1-or-later
// KLV (SMPTE ST 336): motion samples, motion fields and pointers as local sets with tags of one
// byte and lengths in BER (docs/formats/klv.md).
#pragma once

#include "core/track-sample.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace haptic {

/// The first bytes of every key (SMPTE ST 336: a universal label of SMPTE ST 298).
inline constexpr std::array<std::uint8_t, 4> kKlvDesignator = {0x06, 0x0E, 0x2B, 0x34};

using KlvKey = std::array<std::uint8_t, 16>;

/// Keys of local sets with one-byte tags and BER lengths, of the class that ST 336 leaves for
/// experiments (0F). They are not registered; the last byte is the kind of set.
inline constexpr KlvKey kMotionKey = {0x06, 0x0E, 0x2B, 0x34, 0x02, 0x0B, 0x01, 0x01,
                                      0x0F, 'H',  'A',  'P',  'T',  'I',  'C',  0x01};
inline constexpr KlvKey kPointerKey = {0x06, 0x0E, 0x2B, 0x34, 0x02, 0x0B, 0x01, 0x01,
                                       0x0F, 'H',  'A',  'P',  'T',  'I',  'C',  0x02};
static_assert(std::equal(kKlvDesignator.begin(), kKlvDesignator.end(), kMotionKey.begin()));
static_assert(std::equal(kMotionKey.begin(), kMotionKey.end() - 1, kPointerKey.begin()));

/// Returns one local set, ready to be sent. The sample must be valid (is_valid()).
std::vector<std::uint8_t> write_klv(const TrackSample &sample);

/// The field must be so short that the whole set is below 64 KiB: kLargestCodedField is.
std::vector<std::uint8_t> write_klv(const CodedField &field);

/// What one KLV triplet turned out to be.
enum class KlvKind {
  motion,        ///< a motion sample
  field,         ///< a coded motion field or relief
  foreign,       ///< a key of other origin, which is no error
  other_version, ///< a set of this project, of an unknown version
  other_sample,  ///< the same, of an unknown kind of sample
  damaged        ///< see `error` and `offset`
};

struct KlvItem {
  KlvKind kind = KlvKind::damaged;
  TrackSample sample;                  ///< of KlvKind::motion; its times also of KlvKind::field
  std::span<const std::uint8_t> field; ///< of KlvKind::field: what the decoder of its kind takes
  FieldKind field_kind = FieldKind::motion;
  std::span<const std::uint8_t> things; ///< of a motion field
  const char *error = "";               ///< of KlvKind::damaged: what is wrong
  std::size_t offset = 0;               ///< where in the bytes the item begins, or the damage is
};

/// Returns the field of an item of KlvKind::field.
CodedField coded_field_of(const KlvItem &item);

/// Reads the triplets of a packet or a file one after another. Allocates nothing. After damage it
/// goes on at the next key of a motion set.
class KlvReader {
public:
  explicit KlvReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  /// Returns nothing at the end.
  std::optional<KlvItem> next() noexcept;

private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// A pointer that is sent over a network.
struct TrackPointer {
  std::uint32_t sequence = 0;
  double x = 0.5; ///< 0..1
  double y = 0.5; ///< 0..1
  double z = 0;   ///< -1..1
  bool pressed = false;
  std::string device; ///< at most kLongestDeviceName bytes are sent

  bool operator==(const TrackPointer &) const = default;
};

inline constexpr std::size_t kLongestDeviceName = 64;

std::vector<std::uint8_t> write_klv(const TrackPointer &pointer);

/// Returns the first pointer among the triplets, or nothing if there is none or it is damaged or of
/// another version.
std::optional<TrackPointer> read_klv_pointer(std::span<const std::uint8_t> bytes);

} // namespace haptic
