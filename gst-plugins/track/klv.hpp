// SPDX-License-Identifier: LGPL-2.1-or-later
// KLV (SMPTE ST 336): motion samples, motion fields and pointers as local sets
// (docs/formats/klv.md).
#pragma once

#include "track-sample.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace haptic {

/// One local set, ready to be sent. The sample must be one that unpack_motion_sample() would take.
std::vector<std::uint8_t> write_klv(const TrackSample &sample);

/// The bytes must be fewer than 64 KiB by the length of the rest.
std::vector<std::uint8_t> write_klv(const CodedField &field);

/// What one KLV triplet turned out to be.
enum class KlvKind {
  motion,        ///< a motion sample
  field,         ///< a coded motion field
  foreign,       ///< a key of other origin: not ours, and not an error
  other_version, ///< ours, of a version this reader does not know
  other_sample,  ///< ours, of a kind of sample this reader does not know
  damaged        ///< see `error` and `offset`
};

struct KlvItem {
  KlvKind kind = KlvKind::damaged;
  TrackSample sample;                  ///< of KlvKind::motion; its times also of KlvKind::field
  std::span<const std::uint8_t> field; ///< of KlvKind::field: what FieldDecoder takes
  const char *error = "";              ///< of KlvKind::damaged: what is wrong
  std::size_t offset = 0;              ///< where in the bytes the item begins, or the damage is
};

/// Walks the triplets of a packet or a file. Allocates nothing. After damage it goes on at the next
/// key of ours.
class KlvReader {
public:
  explicit KlvReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  /// Nothing at the end.
  std::optional<KlvItem> next() noexcept;

private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// A pointer on its way over a network.
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

/// The first pointer among the triplets; nothing if there is none, or it is damaged or of another
/// version.
std::optional<TrackPointer> read_klv_pointer(std::span<const std::uint8_t> bytes);

} // namespace haptic
