// SPDX-License-Identifier: LGPL-2.1-or-later
// A string that slips is noticed, and a unit that is not quite its geometry is not taken for one.
#include "spidar-poses.hpp"
#include "spidar/device.hpp"

#include <cstdlib>
#include <gtest/gtest.h>

namespace spidar_slip_test {

using namespace spidar;
using namespace spidar_test;

constexpr std::int64_t kMs = 1'000'000; // ns

/// How far a unit is from its geometry.
struct Faults {
  double motors = 0; ///< m
  double drums = 0;  ///< of the metres per count
  double centre = 0; ///< m, the grip at the calibration; and so many degrees for each mm
};

/// A grip that goes where a test wants it, on a unit with faults, and strings that slip.
class Unit final : public Controller {
public:
  Unit(const Geometry &geometry, const Faults &faults, Random &random) : true_(geometry) {
    for (std::size_t i = 0; i < kStrings; ++i) {
      true_.motors[i] += random.between(0, faults.motors) * random.direction();
      true_.metres_per_count[i] *= 1 + random.between(-faults.drums, faults.drums);
    }
    grip = {random.between(0, faults.centre) * random.direction(),
            turn(random.direction(), random.between(0, 1000 * faults.centre * kDegree))};
  }

  Pose grip;
  std::array<double, kStrings> slip{}; ///< m

  bool exchange(const DacWords &, Counts &counts) noexcept override { return home(counts); }
  bool home(Counts &counts) const noexcept override {
    const StringLengths lengths = string_lengths(true_, grip);
    for (std::size_t i = 0; i < kStrings; ++i)
      counts[i] = static_cast<std::int32_t>(std::lround(
          (lengths[static_cast<Eigen::Index>(i)] + slip[i]) / true_.metres_per_count[i]));
    return true;
  }
  std::string description() const override { return "a unit with faults"; }

private:
  Geometry true_;
};

/// A device on such a unit, and a hand that wanders from place to place.
class Wandering {
public:
  Wandering(const Geometry &geometry, const Faults &faults, Random &random)
      : random_(random), place_(random.pose(0.025, 20 * kDegree)) {
    auto unit = std::make_unique<Unit>(geometry, faults, random);
    unit_ = unit.get();
    device_ = std::make_unique<Device>(std::move(unit), geometry);
    tick();
  }

  double speed = 0; ///< m/s; turns at 10 rad/s for each

  void stay_within(double half, double tilt) {
    half_ = half;
    tilt_ = tilt;
    place_ = random_.pose(half, tilt);
  }
  void tick() {
    move();
    device_->exchange(now_ += kMs);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i)
      tick();
  }
  Unit &unit() { return *unit_; }
  const DeviceState &state() const { return device_->state(); }
  void calibrate() { device_->calibrate(); }

private:
  void move() {
    Pose &grip = unit_->grip;
    const Vector3 left = place_.position - grip.position;
    const Eigen::AngleAxisd turned_by(Matrix3(place_.rotation * grip.rotation.transpose()));
    if (left.norm() < 1e-6 && turned_by.angle() < 1e-6)
      place_ = random_.pose(half_, tilt_);
    grip.position += std::min(1.0, 1e-3 * speed / std::max(left.norm(), 1e-12)) * left;
    grip.rotation =
        turn(turned_by.axis(), std::min(turned_by.angle(), 0.01 * speed)) * grip.rotation;
  }

  Random &random_;
  double half_ = 0.025;        // m
  double tilt_ = 20 * kDegree; // rad
  Pose place_;
  Unit *unit_ = nullptr;
  std::unique_ptr<Device> device_;
  std::int64_t now_ = 0; // ns
};

struct Slip {
  std::size_t string;
  double size; ///< m
  int ticks;   ///< for the first 3 mm of it
};

constexpr double kCounts = 0.003; // m, from which on a slip must be noticed
constexpr int kNoticed = 10;      // ms; the force then begins to fade

bool is_noticed(const DeviceState &state) {
  return state.slipping || !state.valid;
}

/// Lets a string slip. True if that is noticed in time.
bool notices(Wandering &hand, const Slip &slip) {
  double &there = hand.unit().slip[slip.string];
  const double step = std::copysign(kCounts / slip.ticks, slip.size);
  for (int tick = 1; tick < slip.ticks + kNoticed; ++tick) {
    there = tick < slip.ticks ? tick * step : slip.size;
    hand.tick();
    if (is_noticed(hand.state()))
      return true;
  }
  return false;
}

/// To a place within 15 mm and 10 degrees, where the hand stays.
void take_somewhere_near(Wandering &hand) {
  hand.stay_within(0.015, 10 * kDegree);
  hand.speed = 0.3;
  hand.run(100);
  hand.speed = 0;
  hand.run(300);
}

/// A hand on a unit that the device knows from 3 m of way.
std::unique_ptr<Wandering> well_known(const Geometry &geometry, Random &random) {
  auto hand = std::make_unique<Wandering>(geometry, Faults{}, random);
  hand->speed = 1;
  hand->run(3000);
  return hand;
}

/// The share of slips that are not noticed in time, under a hand of this speed (m/s).
double missed(const std::string &name, double speed, double half, double tilt, unsigned seed = 7) {
  const Geometry geometry = load_geometry(name);
  Random random(seed);
  auto hand = well_known(geometry, random);
  int missed = 0;
  int count = 0;
  for (std::size_t string = 0; string < kStrings; ++string) {
    for (const double size : {0.003, -0.003, 0.010, -0.030}) {
      for (const int ticks : {1, 30, 300}) {
        hand->unit().slip = {};
        hand->stay_within(half, tilt);
        hand->speed = 1;
        hand->run(150);                  // to a place there
        if (is_noticed(hand->state())) { // a centimetre that came back is no way either
          hand = well_known(geometry, random);
          hand->stay_within(half, tilt);
          hand->run(150);
        }
        hand->speed = speed;
        hand->run(100);
        EXPECT_FALSE(is_noticed(hand->state()));
        ++count;
        if (!notices(*hand, {string, size, ticks})) {
          ++missed;
          hand = well_known(geometry, random); // the device took it for a fault of the unit
        }
      }
    }
  }
  return static_cast<double>(missed) / count;
}

class SlipOn : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Builtin, SlipOn, testing::ValuesIn(builtin_geometries()),
                         [](const auto &test) {
                           return test.param.substr(test.param.find('-') + 1);
                         });

TEST_P(SlipOn, IsAlwaysNoticedWithin15MillimetresAnd10Degrees) {
  for (const double speed : {0.0, 0.3, 1.0})
    EXPECT_EQ(missed(GetParam(), speed, 0.015, 10 * kDegree), 0) << speed << " m/s";
}

TEST_P(SlipOn, IsNearlyAlwaysNoticedInTheWholeWorkspace) {
  // 96 slips alone would leave it to chance: 2 % are missed under the fastest hand.
  constexpr int kHands = 4;
  for (const double speed : {0.0, 0.3, 1.0}) {
    double share = 0;
    for (unsigned seed = 7; seed < 7 + kHands; ++seed)
      share += missed(GetParam(), speed, 0.025, 20 * kDegree, seed) / kHands;
    EXPECT_LE(share, 0.04) << speed << " m/s";
  }
}

TEST_P(SlipOn, IsNoticedRightAfterACalibrationUnderAHandThatIsStill) {
  const Geometry geometry = load_geometry(GetParam());
  Random random(8);
  for (std::size_t string = 0; string < kStrings; ++string) {
    for (const double size : {0.003, -0.003, 0.010, -0.030}) {
      for (const int ticks : {1, 30}) {
        Wandering hand(geometry, {}, random);
        take_somewhere_near(hand);
        ASSERT_FALSE(hand.state().slipping);
        ASSERT_TRUE(notices(hand, {string, size, ticks})) << string << ": " << size;
      }
    }
  }
}

TEST_P(SlipOn, IsNotSeenOnAUnitThatDiffersFromItsGeometry) {
  const Geometry geometry = load_geometry(GetParam());
  const char *wanted = std::getenv("SLIP_TICKS"); // 1000000 is what is promised
  const int ticks = (wanted ? std::atoi(wanted) : 60'000) / 30;
  Random random(9);
  for (int unit = 0; unit < 30; ++unit) {
    Wandering hand(geometry, {.motors = 0.001, .drums = 0.005}, random);
    hand.speed = unit % 3 == 0 ? 0.1 : unit % 3 == 1 ? 0.4 : 1;
    for (int tick = 0; tick < ticks; ++tick) {
      hand.tick();
      ASSERT_FALSE(hand.state().slipping) << unit << ", " << tick << " ms";
    }
  }
}

TEST_P(SlipOn, IsNotLatchedOnAUnitThatWasCalibratedOffTheCentre) {
  const Geometry geometry = load_geometry(GetParam());
  Random random(10);
  for (int unit = 0; unit < 30; ++unit) {
    Wandering hand(geometry, {.motors = 0.001, .drums = 0.005, .centre = 0.003}, random);
    hand.speed = unit % 3 == 0 ? 0.1 : unit % 3 == 1 ? 0.4 : 1;
    hand.run(2000);
    ASSERT_FALSE(hand.state().slipped) << unit;
  }
}

TEST(Slip, IsLatchedAfter200MillisecondsUntilACalibration) {
  Random random(11);
  Wandering hand(load_geometry(kDefaultGeometry), {}, random);
  const auto slip = [&](double size, int ticks) {
    hand.unit().slip[2] = size;
    hand.run(ticks);
  };
  hand.run(300);
  slip(0.005, 100);
  EXPECT_TRUE(hand.state().slipping);
  EXPECT_FALSE(hand.state().slipped);
  slip(0, 300);
  EXPECT_FALSE(hand.state().slipping);
  EXPECT_FALSE(hand.state().slipped);
  slip(0.005, 210);
  EXPECT_TRUE(hand.state().slipped);
  slip(0, 300);
  EXPECT_FALSE(hand.state().slipping);
  EXPECT_TRUE(hand.state().slipped);
  hand.calibrate();
  EXPECT_FALSE(hand.state().slipped);
  hand.run(300);
  EXPECT_FALSE(hand.state().slipping);
}

TEST(Slip, OfCentimetresIsLatchedToo) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Random random(12);
  for (std::size_t string = 0; string < kStrings; ++string) {
    for (const double size : {-0.03, 0.03, 0.05}) {
      Wandering hand(geometry, {}, random);
      take_somewhere_near(hand);
      hand.unit().slip[string] = size;
      hand.run(1);
      EXPECT_TRUE(is_noticed(hand.state())) << string << ": " << size;
      hand.run(210);
      EXPECT_TRUE(hand.state().slipped) << string << ": " << size;
    }
  }
}

} // namespace spidar_slip_test
