// SPDX-License-Identifier: LGPL-2.1-or-later
// The paper's predecessor: a gain such that the fastest motion of the last seconds gives max_force.
#include "force-law.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {

ForceLawInfo linear_law() noexcept;

namespace {

// Without it silence would be amplified into a buzz.
constexpr double kSlowestMaximum = 10; // px/s

// The maximum of a window that slides in steps of 1/32 of its length: a row of maxima, so that a
// minute of ticks needs no more memory than a second.
class SlidingMaximum {
public:
  double update(double value, double window, double dt) noexcept {
    elapsed_ += dt;
    const double step = window / static_cast<double>(maxima_.size() - 1);
    for (std::size_t n = 0; elapsed_ >= step && n < maxima_.size(); ++n) {
      elapsed_ -= step;
      newest_ = (newest_ + 1) % maxima_.size();
      maxima_[newest_] = 0;
    }
    elapsed_ = std::min(elapsed_, step);
    maxima_[newest_] = std::max(maxima_[newest_], value); // std::max keeps NaN out
    return *std::ranges::max_element(maxima_);
  }

private:
  std::array<double, 33> maxima_{};
  std::size_t newest_ = 0;
  double elapsed_ = 0; // s, since the newest began
};

class LinearLaw final : public ForceLaw {
  PlanarForce force(const Motion &m, const PlanarVelocity &, const LawSettings &s,
                    double dt) noexcept override {
    const double fastest =
        fastest_.update(std::hypot(m.velocity.x, m.velocity.y), s.gain_window, dt);
    const double k = s.max_force / std::max(fastest, kSlowestMaximum);
    return {k * m.velocity.x, k * m.velocity.y};
  }

  SlidingMaximum fastest_; // px/s
};

} // namespace

ForceLawInfo linear_law() noexcept {
  return {"linear", "In proportion to the speed; the fastest of the last gain-window is max-force",
          []() -> std::unique_ptr<ForceLaw> { return std::make_unique<LinearLaw>(); }};
}

} // namespace haptic
