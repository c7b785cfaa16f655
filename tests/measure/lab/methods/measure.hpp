// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs a method on all cases and times each.
#pragma once

#include "methods/cases.hpp"

#include <chrono>
#include <vector>

namespace lab {

using Clock = std::chrono::steady_clock;

inline double microseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

struct Answer {
  double error = 0;      ///< px; where only silence is right, the length of what was said
  double confidence = 0; ///< 0..1
  double time = 0;       ///< µs, the least of some passes
  Vector difference;     ///< answer minus truth, px
};

/// Every `stride`-th case, each timed on its own from the whole luma to the velocity. An answer
/// without confidence counts as zero velocity, as the hand feels it.
std::vector<Answer> measure(const Configuration &configuration, const CaseSet &set,
                            std::size_t stride = 1);

/// Time in µs of each frame of a stream after the first pair.
std::vector<double> measure(Method &method, const Stream &stream);

struct Equivariance {
  double shift_error = 0;    ///< px, what a known shift of the second frame changes too much
  double reversal_error = 0; ///< px, forward plus backward
  bool is_answered = false;  ///< all three with a confidence that the force is not faded at
};

Equivariance measure(Method &method, const ClipCase &clip);

} // namespace lab
