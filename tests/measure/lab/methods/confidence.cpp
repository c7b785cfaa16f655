// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/confidence.hpp"

#include "methods/cases.hpp"
#include "methods/measure.hpp"

#include <algorithm>
#include <array>

namespace lab {
namespace {

constexpr int kSeeds = 5;
constexpr std::size_t kBins = 10;

bool has_confidence(const Configuration &c) {
  constexpr std::array kMethods = {"fast", "method=opencv", "PyrLK crop back", "phase correlation",
                                   "ECC"};
  return std::ranges::find(kMethods, c.method) != kMethods.end();
}

Judged judge(const Configuration &configuration, const CaseSet &set) {
  Judged judged;
  const std::vector<Answer> answers = measure(configuration, set);
  for (std::size_t i = 0; i < answers.size(); ++i)
    if (const Case &one = set.cases[i]; one.scene != kRoundedMotion)
      judged.add(answers[i].confidence, answers[i].error, one.is_unseen);
  return judged;
}

void add_calibration(const std::string &method, const Judged &judged, Report &report) {
  std::array<std::vector<double>, kBins> bins;
  for (std::size_t i = 0; i < judged.errors.size(); ++i)
    bins[std::min(kBins - 1, static_cast<std::size_t>(judged.confidences[i] * kBins))].push_back(
        judged.errors[i]);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const auto good = static_cast<std::size_t>(
        std::ranges::count_if(bins[bin], [](double error) { return error <= kBadError; }));
    const std::size_t all = bins[bin].size();
    if (all > 0)
      report.reliability.push_back({method, (static_cast<double>(bin) + 0.5) / kBins, all,
                                    static_cast<double>(good) / static_cast<double>(all),
                                    wilson(good, all)});
  }
}

} // namespace

void measure_confidence(const std::vector<Configuration> &defaults, bool quick, Report &report) {
  std::map<std::string, Judged> all;
  for (int seed = 0; seed < kSeeds; ++seed) {
    // Apart from the stratum "hard", which is number 0.
    const CaseSet set = hard_set(quick ? 1 : 16, seed + 1);
    for (const Configuration &c : defaults) {
      if (!has_confidence(c))
        continue;
      const Judged judged = judge(c, set);
      report.area[c.method].push_back(judged.area());
      all[c.method].add(judged);
    }
  }
  for (const auto &[method, judged] : all) {
    for (const RocPoint &point : judged.curve())
      report.roc.push_back({method, point});
    add_calibration(method, judged, report);
  }
}

} // namespace lab
