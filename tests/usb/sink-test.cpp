// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink with a controller that is pulled out of its socket while a film plays.
#include "direct-fixture.hpp"
#include "fake-guardian.hpp"
#include "hapticsink-fixture.hpp"
#include "loop-priority.hpp"
#include "report-line.hpp"

#include <cstdlib>

namespace sink_test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::eventually;
using test::MockUnit;
using test::Model;

class Sink : public test::HapticSink {
protected:
  void SetUp() override {
    if (!test::mocking())
      GTEST_SKIP() << "needs umockdev: run it by 'meson test', or under umockdev-wrapper";
    HapticSink::SetUp();
    bus_ = std::make_unique<test::MockBus>();
    test::direct_bus = bus_.get();
  }
  void TearDown() override {
    if (!bus_)
      return;
    film_ = {};
    HapticSink::TearDown();
    test::direct_bus = nullptr;
  }

  void plug(Model model = Model::simple) {
    unit_ = std::make_shared<MockUnit>(model, 6);
    number_ = bus_->plug(unit_);
  }
  /// A film in which everything moves to the right, live.
  void play(const std::string &device) {
    build("device=" + device + " sync=false");
    set(GST_STATE_PLAYING);
    show_film();
  }
  void show_film() {
    film_ = std::jthread([this](const std::stop_token &stop) {
      for (GstClockTime pts = 0; !stop.stop_requested(); pts += test::kFrame) {
        gst_app_src_push_buffer(GST_APP_SRC(source_.get()),
                                test::packed(test::moving(1000, 0), pts));
        std::this_thread::sleep_for(33ms);
      }
    });
  }
  static int highest(const spidar::DacWords &words) {
    return *std::max_element(words.begin(), words.end());
  }
  bool force_on_the_wire() const { return highest(unit_->words()) > 60; } // minimum tension is 45
  void arm() { g_signal_emit_by_name(sink_.get(), "arm"); }
  std::string text_of(GstMessage *message) {
    GError *error = nullptr;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_INFO)
      gst_message_parse_info(message, &error, nullptr);
    else
      gst_message_parse_warning(message, &error, nullptr);
    std::string text = error->message;
    g_error_free(error);
    return text;
  }
  /// Waits for an information with these words. On a busy machine one may say that it is late.
  bool is_told(const std::string &words) {
    while (const auto info = message(GST_MESSAGE_INFO))
      if (text_of(info.get()).find(words) != std::string::npos)
        return true;
    return false;
  }

  std::unique_ptr<test::MockBus> bus_;
  std::shared_ptr<MockUnit> unit_;
  int number_ = 0;
  std::jthread film_;
};

TEST_F(Sink, F13_F14_UnpluggedAtRandomInstantsTheFilmGoesOnAndTheDeviceComesBackDisarmed) {
  const char *wanted = std::getenv("FEELING_WIND_UNPLUGS");
  const int rounds = wanted ? std::atoi(wanted) : 10;
  std::mt19937 random(13);
  plug();
  play("usb:6");
  double slowest_fault = 0;  // ms
  double slowest_return = 0; // ms
  for (int round = 0; round < rounds; ++round) {
    ASSERT_TRUE(eventually([&] { return force_on_the_wire(); })) << round;
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 20'000));

    const guint64 samples = count("samples");
    const guint64 faults = count("faults");
    Clock::time_point unplugged;
    Clock::time_point faulted;
    {
      const test::AsTheLoop priority;
      unplugged = bus_->unplug(number_);
      // Not `armed`, for which a thread of less priority may have the lock.
      while (count("faults") == faults && Clock::now() - unplugged < 10s)
        std::this_thread::sleep_for(200us);
      faulted = Clock::now();
    }
    ASSERT_TRUE(eventually([&] { return !armed(); }));
    const auto warning = message(GST_MESSAGE_WARNING);
    ASSERT_TRUE(warning);
    EXPECT_NE(text_of(warning.get()).find("does not answer"), std::string::npos);
    ASSERT_TRUE(eventually([&] { return count("samples") > samples + 2; })) << "the film stands";

    if (round % 10 == 5) // long enough for the longest pause between two attempts
      std::this_thread::sleep_for(1500ms);
    plug(round % 2 ? Model::sh4 : Model::simple);
    const auto plugged = Clock::now();
    ASSERT_TRUE(is_told("is back"));
    const auto back = Clock::now();
    std::this_thread::sleep_for(50ms);
    EXPECT_FALSE(armed());
    EXPECT_FALSE(force_on_the_wire());
    arm();
    using Milliseconds = std::chrono::duration<double, std::milli>;
    slowest_fault = std::max(slowest_fault, Milliseconds(faulted - unplugged).count());
    slowest_return = std::max(slowest_return, Milliseconds(back - plugged).count());
  }
  ASSERT_FALSE(message(GST_MESSAGE_ERROR, 0));
  test::report("unplug-faulted-ms", slowest_fault);
  test::report("replug-reopened-ms", slowest_return);
}

TEST_F(Sink, ArmingWhatIsNotThereDoesNotArmItWhenItIsBack) {
  plug();
  play("usb");
  ASSERT_TRUE(eventually([&] { return force_on_the_wire(); }));
  bus_->unplug(number_);
  ASSERT_TRUE(eventually([&] { return !armed(); }));
  arm();
  EXPECT_FALSE(armed());
  plug();
  ASSERT_TRUE(is_told("is back"));
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(armed());
  EXPECT_FALSE(force_on_the_wire());
}

TEST_F(Sink, AUnitUnpluggedBetweenTwoRunsIsLookedForInTheNext) {
  plug();
  play("usb");
  ASSERT_TRUE(eventually([&] { return force_on_the_wire(); }));
  bus_->unplug(number_);
  ASSERT_TRUE(eventually([&] { return !armed(); }));
  set(GST_STATE_READY);
  set(GST_STATE_PLAYING);
  plug();
  ASSERT_TRUE(is_told("is back"));
  std::this_thread::sleep_for(20ms);
  arm();
  EXPECT_TRUE(eventually([&] { return force_on_the_wire(); }));
}

TEST_F(Sink, F22_TheSecondOfTwoThatWantOneDeviceIsToldWhoHasIt) {
  plug();
  play("usb");
  const test::ElementPtr second(gst_element_factory_make("hapticsink", nullptr));
  gst_object_ref_sink(second.get());
  g_object_set(second.get(), "device", "usb", nullptr);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(second.get(), bus);
  EXPECT_EQ(gst_element_set_state(second.get(), GST_STATE_READY), GST_STATE_CHANGE_FAILURE);
  const test::MessagePtr refused(gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR));
  ASSERT_TRUE(refused);
  GError *error = nullptr;
  gst_message_parse_error(refused.get(), &error, nullptr);
  EXPECT_TRUE(g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_BUSY));
  EXPECT_NE(std::string(error->message).find("in use by this program"), std::string::npos);
  g_error_free(error);
  gst_element_set_state(second.get(), GST_STATE_NULL);
  gst_element_set_bus(second.get(), nullptr);
  gst_object_unref(bus);
}

// In READY nobody tells the guardian that the program lives.
TEST_F(Sink, InReadyTheMotorsAreAtRestWhereverTheGripIsAndTheGuardianKnows) {
  const char *wanted = std::getenv("FEELING_WIND_READY");
  const int rounds = wanted ? std::atoi(wanted) : 20;
  test::FakeGuardian guardian;
  plug();
  build("device=usb:6 sync=false");
  set(GST_STATE_READY);
  const spidar::DacWords rest = unit_->words();
  guardian.guard(*unit_);
  unit_->move_hand({0.8, -0.6, 0.5});
  show_film();
  std::uint64_t faults = 0;
  for (int round = 0; round < rounds; ++round) {
    set(GST_STATE_PLAYING);
    ASSERT_TRUE(eventually([&] { return force_on_the_wire(); })) << round;
    set(GST_STATE_READY);
    faults += count("faults");
    ASSERT_EQ(unit_->words(), rest) << round;
    ASSERT_TRUE(guardian.is_told(spidar::kRest)) << round;
    const int before = guardian.interventions();
    std::this_thread::sleep_for(15ms);
    ASSERT_EQ(guardian.interventions(), before) << round;
  }
  film_ = {};
  stop();
  test::report("ready-faults", static_cast<double>(faults)); // ticks may have been late
}

// A faulted loop asks the device ten times a second, and says nothing to the guardian between.
TEST_F(Sink, OffTheCentreAFaultedLoopLeavesTheMotorsAtRestWithoutTheGuardian) {
  const test::ThreadedGuardian guardian;
  plug();
  build("device=usb:6 sync=false");
  set(GST_STATE_READY);
  const spidar::DacWords rest = unit_->words();
  unit_->move_hand({0.8, -0.6, 0.5});
  show_film();
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(eventually([&] { return force_on_the_wire(); }));
  const std::uint64_t before = count("faults");
  unit_->faults([](test::Faults &faults) { faults.silent = true; });
  ASSERT_TRUE(eventually([&] { return count("faults") > before; }));
  unit_->faults([](test::Faults &faults) { faults.silent = false; });
  ASSERT_TRUE(eventually([&] { return unit_->words() == rest; }));
  std::atomic<int> packets = 0;
  std::atomic<int> flips = 0;
  unit_->faults([&](test::Faults &faults) {
    faults.watch = [&](std::span<const std::uint8_t> packet) {
      if (packet[0] != 0x52) // sets the motors
        return;
      ++packets;
      for (std::size_t i = 0; i < rest.size(); ++i)
        if ((packet[1 + 2 * i] | packet[2 + 2 * i] << 8) != rest[i]) {
          ++flips;
          return;
        }
    };
  });
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(eventually([&] { return packets >= 10; })) << "the loop still asks";
  unit_->faults([](test::Faults &faults) { faults.watch = nullptr; });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(flips, 0) << "words that are more than minimum tension";
  EXPECT_LE(packets, elapsed.count() / 0.1 + 1) << "one each 0.1 s: the guardian adds none";
  film_ = {};
  stop();
}

TEST_F(Sink, ItsEndLeavesMinimumTension) {
  plug();
  play("usb");
  ASSERT_TRUE(eventually([&] { return force_on_the_wire(); }));
  film_ = {};
  stop();
  EXPECT_FALSE(force_on_the_wire());
  for (const std::int16_t word : unit_->words())
    EXPECT_NEAR(word, 46, 1); // 0.3 N
}

} // namespace sink_test
