// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usb/usb-protocol.hpp"

#include "spidar/error.hpp"
#include "spidar/usb.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace spidar_protocol_test {

using namespace spidar;

const DacWords kWords = {0, 45, 4095, -1, 0x1234, -4095, 32767, -32768};
const std::vector<std::uint8_t> kWordBytes = {0x00, 0x00, 0x2d, 0x00, 0xff, 0x0f, 0xff, 0xff,
                                              0x34, 0x12, 0x01, 0xf0, 0xff, 0x7f, 0x00, 0x80};

/// `begin` followed by zeros up to `size`.
std::vector<std::uint8_t> padded(std::vector<std::uint8_t> begin, std::size_t size) {
  begin.resize(size);
  return begin;
}

template <class Packet>
std::vector<std::uint8_t> bytes(const Packet &packet) {
  return {packet.begin(), packet.end()};
}

/// Follows a counter of `bits` through `path` and returns the last extended count.
std::int32_t follow(const std::vector<std::int64_t> &path, int bits) {
  std::int32_t count = 0;
  for (const std::int64_t place : path)
    count = extended(count, static_cast<std::uint32_t>(place & ((1LL << bits) - 1)), bits);
  return count;
}

TEST(SimpleProtocol, CommandsAreThoseOfTheController) {
  EXPECT_EQ(bytes(simple::count_direction()), padded({0xa2, 0x1a, 0xff}, 32));
  EXPECT_EQ(bytes(simple::clear_counters()), padded({0xa2, 0x19, 0xff}, 32));
  EXPECT_EQ(bytes(simple::latch_counters()), padded({0x51}, 32));
}

TEST(SimpleProtocol, WordsAreLittleEndianAfterTheCommand) {
  std::vector<std::uint8_t> expected = {0x52};
  expected.insert(expected.end(), kWordBytes.begin(), kWordBytes.end());
  EXPECT_EQ(bytes(simple::set_dac(kWords)), padded(expected, 32));
}

TEST(SimpleProtocol, ReplyHas24BitCountersTheRotarySwitchAndTheInputs) {
  const std::vector<std::uint8_t> reply =
      padded({0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0xff, 0xff, 0xff, 0x5a, 0x18,
              0x00, 0x7a, 0xe8, 0xff, 0xff, 0xff, 0x7f, 0x00, 0x00, 0x80, 0x56,
              0x34, 0x12, 0xa5, 0xde, 0xad, 0xbe, 0xef, 0xde, 0xad, 0xbe},
             32);
  const auto parsed = simple::parse(reply);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->rotary_switch, 10);
  EXPECT_EQ(parsed->inputs, 0x5);
  Counts counts{};
  for (std::size_t i = 0; i < kStrings; ++i)
    counts[i] = extended(0, parsed->counters[i], simple::kCounterBits);
  EXPECT_EQ(counts, (Counts{0, 1, -1, 6234, -6022, 8388607, -8388608, 0x123456}));
}

TEST(Sh4Protocol, UpdateCarriesTheWordsAfterTwoOpcodes) {
  std::vector<std::uint8_t> expected = {0x01, 0x0e};
  expected.insert(expected.end(), kWordBytes.begin(), kWordBytes.end());
  EXPECT_EQ(bytes(sh4::update(kWords)), padded(expected, 512));
}

TEST(Sh4Protocol, ReplyHas16BitCountersOfOppositeSignTheRotarySwitchAndTheInputs) {
  std::vector<std::uint8_t> reply(512, 0xcc); // what is not interpreted may be anything
  const std::vector<std::uint8_t> counters = {0x00, 0x00, 0x01, 0x00, 0xff, 0xff, 0x5a, 0x18,
                                              0x7a, 0xe8, 0xff, 0x7f, 0x01, 0x80, 0x34, 0x12};
  std::copy(counters.begin(), counters.end(), reply.begin() + 16);
  reply[48] = 0x3e;
  reply[49] = 0x81;
  const auto parsed = sh4::parse(reply);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->rotary_switch, 3);
  EXPECT_EQ(parsed->inputs, 0x810e);
  Counts counts{};
  for (std::size_t i = 0; i < kStrings; ++i)
    counts[i] = extended(0, parsed->counters[i], sh4::kCounterBits);
  EXPECT_EQ(counts, (Counts{0, -1, 1, -6234, 6022, -32767, 32767, -0x1234}));
}

TEST(UsbProtocol, RepliesOfAnyOtherLengthAreRefused) {
  for (std::size_t size = 0; size < 600; ++size) {
    const std::vector<std::uint8_t> reply(size);
    EXPECT_EQ(simple::parse(reply).has_value(), size == 32) << size;
    EXPECT_EQ(sh4::parse(reply).has_value(), size == 512) << size;
  }
}

TEST(CounterExtension, FollowsACounterAcrossItsWrapBothWays) {
  EXPECT_EQ(follow({0, 30000, 60000, 90000, 120000}, 16), 120000);
  EXPECT_EQ(follow({0, -30000, -60000, -90000}, 16), -90000);
  EXPECT_EQ(follow({0, 8000000, 16000000, 24000000}, 24), 24000000);
  EXPECT_EQ(follow({0, -8000000, -16000000, -24000000, -16000000}, 24), -16000000);
}

TEST(CounterExtension, HoldsUpToHalfTheRangePerExchange) {
  EXPECT_EQ(follow({100, 100 + 32767}, 16), 32867);
  EXPECT_EQ(follow({100, 100 - 32768}, 16), -32668);
  EXPECT_EQ(follow({100, 100 + 32768}, 16), -32668); // one more is taken for the other way
}

TEST(CounterExtension, WrapsAtTheEndsOfItsTypeInsteadOfOverflowing) {
  const std::int32_t highest = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(extended(highest, 0x0000, 16), std::numeric_limits<std::int32_t>::min());
}

TEST(OpenUsb, RefusesWhatIsNoSwitchPosition) {
  for (const char *id : {"16", "-1", "A", "1x", " 1", "999999999999"}) {
    try {
      open_usb(id);
      ADD_FAILURE() << id;
    } catch (const Error &error) {
      EXPECT_EQ(error.cause(), Cause::argument) << id;
      EXPECT_NE(std::string(error.what()).find("0 to 15"), std::string::npos) << id;
    }
  }
}

TEST(OpenUsb, WithoutADeviceTheErrorSaysWhatToDo) {
  if (usb_present())
    GTEST_SKIP() << "a SPIDAR-G is plugged in";
  for (const char *id : {"", "10"}) {
    try {
      open_usb(id);
      ADD_FAILURE();
    } catch (const Error &error) {
      if (error.cause() == Cause::io) // this machine has no USB at all
        continue;
      EXPECT_EQ(error.cause(), Cause::not_found);
      EXPECT_NE(std::string(error.what()).find("Plug it in"), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find("switch at 10") != std::string::npos,
                std::string(id) == "10");
    }
  }
}

} // namespace spidar_protocol_test
