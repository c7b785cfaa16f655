// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/container-mark.hpp"

#include "forms/klv.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <string>

namespace container_mark_test {

using Bytes = std::vector<std::uint8_t>;

// The first packet of a PES packet with a time stamp. The payload is at its end.
Bytes packet_with(std::span<const std::uint8_t> payload, std::uint8_t stream_id) {
  const std::size_t stuffing = 188 - 4 - 1 - 14 - payload.size();
  Bytes packet = {0x47, 0x40, 0x42, 0x30, static_cast<std::uint8_t>(stuffing)};
  packet.resize(5 + stuffing, 0xFF);
  const Bytes header = {0, 0, 1, stream_id, 0, 0, 0x81, 0x80, 5, 0x21, 0, 1, 0, 1};
  packet.insert(packet.end(), header.begin(), header.end());
  packet.insert(packet.end(), payload.begin(), payload.end());
  return packet;
}

constexpr std::uint8_t kPrivate = 0xBD;
constexpr std::uint8_t kMetadata = 0xFC;

TEST(ContainerMark, TheTrackInATransportStreamGetsTheIdOfMetadata) {
  Bytes packets = packet_with(haptic::kMotionKey, kPrivate);
  const Bytes second = packet_with(haptic::kMotionKey, kPrivate);
  packets.insert(packets.end(), second.begin(), second.end());
  haptic::keep_times_of_track(packets);
  const Bytes marked = packet_with(haptic::kMotionKey, kMetadata);
  EXPECT_TRUE(std::ranges::equal(std::span(packets).first(188), marked));
  EXPECT_TRUE(std::ranges::equal(std::span(packets).last(188), marked));
}

TEST(ContainerMark, OtherStreamsStay) {
  auto other_key = haptic::kMotionKey;
  other_key[9] = 'X';
  Bytes continued = packet_with(haptic::kMotionKey, kPrivate);
  continued[1] = 0;
  for (const Bytes &packet :
       {packet_with(other_key, kPrivate), packet_with(haptic::kMotionKey, 0xE0), continued}) {
    Bytes marked = packet;
    haptic::keep_times_of_track(marked);
    EXPECT_EQ(marked, packet);
  }
}

Bytes bytes_of(const std::string &text) {
  return {text.begin(), text.end()};
}

// An element of Matroska: its size in one byte, or in eight as matroskamux writes what it fills.
std::string element(const std::string &id, const std::string &value, bool is_long = false) {
  std::string size(1, static_cast<char>(0x80 | value.size()));
  if (is_long)
    size = std::string("\x01\0\0\0\0\0", 6) + static_cast<char>(value.size() >> 8) +
           static_cast<char>(value.size() & 0xFF);
  else if (value.size() > 126)
    size = {static_cast<char>(0x40 | value.size() >> 8), static_cast<char>(value.size() & 0xFF)};
  return id + size + value;
}

std::string track_of_type(char type, const std::string &rest) {
  return element("\xAE", element("\xD7", "\x01") + element("\x83", std::string(1, type)) + rest,
                 true);
}

Bytes header_with(const std::string &tracks) {
  const std::string seek = element("\x53\xAB", "\x16\x54\xAE\x6B") + element("\x53\xAC", "\x01");
  return bytes_of("header" + seek + element("\x16\x54\xAE\x6B", tracks, true) + "\x1f\x43\xb6\x75");
}

const std::string kNotDefault("\x88\x81\0", 3);
const std::string kFilm = track_of_type(1, element("Sn", "Subtitle"));

TEST(ContainerMark, TheTextTrackIsNoDefaultSubtitleAndHasAName) {
  for (const auto &[before, behind] :
       {std::pair(std::string("Subtitle\0", 9), std::string("haptic")),
        std::pair(std::string("Subtitle"), std::string("touch")),
        std::pair(std::string("My film, act 2"), std::string("haptic\0\0\0\0\0", 11)),
        std::pair(std::string("abc"), std::string())}) {
    Bytes header = header_with(kFilm + track_of_type(0x11, element("Sn", before)));
    EXPECT_TRUE(haptic::hide_text_track(header));
    EXPECT_EQ(header, header_with(kFilm + track_of_type(0x11, kNotDefault + element("Sn", behind))))
        << before;
  }
}

TEST(ContainerMark, ALongTitleLeavesRoom) {
  Bytes header = header_with(track_of_type(0x11, element("Sn", std::string(300, 't'))));
  const std::size_t size = header.size();
  EXPECT_TRUE(haptic::hide_text_track(header));
  EXPECT_EQ(header.size(), size);
  const std::string text(header.begin(), header.end());
  EXPECT_NE(text.find(kNotDefault + "Sn\xE4haptic"), std::string::npos);
  EXPECT_NE(text.find(std::string("\xEC\x40\xC3", 3)), std::string::npos) << "195 bytes of nothing";
}

TEST(ContainerMark, ATitleTooLongForTheRoomBehindTheNameStays) {
  const std::string size("\x01\0\0\0\0\0\x50\0", 8);
  const std::string name = "Sn" + size + std::string(0x5000, 't');
  const std::string type = element("\x83", "\x11");
  const std::string entry = "\xAE" + std::string("\x01\0\0\0\0\0\x50\x0D", 8) + type + name;
  const Bytes film =
      bytes_of("\x16\x54\xAE\x6B" + std::string("\x01\0\0\0\0\0\x50\x16", 8) + entry);
  Bytes header = film;
  EXPECT_TRUE(haptic::hide_text_track(header));
  EXPECT_EQ(header, film);
}

TEST(ContainerMark, AFilmWithoutTextStays) {
  const Bytes film = header_with(kFilm + track_of_type(2, element("Sn", "Audio")));
  Bytes header = film;
  EXPECT_TRUE(haptic::hide_text_track(header));
  EXPECT_EQ(header, film);
}

TEST(ContainerMark, FramesStay) {
  Bytes header = bytes_of("no tracks yet");
  EXPECT_FALSE(haptic::hide_text_track(header)) << "the tracks follow";
  Bytes frames = bytes_of("\x1f\x43\xb6\x75");
  const Bytes tracks = header_with(track_of_type(0x11, element("Sn", "Subtitle")));
  frames.insert(frames.end(), tracks.begin(), tracks.end());
  header = frames;
  EXPECT_TRUE(haptic::hide_text_track(header));
  EXPECT_EQ(header, frames);
}

TEST(ContainerMark, AnyBytesAreSafe) {
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    Bytes packet = packet_with(haptic::kMotionKey, kPrivate);
    for (int j = 0; j < 4; ++j)
      packet[random() % (j % 2 == 0 ? 24 : packet.size())] = static_cast<std::uint8_t>(random());
    packet.resize(i % 4 == 0 ? random() % packet.size() : packet.size());
    haptic::keep_times_of_track(packet);
    Bytes header = header_with(track_of_type(0x11, element("Sn", "Subtitle")));
    for (int j = 0; j < 3; ++j)
      header[random() % header.size()] = static_cast<std::uint8_t>(random());
    haptic::hide_text_track(header);
  }
}

} // namespace container_mark_test
