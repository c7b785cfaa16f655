// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/reopening.hpp"

#include <cerrno>
#include <gtest/gtest.h>
#include <system_error>
#include <vector>

namespace reopening_test {

constexpr std::int64_t kMs = 1'000'000; // ns

class Reopening : public ::testing::Test, public haptic::SessionClient {
protected:
  void on_notice(const haptic::Notice &notice) override {
    if (notice.cause)
      warnings_.push_back(notice.text);
  }
  bool on_point(const haptic::PointerPosition &) override { return true; }
  void on_armed_changed() override {}
  std::optional<haptic::ClockReading> read_clocks() override { return std::nullopt; }

  /// Looks every 10 ms for so long. Returns when it tried, ms.
  std::vector<std::int64_t> tries(std::int64_t ms, spidar::Cause cause) {
    std::vector<std::int64_t> times;
    for (const std::int64_t end = now_ + ms * kMs; now_ < end; now_ += 10 * kMs)
      reopening_.attempt(
          now_,
          [&]() -> haptic::Reopening::Device {
            times.push_back(now_ / kMs);
            throw spidar::Error(cause, "refused");
          },
          *this);
    return times;
  }

  haptic::Reopening reopening_;
  std::int64_t now_ = 0;
  std::vector<std::string> warnings_;
};

TEST_F(Reopening, TriesAfterATenthOfASecondThenLessOftenDownToTwiceASecond) {
  const std::vector<std::int64_t> expected = {100, 300, 700, 1200, 1700};
  EXPECT_EQ(tries(2000, spidar::Cause::not_found), expected);
}

TEST_F(Reopening, BeginsAnewAfterTheDeviceWasThere) {
  tries(2000, spidar::Cause::not_found);
  bool opened = false;
  now_ = 2200 * kMs;
  reopening_.attempt(
      now_,
      [&] {
        opened = true;
        return haptic::Reopening::Device();
      },
      *this);
  EXPECT_TRUE(opened);
  reopening_.rest();
  const std::vector<std::int64_t> expected = {2300, 2500};
  EXPECT_EQ(tries(500, spidar::Cause::not_found), expected);
}

TEST_F(Reopening, TriesAgainWithoutAThreadOrMemoryToOpenItWith) {
  int attempts = 0;
  for (; now_ < 1000 * kMs; now_ += 10 * kMs)
    reopening_.attempt(
        now_,
        [&]() -> haptic::Reopening::Device {
          ++attempts;
          throw std::system_error(EAGAIN, std::generic_category());
        },
        *this);
  EXPECT_EQ(attempts, 3);
}

TEST_F(Reopening, WarnsOnceOfADeviceThatIsThereButStaysClosed) {
  tries(2000, spidar::Cause::not_found);
  EXPECT_TRUE(warnings_.empty());
  tries(3000, spidar::Cause::permission);
  EXPECT_EQ(warnings_, std::vector<std::string>{"refused"});
}

} // namespace reopening_test
