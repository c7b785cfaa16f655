// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-check stops and kills the real guardian of a controller on USB.
#include "check-guardian.hpp"
#include "direct-fixture.hpp"

#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

namespace check_guardian_test {

using namespace test;
using namespace spidar_check;

/// Counts ticks, each of which gives the real guardian at least a millisecond: the force that a
/// check waits for is there after the same number of ticks, however late this machine is.
class TimeOfTicks final : public SimulatedTime {
public:
  void wait_until(Clock::time_point time) override {
    std::this_thread::sleep_for(1ms);
    SimulatedTime::wait_until(time);
  }
};

class CheckGuardian : public DirectlyOnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, CheckGuardian, ::testing::Values(Model::simple, Model::sh4),
                         name_of_model);

// The times are not asserted: what is noticed has a time in its figure, what is not has none.
TEST_P(CheckGuardian, ThatIsStoppedOrKilledIsNoticed) {
  plug(GetParam(), 5);
  adopt_guardians();
  Unit checked(spidar::open_usb(""), spidar::load_geometry(spidar::kDefaultGeometry),
               std::make_shared<TimeOfTicks>());
  std::string figure;
  const Report report = [&](const Finding &finding) { figure = finding.figure; };
  check_guardian_hangs(checked, 0.2, signal_guardian, report);
  EXPECT_NE(figure.find("ms promised"), std::string::npos) << figure;
  EXPECT_TRUE(checked.connected());
  check_guardian_dies(checked, 0.2, signal_guardian, report);
  EXPECT_NE(figure.find("ms promised"), std::string::npos) << figure;
  EXPECT_FALSE(checked.connected());
}

// Its shell may have left a child to it, as in `exec spidar-check --device usb > >(tee log)`.
TEST(SignalGuardian, ReachesNoOtherChild) {
  const pid_t other = fork();
  if (other == 0) {
    pause();
    _exit(0);
  }
  EXPECT_FALSE(signal_guardian(0));
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
}

} // namespace check_guardian_test
