// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop with a hand on its device, in virtual time: the film and the surface that it feels, and
// ticks as the thread of the loop makes them on a machine that is on time or late.
#pragma once

#include "hand-on-arm.hpp"
#include "hand-on-strings.hpp"
#include "loop/haptic-loop.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <spidar/device.hpp>
#include <string>
#include <utility>

namespace test {

/// Read from one file each, once.
inline const spidar::Geometry &builtin_geometry(const std::string &name) {
  static const std::map<std::string, spidar::Geometry> geometries = [] {
    std::map<std::string, spidar::Geometry> all;
    for (const std::string &each : spidar::builtin_geometries())
      all.emplace(each, spidar::load_geometry(each));
    return all;
  }();
  return geometries.at(name);
}

/// When ticks come.
struct Pace {
  double rate = 1000;  ///< Hz, of the loop
  double every = 0;    ///< ms that each tick takes; 0: none
  double late = 0;     ///< ms by which one tick in ten is late at most
  bool uneven = false; ///< between one and two periods apart
};

/// The ticks at a pace, as the thread of the loop makes them.
class Ticks {
public:
  explicit Ticks(const Pace &pace) : pace_(pace), period_(std::llround(1e9 / pace.rate)) {}

  /// The next one, and so many ms later than at the pace.
  void next(double later = 0) {
    // Of the periods that are past, the last one is made up for at once.
    due_ += std::max<std::int64_t>((now_ - due_) / period_, 1) * period_;
    std::int64_t when = std::max(due_, now_ + nanoseconds(std::max(pace_.every, kShortest)));
    if (pace_.uneven)
      when = now_ + period_ + static_cast<std::int64_t>(random_() % period_);
    if (pace_.late > 0 && random_() % 10 == 0)
      when = std::max(when, due_ + static_cast<std::int64_t>(random_() % nanoseconds(pace_.late)));
    now_ = when + nanoseconds(later);
  }
  std::int64_t now() const noexcept { return now_; }     ///< ns, monotonic
  std::int64_t due() const noexcept { return due_; }     ///< ns, when this tick was meant to come
  double time() const noexcept { return seconds(now_); } ///< s
  /// The same at so many ns.
  static double seconds(std::int64_t time) { return static_cast<double>(time - kBegin) * 1e-9; }

private:
  static constexpr std::int64_t kBegin = 1'000'000'000; // ns
  static constexpr double kShortest = 0.05;             // ms that a tick takes

  static std::int64_t nanoseconds(double ms) { return std::llround(ms * 1e6); }

  Pace pace_;
  std::int64_t period_;       // ns
  std::int64_t now_ = kBegin; // ns
  std::int64_t due_ = kBegin; // ns
  std::mt19937 random_{7};    // the late ones
};

/// In the place of a geometry: the arm.
inline constexpr const char *kArmName = "arm";

class LoopInHand {
public:
  struct Setup {
    std::string geometry = spidar::kDefaultGeometry; ///< of strings, or kArmName
    Hand hand = {};
    spidar::Vector3 start = spidar::Vector3::Zero(); ///< m
    Pace pace = {};
    haptic::LoopSettings settings = {};
    bool dead_man = false;
    bool bounds_hand = true;   ///< HapticLoop::Environment
    bool pulls_at_rest = true; ///< the strings have minimum tension, which pulls off the centre
  };

  static constexpr std::int64_t kMs = 1'000'000; // ns

  explicit LoopInHand(const Setup &setup) : settings(setup.settings), ticks_(setup.pace) {
    if (setup.geometry == kArmName)
      take_arm(setup);
    else
      take_strings(setup);
    loop.prepare({.device = device_.get(),
                  .rate = setup.pace.rate,
                  .dead_man = setup.dead_man,
                  .bounds_hand = setup.bounds_hand});
    loop.set_settings(settings);
    loop.unhold(haptic::kHoldClosed | haptic::kHoldPaused | haptic::kLatches);
  }
  ~LoopInHand() {
    loop.prepare({}); // gives the reliefs back to their pool
    loop.tick(ticks_.now(), ticks_.now());
  }
  LoopInHand(const LoopInHand &) = delete;
  LoopInHand &operator=(const LoopInHand &) = delete;

  // What the hand feels. The film and the surface have a frame each `frame`.

  spidar::Vector3 film = spidar::Vector3::Zero(); ///< px/s, x to the right, y down; z unused
  std::optional<haptic::ReliefCell> surface;      ///< a level one
  std::int64_t frame = 33 * kMs;                  ///< ns
  /// m, where a held thing is seen at a time (s); null: nothing is held
  std::function<spidar::Vector3(double)> thing;
  haptic::HoldState hold = haptic::HoldState::held; ///< of the thing
  float confidence = 1;                             ///< of the motion
  std::int64_t ahead = 0;        ///< ns by which frames come early; 0: they are felt at once
  haptic::LoopSettings settings; ///< hand them over with set()
  void set() { loop.set_settings(settings); }

  /// The next frame shows another thing, taken then.
  void take_anew() noexcept { taken_.reset(); }

  void wait(double seconds) {
    for (const double end = time() + seconds; time() < end;)
      tick();
  }
  /// The hand moves its target there; so many m/s.
  void lead(const spidar::Vector3 &goal, double speed) {
    hand_->goal = goal;
    hand_->speed = speed;
    while (hand_->target != goal)
      tick();
  }
  /// The next tick at the pace, and so many ms later.
  void tick(double later = 0) {
    const double before = time();
    ticks_.next(later);
    if (thing)
      work_of_thing_ += hand_->wrench().force.dot(thing(time()) - thing(before));
    show(ticks_.now());
    loop.tick(ticks_.due(), ticks_.now());
  }

  double time() const noexcept { return ticks_.time(); }                 ///< s
  spidar::Vector3 force() const noexcept { return loop.wrench().force; } ///< N, as commanded
  HeldGrip &hand() noexcept { return *hand_; }
  HandOnStrings &on_strings() noexcept { return *on_strings_; } ///< not on the arm
  /// J, that the held thing has done on the strings by its own way.
  double work_of_thing() const noexcept { return work_of_thing_; }
  const spidar::HapticDevice &device() const noexcept { return *device_; }

private:
  void take_arm(const Setup &setup) {
    auto on_arm = std::make_unique<HandOnArm>(setup.hand, setup.start, 1 / setup.pace.rate);
    hand_ = on_arm.get();
    device_ = std::move(on_arm);
  }
  void take_strings(const Setup &setup) {
    spidar::Geometry geometry = builtin_geometry(setup.geometry);
    if (!setup.pulls_at_rest)
      geometry.tension_min = 0.001; // N
    auto on_strings = std::make_unique<HandOnStrings>(geometry, setup.hand, setup.start);
    hand_ = on_strings_ = on_strings.get();
    device_ =
        std::make_unique<spidar::Device>(std::move(on_strings), geometry, 1 / setup.pace.rate);
  }

  void show(std::int64_t now) {
    if (now - shown_ < frame)
      return;
    shown_ = now;
    haptic::MotionSample sample;
    sample.velocity_x = static_cast<float>(film.x());
    sample.velocity_y = static_cast<float>(film.y());
    sample.confidence = confidence;
    sample.interval = static_cast<std::uint64_t>(frame);
    sample.frame_width = static_cast<std::uint32_t>(haptic::kReferenceWidth);
    sample.frame_height = static_cast<std::uint32_t>(haptic::kReferenceHeight);
    const std::int64_t seen = now + ahead; // ns
    if (thing)
      hold_thing(sample, seen);
    loop.submit(
        haptic::TimedMotion{sample, confidence > 0, ahead > 0 ? seen - frame / 2 : haptic::kAtOnce},
        now);
    if (!surface)
      return;
    haptic::ReliefPool::Field relief = reliefs_->acquire();
    relief->frame_width = sample.frame_width;
    relief->frame_height = sample.frame_height;
    relief->columns = relief->rows = 2;
    relief->interval = sample.interval;
    relief->cells.assign(4, *surface);
    loop.submit(haptic::TimedRelief{std::move(relief)});
  }

  void hold_thing(haptic::MotionSample &sample, std::int64_t seen) {
    if (!taken_)
      taken_ = seen;
    const spidar::Vector3 place = thing(Ticks::seconds(seen));
    const spidar::Vector3 &half = device_->workspace_half();
    sample.held = {.state = hold,
                   .x = static_cast<float>(0.5 + place.x() / (2 * half.x())),
                   .y = static_cast<float>(0.5 - place.y() / (2 * half.y())),
                   .radius = 0.05F,
                   .time = static_cast<std::uint64_t>(seen - *taken_)};
  }

  Ticks ticks_;
  std::optional<std::int64_t> taken_; // ns, the thing
  double work_of_thing_ = 0;          // J
  std::int64_t shown_ = 0;            // ns, the last frame
  std::unique_ptr<haptic::ReliefPool> reliefs_ = std::make_unique<haptic::ReliefPool>();
  std::unique_ptr<spidar::HapticDevice> device_;
  HeldGrip *hand_ = nullptr;            // of the device
  HandOnStrings *on_strings_ = nullptr; // the same; null on the arm

public:
  haptic::HapticLoop loop; ///< last: it uses the others
};

} // namespace test
