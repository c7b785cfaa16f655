// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/measure.hpp"

namespace lab {

std::vector<Answer> measure(const Configuration &configuration, const CaseSet &set,
                            std::size_t stride) {
  constexpr int kWarmUps = 2;
  constexpr int kPasses = 3;
  constexpr double kShort = 50e3; // µs that a pass may take to be repeated
  const auto method = configuration.make();
  for (int i = 0; i < kWarmUps; ++i)
    method->measure(set.cases.front().task);
  std::vector<Answer> answers;
  double total = 0;
  for (std::size_t i = 0; i < set.cases.size(); i += stride) {
    const Case &one = set.cases[i];
    method->forget();
    const auto begin = Clock::now();
    const Reading reading = method->measure(one.task);
    const double time = microseconds_since(begin);
    const Vector difference = (reading.confidence > 0 ? reading.velocity : Vector()) - one.truth;
    answers.push_back({cv::norm(difference), reading.confidence, time, difference});
    total += time;
  }
  // Whole passes, so that other cases use the caches in between.
  for (int pass = 1; pass < kPasses && total < kShort; ++pass)
    for (std::size_t i = 0; i < answers.size(); ++i) {
      method->forget();
      const auto begin = Clock::now();
      method->measure(set.cases[i * stride].task);
      answers[i].time = std::min(answers[i].time, microseconds_since(begin));
    }
  return answers;
}

std::vector<double> measure(Method &method, const Stream &stream) {
  method.forget();
  std::vector<double> times;
  for (std::size_t i = 1; i < stream.frames.size(); ++i) {
    const Task task{stream.frames[i - 1], stream.frames[i], {0.5, 0.5}, 30, i > 1};
    const auto begin = Clock::now();
    method.measure(task);
    const double time = microseconds_since(begin);
    if (i > 1)
      times.push_back(time);
  }
  return times;
}

Equivariance measure(Method &method, const ClipCase &clip) {
  constexpr double kLeastConfidence = 0.3;
  const auto ask = [&](const Task &task) {
    method.forget();
    return method.measure(task);
  };
  const Reading plain = ask(clip.plain);
  const Reading shifted = ask(clip.shifted);
  const Reading reversed = ask(clip.reversed);
  return {cv::norm(shifted.velocity - plain.velocity - clip.shift),
          cv::norm(plain.velocity + reversed.velocity),
          std::min({plain.confidence, shifted.confidence, reversed.confidence}) >=
              kLeastConfidence};
}

} // namespace lab
