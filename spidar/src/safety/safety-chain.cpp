// SPDX-License-Identifier: LGPL-2.1-or-later
#include "safety/safety-chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace haptic {
namespace {

using spidar::Vector3;
using spidar::Wrench;

struct FadeTimes {
  std::uint32_t hold;
  double out; // s, from whatever the force is to zero
  double in;  // s, from zero to full
};

constexpr double kFilmFade = 0.1; // s, of a force whose motion is no longer measured

constexpr std::array kFadeTimes = {
    FadeTimes{kHoldClosed, 0, 0.05},        FadeTimes{kHoldPaused, 0.1, 0.05},
    FadeTimes{kHoldFlushing, 0.05, 0.2},    FadeTimes{kHoldEnded, 0.1, 0.2},
    FadeTimes{kHoldReleased, 0.05, 0.5},    FadeTimes{kHoldOverspeed, 0.05, 0.5},
    FadeTimes{kHoldFaulted, 0, 0.5},        FadeTimes{kHoldLate, 0.05, 0.2},
    FadeTimes{kHoldNoPose, 0.05, 0.2},      FadeTimes{kHoldGap, kFilmFade, 0.05},
    FadeTimes{kHoldStale, kFilmFade, 0.05}, FadeTimes{kHoldCut, 0.05, 0.05},
    FadeTimes{kHoldSuspended, 0.05, 0.5},   FadeTimes{kHoldDeadMan, 0.05, 0.2},
    FadeTimes{kHoldSlipped, 0.05, 0.2},     FadeTimes{kHoldShaking, 0.05, 0.5},
};

// These may last for one tick only; the fade must still reach zero.
constexpr std::uint32_t kUntilZero = kHoldFlushing | kHoldLate | kHoldCut;

constexpr double kRounding = 1e-9;    // a share of a force that no limit has taken
constexpr double kGateRelease = 0.1;  // s, time constant
constexpr double kGateNothing = 1e-3; // an exponential never ends by itself
constexpr double kStaleIntervals = 3;
constexpr double kStaleShortest = 0.1; // s
constexpr double kStaleLongest = 2;    // s

// A lowered maximum takes the whole force of the device off within this time, whatever the slew
// rate. A step would be felt as a blow.
constexpr double kMaximumFalls = 0.05; // s; the torque falls as this force at kTorqueArm
// A hand that comes at kUndamped feels this share of the force at once, one at 0.9 m/s 10 ms later.
constexpr double kFeltAtOnce = 0.2;
// The last count of an encoder flickers while the hand rests, and its errors wear a touch out.
// Without a margin a stroke of 0.05 N is gone within 10 s, and with 1 µJ a touch of 0.2 N under
// late ticks. With 5 µJ neither wears out; this is twice as much.
constexpr double kLent = 1e-5; // J per N of max_force
// A law that resists the hand keeps what it may need at the fastest hand, and at this period.
constexpr double kUsualPeriod = 0.001; // s
// The budget for continuous force spares motors and hand over a minute, and has time.
constexpr double kBudgetFalls = 20; // N/s

// Returns the factor of a step of a fall in a straight line that reaches zero in `left` s, which
// becomes less. The tolerance keeps rounding from adding a step.
double factor_of_fade(double &left, double dt) {
  if (left <= dt * (1 + 1e-6))
    return left = 0;
  const double before = std::exchange(left, left - dt);
  return left / before;
}

bool is_finite(const SafetyChain::Input &input) {
  return input.wanted.force.allFinite() && input.wanted.torque.allFinite() &&
         input.of_hand.allFinite() && input.touch.force.allFinite() &&
         std::isfinite(input.touch.surface_work) && std::isfinite(input.touch.hidden_work) &&
         input.touch.carried.value_or(Vector3::Zero()).allFinite() &&
         std::isfinite(input.touch.energy) && std::isfinite(input.touch.released) &&
         input.acted.force.allFinite() && input.acted.torque.allFinite() &&
         input.hand_velocity.allFinite() && input.hand_turning.allFinite() &&
         input.moved.allFinite() && input.turned.allFinite() && std::isfinite(input.trust) &&
         std::isfinite(input.age) && std::isfinite(input.interval) &&
         std::isfinite(input.max_force) && std::isfinite(input.continuous_force) &&
         std::isfinite(input.max_torque) && std::isfinite(input.slew_rate) &&
         std::isfinite(input.damping) && std::isfinite(input.dt) && std::isfinite(input.longest_dt);
}

// J, for a force that nothing was put into yet.
double credit(const SafetyChain::Input &input, const spidar::DeviceLimits &device) {
  const double delay = device.delay * kUsualPeriod; // s
  return kFeltAtOnce * SafetyChain::kUndamped * delay * input.max_force;
}

// The spring to a held thing has some µJ, less than the errors of the measured force and way are
// worth: it is lent more. `fades`: of a touch that has ended the force still acts.
double lent(const SafetyChain::Input &input, const spidar::DeviceLimits &device, bool fades) {
  if (input.touch.carried)
    return credit(input, device);
  return input.touch.energy > 0 || fades ? kLent * input.max_force : 0;
}

// Returns -min(b (|v| - v_0), |F|) v / |v| for |v| > v_0 = kUndamped. Never stronger than the force
// that it damps: without a force nothing runs away.
Vector3 damping_of(const Vector3 &force, const SafetyChain::Input &input) {
  const double speed = input.hand_velocity.norm();
  if (speed <= SafetyChain::kUndamped)
    return Vector3::Zero();
  const double brake = std::min(input.damping * (speed - SafetyChain::kUndamped), force.norm());
  return -brake / speed * input.hand_velocity;
}

// tau' = tau - min(b (|w| - w_0), |tau| + r |F|) w / |w| for |w| > w_0, with the device's brake b
// and calm turn w_0, and r = kTorqueArm: away from the centre a force turns the grip, too. It is
// not slew-limited: a free grip turns up within milliseconds.
Vector3 braked_torque(const Wrench &wrench, const SafetyChain::Input &input,
                      const spidar::DeviceLimits &device) {
  const double speed = input.hand_turning.norm();
  if (speed <= device.calm_turn)
    return wrench.torque;
  const double most = wrench.torque.norm() + SafetyChain::kTorqueArm * wrench.force.norm();
  const double brake = std::min(device.turn_brake * (speed - device.calm_turn), most);
  return clamp_norm(wrench.torque - brake / speed * input.hand_turning,
                    std::max(input.max_torque, wrench.torque.norm()));
}

} // namespace

std::string names_of_holds(std::uint32_t holds) {
  std::string text;
  for (const auto &hold : kHoldNames)
    if (holds & hold.bit)
      text += (text.empty() ? "" : ",") + std::string(hold.name);
  return text;
}

double stale_after(double interval) noexcept {
  return std::clamp(kStaleIntervals * interval, kStaleShortest, kStaleLongest);
}

void SafetyChain::Input::make_certain(double share) noexcept {
  const bool fresh = measured && age <= stale_after(interval);
  share *= fresh ? trust : 0;
  film_has_ended = film_has_ended || !fresh;
  wanted.force *= share;
  wanted.torque *= share;
  of_hand *= share;
  measured = true;
  trust = 1;
}

Wrench SafetyChain::step(const Input &input) noexcept {
  follows_sample_ = false;
  limits_ = 0;
  non_finite_ = !is_finite(input);
  if (non_finite_) {
    silence();
    return braked_;
  }

  const double dt = std::max(input.dt, 0.0);
  std::uint32_t holds = input.holds;
  if (!input.measured)
    holds |= kHoldGap;
  else if (input.age > stale_after(input.interval))
    holds |= kHoldStale;
  if (!silent())
    holds |= holds_ & kUntilZero;
  follows_sample_ = !(holds & (kHoldGap | kHoldStale));

  const double target = input.measured ? input.trust : 0;
  if (target >= gate_)
    gate_ = target;
  else
    gate_ = target + (gate_ - target) * std::exp(-dt / kGateRelease);
  if (gate_ < kGateNothing)
    gate_ = 0;

  account_for_energy(input);
  acting_ = parts_;
  acting_.film.torque = braked_.torque;
  force_limit_ = continuous_force_.step(output_.force.norm(), input.continuous_force, dt);
  limited_ = false;
  if (holds)
    fade_out(holds, dt);
  else
    follow(input);
  const double of_hand = parts_.hand.norm();
  const double longest_dt = std::max(input.longest_dt, dt);
  parts_.hand =
      account_.affordable(parts_.hand, {.velocity = input.hand_velocity,
                                        .moved = input.moved,
                                        .time = dt,
                                        .flicker = (1 - dt / longest_dt) * device_.flicker_way,
                                        .delay = device_.delay * longest_dt,
                                        .credit = credit(input, device_),
                                        .lent = lent_,
                                        .on_its_way = acting_.hand,
                                        .takes = longest_dt});
  note_limit(parts_.hand.norm() < of_hand * (1 - kRounding), kLimitEnergy);
  output_ = {.force = parts_.force(), .torque = parts_.film.torque};
  braked_ = {.force = output_.force, .torque = braked_torque(output_, input, device_)};
  return braked_;
}

void SafetyChain::silence() noexcept {
  envelope_ = 0;
  gate_ = 0;
  accepted_ = {};
  parts_ = {};
  output_ = {};
  braked_ = {};
}

void SafetyChain::restart() noexcept {
  silence();
  holds_ = kHoldGap;
  fade_left_ = 0;
  fade_in_ = std::max(fade_in_, SafetyChain(device_).fade_in_);
}

void SafetyChain::begin_run(double acted) noexcept {
  SafetyChain anew(device_);
  anew.account_ = account_;
  anew.continuous_force_ = continuous_force_;
  anew.continuous_force_.step(output_.force.norm(), acted);
  *this = anew;
}

void SafetyChain::rest(double seconds) noexcept {
  account_for_energy({.dt = seconds});
  continuous_force_.step(0, seconds);
}

// F(t) = F(0) (1 - t / T): scales down the present command, so that the force falls in a straight
// line whatever the law and the samples do meanwhile, and reaches zero after T = fade_left_ also
// where the slew limit is slower.
void SafetyChain::fade_out(std::uint32_t holds, double dt) noexcept {
  if (!holds_) {
    fade_left_ = kStaleLongest;
    if (envelope_ >= 1)
      fade_in_ = 0; // else an interrupted fade-in keeps its slowness
  }
  for (const auto &times : kFadeTimes) {
    if (!(holds & times.hold))
      continue;
    if (!(holds_ & times.hold))
      fade_left_ = std::min(fade_left_, times.out);
    fade_in_ = std::max(fade_in_, times.in);
  }
  holds_ = holds;
  note_limit(true, kLimitFade);

  const double factor = factor_of_fade(fade_left_, dt);
  if (factor == 0)
    return silence();
  envelope_ *= factor;
  parts_.film.force *= factor;
  parts_.film.torque *= factor;
  parts_.hand *= factor;
}

// The device sends a command at the next exchange, and it acts until the one after that.
void SafetyChain::account_for_energy(const Input &input) noexcept {
  lent_ = lent(input, device_, accepted_.hand.isZero(0) && !parts_.hand.isZero(0));
  const double most_for_law = device_.let_go_speed * device_.delay * kUsualPeriod; // J per N
  const double of_law = accepted_.hand.isZero(0) ? 0 : most_for_law * input.max_force;
  // Of a touch that has ended the force still acts, with its energy.
  double fading = 0;
  if (!parts_.hand.isZero(0))
    fading = parts_.hand.squaredNorm() / (2 * device_.stiffest_spring(kUsualPeriod));
  account_.charge({.acted = input.acted,
                   .film = acting_.film,
                   .by_hand = !acting_.hand.isZero(0),
                   .moved = input.moved,
                   .turned = input.turned,
                   .trickle = device_.flicker * input.max_force,
                   .surface_work = input.touch.surface_work,
                   .hidden_work = input.touch.hidden_work,
                   .carried = input.touch.carried.value_or(Vector3::Zero()),
                   .most = std::min(std::max(input.touch.energy, fading) + of_law + lent_,
                                    device_.most_for_hand() * input.max_force),
                   .limits_film = input.limits_work,
                   .time = input.dt});
}

// Returns whether it had to.
bool SafetyChain::Parts::limit_force(double limit) noexcept {
  const double norm = force().norm();
  if (norm <= limit)
    return false;
  film.force *= limit / norm;
  hand *= limit / norm;
  return true;
}

// At most so many N, each part and both together; `released` more where the hand's part falls. A
// film's part that has ended goes first.
void SafetyChain::approach(const Parts &wanted, double step, const Input &input) noexcept {
  const bool falls = wanted.hand.norm() < parts_.hand.norm();
  const double most = falls ? step + input.touch.released : step;
  const Vector3 film = clamp_norm(wanted.film.force - parts_.film.force, step);
  Vector3 hand = clamp_norm(wanted.hand - parts_.hand, most);
  if (input.film_has_ended)
    hand = clamp_norm(hand, std::max(most - film.norm(), 0.0));
  const double both = (film + hand).norm();
  const double share = both > most ? most / both : 1;
  parts_.film.force += share * film;
  parts_.hand += share * hand;
}

void SafetyChain::follow(const Input &input) noexcept {
  holds_ = 0;
  const double dt = std::max(input.dt, 0.0);
  envelope_ = fade_in_ > 0 ? std::min(envelope_ + dt / fade_in_, 1.0) : 1.0;

  // A measurement not worth trusting must not turn the force on its way to zero.
  if (input.trust > 0) {
    accepted_ = {.film = input.wanted, .hand = input.of_hand};
    accepted_.film.force -= input.of_hand;
  }
  const double share = gate_ * envelope_;
  Parts wanted = accepted_;
  wanted.hand += input.touch.force;
  note_limit(wanted.limit_force(input.max_force), kLimitForce);
  note_limit(accepted_.film.torque.norm() > input.max_torque, kLimitTorque);
  note_limit(gate_ < 1, kLimitConfidence);
  note_limit(envelope_ < 1, kLimitFade);
  wanted.film.force *= share;
  wanted.hand *= share;
  wanted.film.torque = clamp_norm(accepted_.film.torque, input.max_torque) * share;
  limited_ = wanted.limit_force(force_limit_);
  note_limit(limited_, kLimitBudget);
  (wanted.hand.isZero(0) ? wanted.film.force : wanted.hand) += damping_of(wanted.force(), input);

  const double step = input.slew_rate * dt;
  const double fall = std::max(input.slew_rate * dt, device_.force / kMaximumFalls * dt);
  const double budget_fall = std::max(input.slew_rate, kBudgetFalls) * dt;
  const double before = output_.force.norm();
  const double most = std::min(std::max(input.max_force, before - fall),
                               std::max(force_limit_, before - budget_fall));
  const Wrench film = parts_.film; // before
  approach(wanted, step, input);
  note_limit((wanted.force() - parts_.force()).norm() > kRounding * input.max_force, kLimitSlew);
  note_limit(parts_.limit_force(most), kLimitForce);
  Vector3 &torque = parts_.film.torque;
  const double torque_limit = std::max(input.max_torque, torque.norm() - fall * kTorqueArm);
  torque += clamp_norm(wanted.film.torque - torque, step * kTorqueArm);
  torque = clamp_norm(torque, torque_limit);

  if (!input.film_has_ended) {
    film_left_ = kFilmFade;
  } else { // where the slew rate is slower
    const double kept = factor_of_fade(film_left_, dt);
    parts_.film.force = clamp_norm(parts_.film.force, kept * film.force.norm());
    torque = clamp_norm(torque, kept * film.torque.norm());
  }

  // The slew rate does not delay this limit: a carried hand uses up the work within milliseconds.
  const double left = input.limits_work ? account_.share_of_film() : 1;
  note_limit(parts_.limit_force(std::max(input.max_force, parts_.force().norm()) * left),
             kLimitWork);
  torque = clamp_norm(torque, std::max(input.max_torque, torque.norm()) * left);
}

} // namespace haptic
