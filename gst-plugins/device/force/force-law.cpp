// SPDX-License-Identifier: LGPL-2.1-or-later
// A new law is a class here and a row in kLaws.
#include "force/force-law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace haptic {
namespace {

constexpr double kDivergenceHalf = 0.5; // 1/s that give half of max_push

// Equation 5 of the paper on the speed, along v: F = (2 F_max / pi) atan(alpha |v|) v / |v|.
PlanarForce arctan_force(double x, double y, const LawSettings &s) noexcept {
  const double gain = arctan_gain(std::hypot(x, y), s.alpha, s.max_force);
  return {gain * x, gain * y};
}

class ArctanLaw final : public ForceLaw {
  Relative force(const Motion &m, const PlanarVelocity &, const LawSettings &s,
                 double) noexcept override {
    return {arctan_force(m.velocity.x, m.velocity.y, s), {}};
  }
};

// Equation 5 of the paper as printed, for each axis k: F_k = (2 F_max / pi) atan(alpha v_k). It
// bends diagonal motions towards the diagonal, and its length reaches 1.41 max_force (the safety
// chain cuts that).
class ArctanAxisLaw final : public ForceLaw {
  Relative force(const Motion &m, const PlanarVelocity &, const LawSettings &s,
                 double) noexcept override {
    const auto &v = m.velocity;
    return {{arctan_gain(v.x, s.alpha, s.max_force) * v.x,
             arctan_gain(v.y, s.alpha, s.max_force) * v.y},
            {}};
  }
};

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

// The linear gain of the paper's predecessor:
// F = F_max v / max(v_floor, fastest |v| of the last gain_window).
class LinearLaw final : public ForceLaw {
  Relative force(const Motion &m, const PlanarVelocity &, const LawSettings &s,
                 double dt) noexcept override {
    const double fastest =
        fastest_.update(std::hypot(m.velocity.x, m.velocity.y), s.gain_window, dt);
    const double gain = s.max_force / std::max(fastest, kSlowestMaximum);
    return {{gain * m.velocity.x, gain * m.velocity.y}, {}};
  }

  // v_floor: without it noise at standstill would be amplified to max_force.
  static constexpr double kSlowestMaximum = 10; // px/s

  SlidingMaximum fastest_; // px/s
};

class RelativeLaw : public ForceLaw {
protected:
  // Equation 5 on the motion relative to the hand, at most `most` N from that on the frame's
  // motion.
  static Relative relative_force(const PlanarVelocity &frame, const PlanarVelocity &hand,
                                 double most, const LawSettings &s) noexcept {
    const PlanarForce at_rest = arctan_force(frame.x, frame.y, s);
    const PlanarForce moving = arctan_force(frame.x - hand.x, frame.y - hand.y, s);
    PlanarForce of_hand{moving.x - at_rest.x, moving.y - at_rest.y};
    const double change = std::hypot(of_hand.x, of_hand.y);
    if (change <= most)
      return {moving, of_hand};
    of_hand = {most / change * of_hand.x, most / change * of_hand.y};
    return {{at_rest.x + of_hand.x, at_rest.y + of_hand.y}, of_hand};
  }
};

// The drag of a wind: equation 5 on v - v_hand. A hand at rest feels what `arctan` gives. One that
// moves with the frame would feel nothing; the limit of its part leaves it most of the wind.
class DragLaw final : public RelativeLaw {
  Relative force(const Motion &m, const PlanarVelocity &hand, const LawSettings &s,
                 double) noexcept override {
    return relative_force(m.velocity, hand, s.most_for_hand, s);
  }
};

// Newton's second law on the acceleration of the frame relative to the hand (Dindar, Tekalp and
// Basdogan's dynamic force), the acceleration taken over T = 0.1 s: a raw second difference of
// 0.1 px of tracking noise at 30 frames/s is 220 px/s². With the low-pass u of v and of v_hand,
// u += (1 - exp(-dt / T)) (v - u), it is equation 5 on the velocity v - u that the frame gained
// within T, less the hand's.
class InertialLaw final : public RelativeLaw {
  void restart() noexcept override { begins_ = true; }

  Relative force(const Motion &m, const PlanarVelocity &hand, const LawSettings &s,
                 double dt) noexcept override {
    const double share = std::exchange(begins_, false) ? 1 : 1 - std::exp(-dt / kResponse);
    return relative_force(gained(m.velocity, frame_, share), gained(hand, hand_, share),
                          kShareForHand * s.most_for_hand, s);
  }

  static PlanarVelocity gained(const PlanarVelocity &now, PlanarVelocity &smooth,
                               double share) noexcept {
    // A value that is not finite must not stay in the memory.
    if (!std::isfinite(now.x + now.y + smooth.x + smooth.y))
      smooth = {};
    smooth.x += share * (now.x - smooth.x);
    smooth.y += share * (now.y - smooth.y);
    return {now.x - smooth.x, now.y - smooth.y};
  }

  static constexpr double kResponse = 0.1; // s
  // The low-pass leaves the slow motion of a hand undamped: at the whole of it a heavy hand without
  // a spring of its own shakes by up to 0.09 N, at three quarters by 0.06 N.
  static constexpr double kShareForHand = 0.5;

  PlanarVelocity frame_; // low-passed
  PlanarVelocity hand_;
  bool begins_ = true; // both from what they are now
};

template <typename Law>
std::unique_ptr<ForceLaw> make() {
  return std::make_unique<Law>();
}

constexpr std::array kLaws = {
    ForceLawInfo{"arctan", "Equation 5 on the speed, along the motion", make<ArctanLaw>},
    ForceLawInfo{"arctan-axis", "Equation 5 on each axis, as printed", make<ArctanAxisLaw>},
    ForceLawInfo{"linear",
                 "In proportion to the speed; the fastest of the last gain-window is max-force",
                 make<LinearLaw>},
    ForceLawInfo{
        "drag",
        "Equation 5 on the motion relative to the hand, as wind does; a hand that goes along "
        "still feels most of it",
        make<DragLaw>},
    ForceLawInfo{"inertial", "Equation 5 on the acceleration relative to the hand, times 0.1 s",
                 make<InertialLaw>},
};

} // namespace

std::span<const ForceLawInfo> force_laws() noexcept {
  return kLaws;
}

// Equation 5 also for rotation and approach: tau = -(2 max_torque / pi) atan(spin / spin_half),
// F_z = (2 max_push / pi) atan(divergence / kDivergenceHalf).
spidar::Wrench ForceLaw::wrench(const Motion &motion, const PlanarVelocity &hand,
                                const LawSettings &settings, double dt) noexcept {
  const auto [planar, of_hand] = force(motion, hand, settings, dt);
  of_hand_ = {of_hand.x, -of_hand.y, 0};
  const double push =
      arctan_gain(motion.divergence, 1 / kDivergenceHalf, settings.max_push) * motion.divergence;
  const double turn =
      arctan_gain(motion.spin, 1 / settings.spin_half, settings.max_torque) * motion.spin;
  // Frame y points down: what turns clockwise on the screen turns negatively about z.
  return {.force = {planar.x, -planar.y, push}, .torque = {0, 0, -turn}};
}

} // namespace haptic
