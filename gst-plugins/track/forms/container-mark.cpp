// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/container-mark.hpp"

#include "forms/klv.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <string>

namespace haptic {
namespace {

// ISO/IEC 13818-1, 2.4.3.2 (packet) and 2.4.3.6 (PES packet).
constexpr std::size_t kPacketSize = 188;
constexpr std::size_t kPacketHeader = 4;
constexpr std::uint8_t kSync = 0x47;
constexpr std::uint8_t kUnitStart = 0x40;  // in byte 1
constexpr std::uint8_t kAdaptation = 0x20; // in byte 3
constexpr std::array<std::uint8_t, 4> kPrivatePes = {0, 0, 1, 0xBD};
constexpr std::uint8_t kMetadataStream = 0xFC;
constexpr std::size_t kPesHeaderLengthAt = 8;

// Elements of Matroska (RFC 9559, 5.1): ID, size, value.
constexpr std::uint32_t kTrackEntry = 0xAE;
constexpr std::uint32_t kTrackType = 0x83;
constexpr std::uint32_t kName = 0x536E;
constexpr std::uint8_t kSubtitles = 0x11; // type of a track
constexpr std::array<std::uint8_t, 4> kTracksId = {0x16, 0x54, 0xAE, 0x6B};
constexpr std::array<std::uint8_t, 4> kCluster = {0x1F, 0x43, 0xB6, 0x75};
constexpr std::array<std::uint8_t, 3> kNotDefault = {0x88, 0x81, 0};
constexpr std::size_t kNameHeader = 3; // ID and size
constexpr std::size_t kLongestName = 100;
constexpr std::size_t kVoidHeader = 3; // ID and size in two bytes
constexpr std::size_t kLongestVoid = 0x3FFE;

template <typename Bytes>
bool begins_with(std::span<const std::uint8_t> bytes, const Bytes &start) {
  return bytes.size() >= start.size() && std::equal(start.begin(), start.end(), bytes.begin());
}

void mark_packet(std::span<std::uint8_t> packet) {
  if ((packet[1] & kUnitStart) == 0)
    return;
  const bool adapted = (packet[3] & kAdaptation) != 0;
  const std::size_t at = kPacketHeader + (adapted ? 1U + packet[kPacketHeader] : 0U);
  if (at + kPesHeaderLengthAt >= packet.size())
    return;
  const auto pes = packet.subspan(at);
  const std::size_t payload = kPesHeaderLengthAt + 1 + pes[kPesHeaderLengthAt];
  if (payload < pes.size() && begins_with(pes, kPrivatePes) &&
      begins_with(pes.subspan(payload), kMotionKey))
    pes[3] = kMetadataStream;
}

struct Element {
  std::uint32_t id = 0;
  std::size_t at = 0;    // where it begins
  std::size_t value = 0; // where its value begins
  std::size_t end = 0;   // behind it
};

// Reads a number of variable size (RFC 8794, 4) and moves `at` behind it. Returns nothing if it is
// cut off or too long.
std::optional<std::uint64_t> read_number(std::span<const std::uint8_t> bytes, std::size_t &at,
                                         std::size_t longest, bool keeps_marker) {
  if (at >= bytes.size() || bytes[at] == 0)
    return std::nullopt;
  const auto length = static_cast<std::size_t>(std::countl_zero(bytes[at])) + 1;
  if (length > longest || length > bytes.size() - at)
    return std::nullopt;
  std::uint64_t value = keeps_marker ? bytes[at] : bytes[at] & (0xFFU >> length);
  for (std::size_t i = 1; i < length; ++i)
    value = value << 8 | bytes[at + i];
  at += length;
  return value;
}

std::optional<Element> read_element(std::span<const std::uint8_t> bytes, std::size_t at) {
  Element element;
  element.at = at;
  const auto id = read_number(bytes, at, 4, true);
  const auto size = id ? read_number(bytes, at, 8, false) : std::nullopt;
  if (!size || *size > bytes.size() - at)
    return std::nullopt;
  element.id = static_cast<std::uint32_t>(*id);
  element.value = at;
  element.end = at + static_cast<std::size_t>(*size);
  return element;
}

// Returns the child of an element with this ID.
std::optional<Element> child_of(std::span<const std::uint8_t> bytes, const Element &parent,
                                std::uint32_t id) {
  const auto within = bytes.first(parent.end);
  auto child = read_element(within, parent.value);
  while (child && child->id != id)
    child = read_element(within, child->end);
  return child;
}

// Writes FlagDefault and another name in the place of the name.
void replace_name(std::span<std::uint8_t> name) {
  if (name.size() < kNotDefault.size() + kNameHeader)
    return;
  const std::size_t all = name.size() - kNotDefault.size() - kNameHeader;
  if (all > kLongestName + kVoidHeader + kLongestVoid)
    return;
  const std::size_t length = all < kLongestName + kVoidHeader ? all : kLongestName;
  // Nulls behind the text belong to no string (RFC 8794, 7.4).
  std::string text = length < 6 ? "touch" : "haptic";
  text.resize(length);
  auto to = std::ranges::copy(kNotDefault, name.begin()).out;
  for (const auto byte : {std::size_t{0x53}, std::size_t{0x6E}, 0x80 | length})
    *to++ = static_cast<std::uint8_t>(byte);
  to = std::ranges::copy(text, to).out;
  if (length == all)
    return;
  const std::size_t rest = all - length - kVoidHeader;
  for (const auto byte : {std::size_t{0xEC}, 0x40 | rest >> 8, rest & 0xFF})
    *to++ = static_cast<std::uint8_t>(byte);
}

void hide_first_text(std::span<std::uint8_t> tracks, std::optional<Element> entry) {
  for (; entry; entry = read_element(tracks, entry->end)) {
    const auto type = child_of(tracks, *entry, kTrackType);
    const auto name = child_of(tracks, *entry, kName);
    if (entry->id == kTrackEntry && type && type->end == type->value + 1 &&
        tracks[type->value] == kSubtitles && name)
      return replace_name(tracks.subspan(name->at, name->end - name->at));
  }
}

} // namespace

void keep_times_of_track(std::span<std::uint8_t> packets) {
  if (packets.size() % kPacketSize != 0)
    return;
  for (; !packets.empty(); packets = packets.subspan(kPacketSize))
    if (packets[0] == kSync)
      mark_packet(packets.first(kPacketSize));
}

bool hide_text_track(std::span<std::uint8_t> header) {
  const auto position = [&](const auto &id, std::size_t from) {
    // clang 14 cannot use the ranges of GCC's library.
    const auto begin = header.begin() + static_cast<std::ptrdiff_t>(from);
    return static_cast<std::size_t>(std::search(begin, header.end(), id.begin(), id.end()) -
                                    header.begin());
  };
  const std::size_t frames = position(kCluster, 0);
  for (std::size_t at = position(kTracksId, 0); at < frames; at = position(kTracksId, at + 1)) {
    const auto tracks = read_element(header, at);
    if (!tracks)
      continue;
    // A damaged entry may claim to be longer than the list of tracks.
    const auto list = header.first(tracks->end);
    const auto first = read_element(list, tracks->value);
    // The list of what is where in the file holds the same ID.
    if (!first || first->id != kTrackEntry)
      continue;
    hide_first_text(list, first);
    return true;
  }
  return frames < header.size();
}

} // namespace haptic
