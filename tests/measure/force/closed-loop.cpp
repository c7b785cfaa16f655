// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs the table of the closed loop (tests/support/closed-loop.hpp) in virtual time, and prints for
// each row how many points keep what is wanted, and the worst of them.
#include "closed-loop.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr const char *kUsage =
    "Usage: closed-loop [--arm] [--row NAME] [--only WORDS] [--sample N] [--seed N] [--threes] "
    "[--points] [--jobs N]\n"
    "  --arm         on the simulated arm instead of the strings\n"
    "  --row NAME    only this row of the table\n"
    "  --only WORDS  only the points that have each of these words, as \"law=drag alpha=0.04\"\n"
    "  --sample N    of each row N points by chance\n"
    "  --seed N      other ones\n"
    "  --threes      of each row few points, in which any values of three axes occur together\n"
    "  --points      prints each point; 'jump': the hand gets more than is wanted, but no more\n"
    "                than the present force does before the loop knows that the hand jumps\n"
    "  --jobs N      so many at once; default: one for each processor\n"
    "Exits with 1 if a point is lost, but not to a jump, or if a row proves nothing.\n";

struct Options {
  test::Bench bench = test::Bench::strings;
  std::string row;
  std::string only;
  std::size_t sample = 0;
  unsigned seed = 1;
  bool threes = false;
  bool points = false;
  unsigned jobs = std::max(std::thread::hardware_concurrency(), 1U);
};

Options options_of(const std::vector<std::string> &words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string &word = words[i];
    if (word == "--points") {
      options.points = true;
      continue;
    }
    if (word == "--threes") {
      options.threes = true;
      continue;
    }
    if (word == "--arm") {
      options.bench = test::Bench::arm;
      continue;
    }
    if (++i == words.size())
      throw std::invalid_argument(word + " needs a value");
    const std::string &value = words[i];
    if (word == "--row")
      options.row = test::closed_loop_row(value).name;
    else if (word == "--only")
      options.only = value;
    else if (word == "--sample")
      options.sample = std::stoul(value);
    else if (word == "--seed")
      options.seed = static_cast<unsigned>(std::stoul(value));
    else if (word == "--jobs")
      options.jobs = std::max(static_cast<unsigned>(std::stoul(value)), 1U);
    else
      throw std::invalid_argument("unknown option '" + word + "'");
  }
  return options;
}

std::vector<test::Outcome> run(const test::LoopRow &row, const std::vector<std::size_t> &points,
                               unsigned jobs) {
  std::vector<test::Outcome> outcomes(points.size());
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> workers;
  for (unsigned i = 0; i < jobs; ++i)
    workers.emplace_back([&] {
      for (std::size_t n = next++; n < points.size(); n = next++)
        outcomes[n] = row.run(row.at(points[n]));
    });
  workers.clear(); // joins
  return outcomes;
}

void print(const test::Outcome &outcome, const std::string &words) {
  const char *result = outcome.kept() ? "kept" : outcome.lost_to_jump() ? "jump" : "LOST";
  std::printf("  %s %.4g of %.4g%s%s: %s\n", result, outcome.figure, outcome.most,
              outcome.idle.empty() ? "" : ", proves nothing: ", outcome.idle.c_str(),
              words.c_str());
}

// Returns how many points are lost, but not to a jump; all of them if none proves something.
std::size_t report(const test::LoopRow &row, const std::vector<std::size_t> &points,
                   const Options &options) {
  const std::vector<test::Outcome> outcomes = run(row, points, options.jobs);
  std::size_t kept = 0;
  std::size_t jumps = 0;
  std::size_t idle = 0;
  std::size_t worst = 0;
  const auto excess = [&](std::size_t i) { return outcomes[i].figure / outcomes[i].most; };
  for (std::size_t i = 0; i < points.size(); ++i) {
    kept += outcomes[i].kept();
    jumps += outcomes[i].lost_to_jump();
    idle += !outcomes[i].idle.empty();
    if (excess(i) > excess(worst))
      worst = i;
    if (options.points)
      print(outcomes[i], row.words(points[i]));
  }
  std::printf("%-18s kept %zu of %zu, %zu lost to a jump, %zu prove nothing (%s)\n  worst",
              row.name.c_str(), kept, points.size(), jumps, idle, row.figure.c_str());
  print(outcomes[worst], row.words(points[worst]));
  std::fflush(stdout);
  return kept > 0 ? points.size() - kept - jumps - idle : points.size();
}

} // namespace

int main(int argc, char **argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (std::ranges::count(words, "--help") > 0) {
    std::fputs(kUsage, stdout);
    return EXIT_SUCCESS;
  }
  try {
    const Options options = options_of(words);
    std::size_t lost = 0;
    bool any = false;
    for (const test::LoopRow &row : test::closed_loop_table(options.bench)) {
      if (!options.row.empty() && options.row != row.name)
        continue;
      const auto points =
          options.threes ? row.threes() : row.select(options.only, options.sample, options.seed);
      if (points.empty())
        continue;
      any = true;
      lost += report(row, points, options);
    }
    if (!any)
      throw std::invalid_argument("no row has such a point");
    return lost == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "closed-loop: %s\n%s", error.what(), kUsage);
    return 2;
  }
}
