// SPDX-License-Identifier: LGPL-2.1-or-later
// Garbage in place of replies: nothing breaks, and nothing is believed that cannot be.
#include "direct-fixture.hpp"

#include <cstdlib>
#include <random>

namespace fuzz_test {

using namespace test;

class Fuzz : public DirectlyOnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, Fuzz, ::testing::Values(Model::simple, Model::sh4), name_of_model);

// The long run: FEELING_WIND_FUZZ_REPLIES=1000000.
TEST_P(Fuzz, RepliesNeverMoveThePoseAwayOrTheTensionsOutOfTheirLimits) {
  const char *wanted = std::getenv("FEELING_WIND_FUZZ_REPLIES");
  const int replies = wanted ? std::atoi(wanted) : 20'000;
  std::mt19937 random(1); // longer than the device, which still exchanges as it ends
  plug(GetParam(), 0);
  const auto device = open_device();
  unit_->faults([&](Faults &faults) {
    faults.mangle = [&](Bytes &bytes) {
      switch (random() % 20) {
      case 0:
        bytes.resize(random() % 513);
        break;
      case 1:
        bytes.resize(bytes.size() + random() % 100);
        break;
      default:
        break;
      }
      const std::size_t pio = GetParam() == Model::sh4 ? 48 : 24;
      const bool keep_switch = random() % 50 != 0; // else most would be refused for it alone
      for (auto n = random() % 40; n > 0 && !bytes.empty(); --n)
        if (const auto at = random() % bytes.size(); at != pio || !keep_switch)
          bytes[at] = static_cast<std::uint8_t>(random());
    };
  });
  const spidar::Geometry &geometry = device->geometry();
  for (int i = 0; i < replies; ++i) {
    device->exchange((i + 1) * std::int64_t{1'000'000});
    device->command({{1, 0, 0}, spidar::Vector3::Zero()});
    const spidar::DeviceState &state = device->state();
    ASSERT_TRUE(state.pose.position.allFinite());
    ASSERT_LT(state.pose.position.norm(), 0.3);
    ASSERT_GE(state.tensions.minCoeff(), geometry.tension_min - 1e-9);
    ASSERT_LE(state.tensions.maxCoeff(), geometry.tension_max + 1e-9);
  }
  ASSERT_TRUE(device->connected());
}

} // namespace fuzz_test
