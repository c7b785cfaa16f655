// SPDX-License-Identifier: LGPL-2.1-or-later
// main() of every GoogleTest program. Prints "SKIPPED: reason" for each skipped case, and exits
// with 77, meson's word for a skipped test, if no case has failed and every case has been skipped.
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

#ifdef __has_feature // clang's
#if __has_feature(address_sanitizer)
#define HAPTIC_LEAKS_ARE_FOUND
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define HAPTIC_LEAKS_ARE_FOUND
#endif
#ifdef HAPTIC_LEAKS_ARE_FOUND
#include <sanitizer/lsan_interface.h>
#endif

namespace {

constexpr int kSkipped = 77;

#ifdef HAPTIC_LEAKS_ARE_FOUND
// While GLib is loaded it leaves a first table of interned strings behind (gquark.c says so). Runs
// before any library's own initialisation.
[[gnu::section(".preinit_array"), gnu::used]] void (*const ignore_the_libraries)() = __lsan_disable;
#endif

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
#ifdef HAPTIC_LEAKS_ARE_FOUND
  __lsan_enable();
#endif
  testing::InitGoogleTest(&argc, argv);
  auto &tests = *testing::UnitTest::GetInstance();
  tests.listeners().Append(new SkipReporter); // belongs to the listeners from now on
  const int status = RUN_ALL_TESTS();
  const bool all_skipped =
      tests.skipped_test_count() > 0 && tests.skipped_test_count() == tests.test_to_run_count();
  return status == 0 && all_skipped ? kSkipped : status;
}
