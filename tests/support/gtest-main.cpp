// SPDX-License-Identifier: LGPL-2.1-or-later
// main() of every GoogleTest program. Prints "SKIPPED: reason" for each skipped case, and exits
// with 77, meson's word for a skipped test, if no case has failed and every case has been skipped.
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

namespace {

constexpr int kSkipped = 77;

class SkipReporter final : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo &info) override {
    const testing::TestResult &result = *info.result();
    for (int i = 0; result.Skipped() && i < result.total_part_count(); ++i)
      if (result.GetTestPartResult(i).skipped()) {
        const std::string reason = result.GetTestPartResult(i).message();
        std::printf("SKIPPED: %s\n", reason.substr(0, reason.find('\n')).c_str());
        std::fflush(stdout);
      }
  }
};

} // namespace

int main(int argc, char **argv) {
  testing::InitGoogleTest(&argc, argv);
  auto &tests = *testing::UnitTest::GetInstance();
  tests.listeners().Append(new SkipReporter); // belongs to the listeners from now on
  const int status = RUN_ALL_TESTS();
  const bool all_skipped =
      tests.skipped_test_count() > 0 && tests.skipped_test_count() == tests.test_to_run_count();
  return status == 0 && all_skipped ? kSkipped : status;
}
