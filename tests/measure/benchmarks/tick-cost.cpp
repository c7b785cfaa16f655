// SPDX-License-Identifier: LGPL-2.1-or-later
// Prints how long the median tick of the loop takes without the controller's exchange, ns. For
// tick-cost.sh, which compiles it with an earlier loop, too.
//   tick-cost own|touching wait|hurry TICKS
// `wait`: a tick each millisecond, as the loop does; it finds cold caches. `hurry`: each tick at
// once after the one before, in made time, so that every run executes the same instructions.
#include "timed-loop.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

int main(int argc, char **argv) {
  const int ticks = argc == 4 ? std::atoi(argv[3]) : 0;
  if (ticks <= 0)
    return EXIT_FAILURE;
  const bool waits = std::string_view(argv[2]) == "wait";
  test::TimedLoop loop(std::string_view(argv[1]) == "touching");
  if (waits)
    test::take_priority_of_loop();
  std::vector<std::int64_t> taken;
  std::int64_t next = haptic::monotonic_now();
  for (int tick = 0; tick < ticks; ++tick) {
    next += test::kPeriod;
    if (waits)
      test::wait_until(next);
    const std::int64_t now = waits ? haptic::monotonic_now() : next;
    loop.submit(tick, now);
    taken.push_back(loop.tick(next, now));
  }
  const auto middle = taken.begin() + ticks / 2;
  std::ranges::nth_element(taken, middle);
  std::printf("%lld\n", static_cast<long long>(*middle));
  return EXIT_SUCCESS;
}
