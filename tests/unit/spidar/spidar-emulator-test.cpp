// SPDX-License-Identifier: LGPL-2.1-or-later
#include "commands.hpp"
#include "session.hpp"
#include "spidar/error.hpp"
#include "temporary-folder.hpp"
#include "usb/usb-protocol.hpp"

#include <cerrno>
#include <cstdlib>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <random>

namespace spidar_emulator_test {

using namespace emulator;
using namespace std::chrono_literals;
using usbip::Bytes;

constexpr Time kStart = Time(1h);

Units make_units(const std::vector<Model> &models,
                 const std::optional<spidar::GripButton> &button = std::nullopt,
                 const std::string &hand = "hold:0,0,0") {
  auto geometry = spidar::load_geometry(spidar::kDefaultGeometry);
  geometry.button = button;
  Units units;
  for (const Model model : models) {
    const int number = static_cast<int>(units.size()) + 1;
    Firmware firmware(model, number + 8, Plant(geometry, spidar::parse_hand_script(hand)),
                      static_cast<unsigned>(number));
    units.push_back(std::make_unique<Unit>(number, std::move(firmware)));
    units.back()->plug(kStart);
  }
  return units;
}

/// Bytes written as in the kernel's description: words of hexadecimal digits.
Bytes golden(const std::string &text) {
  Bytes bytes;
  std::string digits;
  for (const char c : text) {
    if (std::isxdigit(static_cast<unsigned char>(c)) != 0)
      digits += c;
    if (digits.size() == 2) {
      bytes.push_back(static_cast<std::uint8_t>(std::strtol(digits.c_str(), nullptr, 16)));
      digits.clear();
    }
  }
  return bytes;
}

Bytes operator+(Bytes left, const Bytes &right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

Bytes zeros(std::size_t count) {
  return Bytes(count);
}

Bytes text(const std::string &letters, std::size_t size) {
  Bytes bytes(letters.begin(), letters.end());
  bytes.resize(size);
  return bytes;
}

Bytes word(std::uint32_t value) {
  return {static_cast<std::uint8_t>(value >> 24), static_cast<std::uint8_t>(value >> 16),
          static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
}

std::uint32_t word_at(const Bytes &bytes, std::size_t offset) {
  return static_cast<std::uint32_t>(bytes.at(offset) << 24 | bytes.at(offset + 1) << 16 |
                                    bytes.at(offset + 2) << 8 | bytes.at(offset + 3));
}

Bytes submit(std::uint32_t sequence, bool in, std::uint32_t endpoint, std::uint32_t length,
             const Bytes &setup = zeros(8)) {
  return word(1) + word(sequence) + word(0x00010001) + word(in ? 1 : 0) + word(endpoint) + word(0) +
         word(length) + word(0) + word(0xffffffff) + word(0) + setup;
}

Bytes out(std::uint32_t sequence, const Bytes &data, std::uint32_t endpoint = 2) {
  return submit(sequence, false, endpoint, static_cast<std::uint32_t>(data.size())) + data;
}

Bytes in(std::uint32_t sequence, std::uint32_t length = 512) {
  return submit(sequence, true, 6, length);
}

Bytes unlink(std::uint32_t sequence, std::uint32_t victim) {
  return word(2) + word(sequence) + word(0x00010001) + zeros(8) + word(victim) + zeros(24);
}

Bytes import_request(const std::string &bus_id) {
  return golden("0111 8003 00000000") + text(bus_id, 32);
}

const Bytes kSetConfiguration = golden("00 09 0100 0000 0000");

template <class Packet>
Bytes bytes(const Packet &packet) {
  return {packet.begin(), packet.end()};
}

/// A host that has attached the first unit and configured it.
class Host {
public:
  explicit Host(Units &units) : session_(units) {
    EXPECT_EQ(say(import_request("1-1")).size(), 8 + 0x138U);
    EXPECT_EQ(status(say(submit(1, false, 0, 0, kSetConfiguration))), 0);
  }

  Bytes say(const Bytes &message) {
    EXPECT_TRUE(session_.receive(message, now));
    return take();
  }

  Bytes later(Clock::duration time) {
    now += time;
    session_.collect(now);
    return take();
  }

  static std::int32_t status(const Bytes &reply) {
    return static_cast<std::int32_t>(word_at(reply, 0x14));
  }

  /// The data of the only reply.
  static Bytes data(const Bytes &reply) {
    EXPECT_EQ(word_at(reply, 0), 3U);
    EXPECT_EQ(reply.size(), 48 + word_at(reply, 0x18));
    return {reply.begin() + 48, reply.end()};
  }

  spidar::Reply ask_simple() {
    say(out(++sequence_, bytes(spidar::simple::latch_counters())));
    return spidar::simple::parse(data(say(in(++sequence_)))).value();
  }

  spidar::Reply ask_sh4(const spidar::DacWords &words = {}) {
    say(out(++sequence_, bytes(spidar::sh4::update(words))));
    return spidar::sh4::parse(data(say(in(++sequence_)))).value();
  }

  Session &session() { return session_; }
  Time now = kStart;

private:
  Bytes take() { return std::exchange(session_.output(), {}); }

  Session session_;
  std::uint32_t sequence_ = 1000;
};

void command(Units &units, const std::string &line, Time now = kStart) {
  std::vector<std::vector<Completion>> done;
  obey(line, units, now, done);
}

TEST(UsbIp, ListsTheUnitsThatArePluggedIn) {
  Units units = make_units({Model::simple, Model::sh4, Model::simple});
  command(units, "unplug @3");
  Session session(units);
  EXPECT_FALSE(session.receive(golden("0111 8005 00000000"), kStart)); // nothing more to say
  const auto device = [](const std::string &id, const Bytes &numbers) {
    return text("/sys/devices/spidar-emulator/usb1/" + id, 256) + text(id, 32) + numbers;
  };
  EXPECT_EQ(session.output(),
            golden("0111 0005 00000000 00000002") +
                device("1-1", golden("00000001 00000001 00000003 0cec 0203 0100 ff 00 00 01 01 01 "
                                     "ff 00 00 00")) +
                device("1-2", golden("00000001 00000002 00000003 0cec 0205 0100 ff 00 00 01 01 01 "
                                     "ff 00 00 00")));
}

TEST(UsbIp, GivesAUnitToOneHost) {
  Units units = make_units({Model::simple});
  {
    Session first(units);
    EXPECT_TRUE(first.receive(import_request("1-1"), kStart));
    EXPECT_EQ(first.output(), golden("0111 0003 00000000") +
                                  text("/sys/devices/spidar-emulator/usb1/1-1", 256) +
                                  text("1-1", 32) +
                                  golden("00000001 00000001 00000003 0cec 0203 0100 ff 00 00 01 "
                                         "01 01"));
    Session second(units);
    EXPECT_FALSE(second.receive(import_request("1-1"), kStart));
    EXPECT_EQ(second.output(), golden("0111 0003 00000002"));
  }
  Session third(units); // the first one is gone
  EXPECT_TRUE(third.receive(import_request("1-1"), kStart));
}

TEST(UsbIp, HasNoUnitThatIsNotThere) {
  Units units = make_units({Model::simple});
  command(units, "unplug");
  const std::vector<std::string> ids = {"1-1", "1-2", "", "../1-1", std::string(40, '1')};
  for (const std::string &id : ids) {
    Session session(units);
    EXPECT_FALSE(session.receive(import_request(id), kStart));
    EXPECT_EQ(session.output(), golden("0111 0003 00000004")) << id;
  }
}

TEST(UsbIp, RepliesAreThoseOfTheKernelsDescription) {
  Units units = make_units({Model::simple});
  Host host(units);
  EXPECT_EQ(host.say(out(0xd06, bytes(spidar::simple::set_dac({})))),
            golden("00000003 00000d06 00000000 00000000 00000000 00000000 00000020 00000000 "
                   "ffffffff 00000000 00000000 00000000"));
  EXPECT_EQ(host.say(in(0xd07)), Bytes()); // waits for a reply of the unit
  EXPECT_EQ(host.say(unlink(0xd08, 0xd07)),
            golden("00000004 00000d08 00000000 00000000 00000000 ffffff98") + zeros(24));
  EXPECT_EQ(host.say(unlink(0xd09, 0xd06)), // has been answered before
            golden("00000004 00000d09 00000000 00000000 00000000 00000000") + zeros(24));
}

TEST(UsbIp, MessagesMayComeInPieces) {
  Units units = make_units({Model::simple});
  Host host(units);
  const Bytes message = out(7, bytes(spidar::simple::latch_counters())) + in(8);
  Bytes replies;
  for (const std::uint8_t byte : message)
    replies = replies + host.say({byte});
  EXPECT_EQ(replies.size(), 48 + 48 + 32U);
}

TEST(UsbIp, NonsenseEndsTheConnection) {
  const Bytes good = submit(5, true, 6, 512);
  const auto with = [&](std::size_t offset, std::uint32_t value) {
    Bytes bad = good;
    const Bytes bytes = word(value);
    std::copy(bytes.begin(), bytes.end(), bad.begin() + static_cast<std::ptrdiff_t>(offset));
    return bad;
  };
  for (const Bytes &bad :
       {with(0, 0), with(0, 3), with(0, 0xffffffff),                         // no command
        with(0xc, 2),                                                        // direction
        with(0x10, 16),                                                      // endpoint
        with(0x18, 0xffffffff), with(0x18, (1 << 20) + 1), with(0x20, 1)}) { // isochronous
    Units units = make_units({Model::simple});
    Host host(units);
    EXPECT_FALSE(host.session().receive(bad, kStart));
  }
  for (const char *bad : {"0110 8005 00000000", "0111 8004 00000000", "4745 5420 2f20 4854"}) {
    Units units = make_units({Model::simple});
    Session session(units);
    EXPECT_FALSE(session.receive(golden(bad), kStart));
    EXPECT_TRUE(session.output().empty());
  }
}

TEST(UsbDevice, IsEnumeratedAsAHighSpeedDeviceWithItsEndpoints) {
  Units units = make_units({Model::sh4});
  Host host(units);
  const auto get = [&](const std::string &setup) {
    return Host::data(host.say(submit(9, true, 0, 255, golden(setup))));
  };
  EXPECT_EQ(get("80 06 0001 0000 1200"),
            golden("12 01 0002 ff 00 00 40 ec0c 0502 0001 01 02 00 01"));
  EXPECT_EQ(get("80 06 0002 0000 0900"), golden("09 02 2700 01 01 00 80 32"));
  EXPECT_EQ(get("80 06 0002 0000 ff00"),
            golden("09 02 2700 01 01 00 80 32  09 04 00 00 03 ff 00 00 00"
                   "07 05 01 02 0002 00  07 05 02 02 0002 00  07 05 86 02 0002 00"));
  EXPECT_EQ(get("80 06 0003 0000 ff00"), golden("04 03 09 04"));
  EXPECT_EQ(get("80 08 0000 0000 0100"), golden("01"));
  const Bytes unknown = host.say(submit(9, true, 0, 255, golden("80 06 0022 0000 ff00")));
  EXPECT_EQ(Host::status(unknown), -EPIPE);
}

TEST(UsbDevice, AnEndpointInFrontOfTheTwoSwallowsWhatItGets) {
  Units units = make_units({Model::simple});
  Host host(units);
  EXPECT_EQ(Host::status(host.say(out(5, bytes(spidar::simple::latch_counters()), 1))), 0);
  EXPECT_TRUE(host.say(in(6)).empty());
  EXPECT_EQ(Host::status(host.say(out(7, {1}, 3))), -ENOENT);
}

TEST(UsbDevice, ATransferEndsWhenItIsFullOrWithAShortPacket) {
  Units units = make_units({Model::sh4});
  Host host(units);
  const Bytes update = bytes(spidar::sh4::update({}));
  host.say(out(2, update));
  EXPECT_TRUE(host.say(in(3, 1024)).empty()); // one full packet is not enough
  EXPECT_EQ(host.say(out(4, update)).size(), 48 + 48 + 1024U);
  host.say(out(5, update));
  const Bytes babble = host.say(in(6, 100));
  EXPECT_EQ(Host::status(babble), -EOVERFLOW);
  EXPECT_EQ(babble.size(), 48 + 100U);
}

TEST(UsbDevice, AStalledEndpointIsFreedByTheHost) {
  Units units = make_units({Model::simple});
  Host host(units);
  host.say(out(2, bytes(spidar::simple::latch_counters())));
  command(units, "stall in");
  EXPECT_EQ(Host::status(host.say(in(3))), -EPIPE);
  const Bytes clear = golden("02 01 0000 8600 0000");
  EXPECT_EQ(Host::status(host.say(submit(4, false, 0, 0, clear))), 0);
  EXPECT_EQ(Host::data(host.say(in(5))).size(), 32U); // what was to be said is still said
  command(units, "stall out");
  EXPECT_EQ(Host::status(host.say(out(6, bytes(spidar::simple::latch_counters())))), -EPIPE);
}

TEST(SimpleFirmware, CountsFromZeroAfterTheHostHasClearedIt) {
  Units units = make_units({Model::simple});
  Host host(units);
  host.say(out(2, bytes(spidar::simple::count_direction())));
  host.say(out(3, bytes(spidar::simple::clear_counters())));
  const spidar::Reply reply = host.ask_simple();
  EXPECT_EQ(reply.rotary_switch, 9);
  for (const std::uint32_t counter : reply.counters)
    EXPECT_EQ(counter, 0U);
}

TEST(SimpleFirmware, CountsTheLengthsOfTheStringsTheWayTheHostWants) {
  for (const bool direction_set : {true, false}) {
    Units units = make_units({Model::simple});
    const auto geometry = spidar::load_geometry(spidar::kDefaultGeometry);
    Host host(units);
    if (direction_set)
      host.say(out(2, bytes(spidar::simple::count_direction())));
    host.say(out(3, bytes(spidar::simple::clear_counters())));
    // The strings on the left pull with 5 N against the hand.
    spidar::DacWords words{};
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      words[i] = geometry.motors[i].x() < -0.01 ? 758 : 0;
    host.say(out(4, bytes(spidar::simple::set_dac(words))));
    for (int i = 0; i < 100; ++i) {
      host.later(10ms);
      host.ask_simple();
    }
    const spidar::Reply reply = host.ask_simple();
    for (std::size_t i = 0; i < spidar::kStrings; ++i) {
      const std::int32_t count = spidar::extended(0, reply.counters[i], 24);
      const double longer = (direction_set ? 1 : -1) * count * geometry.metres_per_count[i];
      if (geometry.motors[i].x() < -0.01) {
        EXPECT_LT(longer, -1e-3) << i; // pulled in
      } else if (geometry.motors[i].x() > 0.01) {
        EXPECT_GT(longer, 1e-3) << i;
      }
    }
  }
}

TEST(SimpleFirmware, ExpectsItsPacketSizeAndIgnoresWhatItDoesNotKnow) {
  Units units = make_units({Model::simple});
  Host host(units);
  for (Bytes packet : {zeros(32), Bytes{0x51}, Bytes(31, 0x51), Bytes(33, 0x51), Bytes(512, 0x51)})
    EXPECT_EQ(Host::status(host.say(out(2, packet))), 0);
  EXPECT_TRUE(host.say(in(3)).empty());
}

TEST(Sh4Firmware, CountsTheOtherWayRoundFromAnywhere) {
  Units units = make_units({Model::sh4});
  Host host(units);
  const spidar::Reply reply = host.ask_sh4();
  EXPECT_EQ(reply.rotary_switch, 9);
  int not_zero = 0;
  for (const std::uint32_t counter : reply.counters)
    not_zero += counter != 0 ? 1 : 0;
  EXPECT_GE(not_zero, 6);
}

TEST(Sh4Firmware, EchoesTheWords) {
  Units units = make_units({Model::sh4});
  Host host(units);
  const spidar::DacWords words = {0, 45, 4095, -1, 0x1234, -4095, 32767, -32768};
  host.say(out(2, bytes(spidar::sh4::update(words))));
  const Bytes reply = Host::data(host.say(in(3)));
  EXPECT_EQ(Bytes(reply.begin(), reply.begin() + 16),
            golden("0000 2d00 ff0f ffff 3412 01f0 ff7f 0080"));
}

TEST(Firmware, RepliesThatNobodyFetchedStay) {
  Units units = make_units({Model::simple});
  {
    Host host(units);
    host.say(out(2, bytes(spidar::simple::latch_counters())));
    host.say(out(3, bytes(spidar::simple::latch_counters())));
  }
  Host host(units);
  EXPECT_EQ(Host::data(host.say(in(2))).size(), 32U);
  EXPECT_EQ(Host::data(host.say(in(3))).size(), 32U);
  EXPECT_TRUE(host.say(in(4)).empty());
}

TEST(Firmware, WhatIsNotSpecifiedIsRandom) {
  Units units = make_units({Model::simple});
  Host host(units);
  host.say(out(2, bytes(spidar::simple::latch_counters())));
  host.say(out(3, bytes(spidar::simple::latch_counters())));
  const Bytes first = Host::data(host.say(in(4)));
  const Bytes second = Host::data(host.say(in(5)));
  EXPECT_NE(Bytes(first.begin() + 25, first.end()), Bytes(second.begin() + 25, second.end()));
}

TEST(Faults, AShortReply) {
  Units units = make_units({Model::simple});
  Host host(units);
  command(units, "short 2");
  for (const std::size_t size : {7U, 7U, 32U}) {
    host.say(out(2, bytes(spidar::simple::latch_counters())));
    EXPECT_EQ(Host::data(host.say(in(3))).size(), size);
  }
}

TEST(Faults, ALateReply) {
  Units units = make_units({Model::simple});
  Host host(units);
  command(units, "late 30");
  host.say(out(2, bytes(spidar::simple::latch_counters())));
  EXPECT_TRUE(host.say(in(3)).empty());
  EXPECT_TRUE(host.later(29ms).empty());
  ASSERT_EQ(host.session().due(), host.now + 1ms);
  EXPECT_EQ(Host::data(host.later(1ms)).size(), 32U);
}

TEST(Faults, AHeldReplyComesWithTheNextOne) {
  Units units = make_units({Model::simple});
  Host host(units);
  units[0]->firmware().faults().held_replies = 1;
  host.say(out(2, bytes(spidar::simple::latch_counters())));
  EXPECT_TRUE(host.say(in(3)).empty());
  EXPECT_TRUE(host.later(1h).empty());
  EXPECT_EQ(host.say(out(4, bytes(spidar::simple::latch_counters()))).size(), 48 + 48 + 32U);
  EXPECT_EQ(Host::data(host.say(in(5))).size(), 32U);
}

TEST(Faults, ASilentControllerTakesPacketsAndNeverReplies) {
  Units units = make_units({Model::simple});
  Host host(units);
  units[0]->firmware().faults().silent = true;
  EXPECT_EQ(Host::status(host.say(out(2, bytes(spidar::simple::latch_counters())))), 0);
  EXPECT_TRUE(host.say(in(3)).empty());
  EXPECT_TRUE(host.later(1h).empty());
}

TEST(Faults, ARefusedTransferWaitsUntilItIsTakenOrDropped) {
  Units units = make_units({Model::simple});
  Host host(units);
  Faults &faults = units[0]->firmware().faults();
  faults.refuse_out = true;
  EXPECT_TRUE(host.say(out(2, bytes(spidar::simple::latch_counters()))).empty());
  EXPECT_TRUE(host.say(out(3, bytes(spidar::simple::latch_counters()))).empty());
  EXPECT_EQ(word_at(host.say(unlink(4, 2)), 0x14), static_cast<std::uint32_t>(-ECONNRESET));
  EXPECT_TRUE(host.say(in(5)).empty());
  faults.refuse_out = false;
  EXPECT_EQ(host.later(0ms).size(), 48 + 48 + 32U); // of transfers 3 and 5
}

TEST(Faults, AStalledReplyHaltsTheEndpointUntilTheHostClearsIt) {
  Units units = make_units({Model::simple});
  Host host(units);
  units[0]->firmware().faults().stalled_replies = 1;
  host.say(out(2, bytes(spidar::simple::latch_counters())));
  EXPECT_EQ(Host::status(host.say(in(3))), -EPIPE);
  EXPECT_EQ(Host::status(host.say(in(4))), -EPIPE);
  host.say(submit(5, false, 0, 0, golden("02 01 0000 8600 0000")));
  EXPECT_TRUE(host.say(in(6)).empty()); // its reply is lost
}

TEST(Faults, AFrozenCounterAndAJump) {
  Units units = make_units({Model::simple});
  Host host(units);
  host.say(out(2, bytes(spidar::simple::count_direction())));
  host.say(out(3, bytes(spidar::simple::clear_counters())));
  command(units, "freeze 3");
  command(units, "jump 3 500");
  command(units, "jump 4 -500");
  spidar::Reply reply = host.ask_simple();
  EXPECT_EQ(reply.counters[3], 0U);
  EXPECT_EQ(spidar::extended(0, reply.counters[4], 24), -500);
  command(units, "thaw");
  reply = host.ask_simple();
  EXPECT_EQ(spidar::extended(0, reply.counters[3], 24), 500);
}

TEST(Faults, CountersAtTheEndsOfTheirRange) {
  Units simple = make_units({Model::simple});
  Host simple_host(simple);
  command(simple, "wrap");
  EXPECT_EQ(simple_host.ask_simple().counters[0], 0x7fffffU);
  EXPECT_EQ(simple_host.ask_simple().counters[1], 0xffffffU);
  Units sh4 = make_units({Model::sh4});
  Host sh4_host(sh4);
  command(sh4, "wrap");
  EXPECT_EQ(sh4_host.ask_sh4().counters[0], 0x8001U); // counted the other way round
  EXPECT_EQ(sh4_host.ask_sh4().counters[1], 0x0001U);
}

TEST(Faults, GarbageAfterPowerOn) {
  Units units = make_units({Model::simple});
  Host host(units);
  command(units, "garbage");
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(Host::data(host.say(in(2))).size(), 32U);
  EXPECT_TRUE(host.say(in(3)).empty());
}

TEST(Inputs, APinThatIsSetStaysThatWayAndTheOthersAreRandom) {
  Units units = make_units({Model::sh4});
  command(units, "input 1 1");
  command(units, "input 2 0");
  Host host(units);
  unsigned seen_high = 0;
  unsigned seen_low = 0;
  for (int i = 0; i < 100; ++i) {
    const unsigned inputs = host.ask_sh4().inputs;
    seen_high |= inputs;
    seen_low |= ~inputs;
    ASSERT_EQ(inputs & 0x6, 0x2U);
  }
  EXPECT_EQ(seen_high & seen_low & 0x9, 0x9U);
  command(units, "input 1 0");
  EXPECT_EQ(host.ask_sh4().inputs & 0x6, 0U);
}

TEST(Inputs, AHandThatPressesTheButtonOfTheGeometryDrivesItsPin) {
  const test::TemporaryFolder folder;
  const std::string script = folder.write("hand.csv", "0,0,0,0\n0.01,0,0,0,1\n");
  for (const bool level : {true, false}) {
    Units units = make_units({Model::simple}, spidar::GripButton{.bit = 3, .pressed = level},
                             "file:" + script);
    Host host(units);
    EXPECT_EQ(host.ask_simple().inputs >> 3, !level);
    for (int i = 0; i < 20; ++i) { // longer than 20 ms without a question the hand stands still
      host.now += 1ms;
      host.ask_simple();
    }
    EXPECT_EQ(host.ask_simple().inputs >> 3, level);
  }
}

TEST(Faults, AnotherRotarySwitchOfOneUnit) {
  Units units = make_units({Model::simple, Model::simple});
  command(units, "id 15 @1");
  EXPECT_EQ(units[0]->firmware().rotary_switch(), 15);
  EXPECT_EQ(units[1]->firmware().rotary_switch(), 10);
  Host host(units);
  EXPECT_EQ(host.ask_simple().rotary_switch, 15);
}

TEST(Faults, BadCommandsNameWhatIsKnownAndDoNothing) {
  Units units = make_units({Model::simple});
  for (const char *line : {"unplugged", "stall", "stall up", "late", "late -1", "late 1x",
                           "freeze 8", "jump 1", "jump 1 2 3", "id 16", "input 4 1", "input 1 2",
                           "input 1", "unplug @2", "unplug @x", "unplug @", "@1", "wrap 1"}) {
    try {
      command(units, line);
      ADD_FAILURE() << line;
    } catch (const spidar::Error &error) {
      EXPECT_EQ(error.cause(), spidar::Cause::argument);
      EXPECT_NE(std::string(error.what()).find("replug"), std::string::npos) << line;
    }
    EXPECT_TRUE(units[0]->plugged());
  }
  command(units, "   "); // nothing
}

// Messages that begin well and are then changed at random, in random pieces. The number of rounds
// can be raised from outside.
TEST(Fuzz, HostileBytesDoNoHarm) {
  const char *wanted = std::getenv("SPIDAR_FUZZ_ROUNDS");
  const int rounds = wanted ? std::atoi(wanted) : 20000;
  std::mt19937 random(1);
  const auto below = [&](std::size_t limit) { return random() % limit; };
  for (int round = 0; round < rounds; ++round) {
    static Units units = make_units({Model::simple, Model::sh4});
    Session session(units);
    Bytes message;
    if (below(8) != 0)
      message = import_request(below(2) != 0 ? "1-1" : "1-2");
    if (below(8) != 0)
      message = message + submit(1, false, 0, 0, kSetConfiguration);
    const std::size_t commands = below(8);
    for (std::size_t i = 0; i < commands; ++i) {
      switch (below(5)) {
      case 0:
        message = message + out(2, bytes(spidar::simple::latch_counters()));
        break;
      case 1:
        message = message + out(3, bytes(spidar::sh4::update({})));
        break;
      case 2:
        message = message + in(4, static_cast<std::uint32_t>(below(2000)));
        break;
      case 3:
        message = message + unlink(5, 4);
        break;
      default:
        message = message + submit(6, below(2) != 0, 0, static_cast<std::uint32_t>(below(300)),
                                   golden("80 06 0002 0000 ff00"));
      }
    }
    const std::size_t flips = below(6);
    for (std::size_t i = 0; i < flips && !message.empty(); ++i)
      message[below(message.size())] = static_cast<std::uint8_t>(random() & 0xff);
    const Time now = kStart + std::chrono::microseconds(round);
    for (std::span<const std::uint8_t> rest = message; !rest.empty();) {
      const std::size_t size = std::min(rest.size(), 1 + below(100));
      if (!session.receive(rest.first(size), now))
        break;
      rest = rest.subspan(size);
    }
    // No more than the few requests can be answered with.
    ASSERT_LT(session.output().size(), 100000U);
  }
}

} // namespace spidar_emulator_test
