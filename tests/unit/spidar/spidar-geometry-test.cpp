// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/error.hpp"
#include "spidar/geometry.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <sstream>
#include <sys/stat.h>

namespace spidar_geometry_test {

using namespace spidar;

namespace fs = std::filesystem;

std::string as_file(const Geometry &geometry) {
  std::ostringstream text;
  text.precision(17);
  const auto vector = [&](const char *key, const Vector3 &v) {
    text << key << '=' << v.x() << ';' << v.y() << ';' << v.z() << '\n';
  };
  text << "[device]\ndigits-per-volt=" << geometry.digits_per_volt
       << "\ndac-limit=" << geometry.dac_limit << "\ntension-min=" << geometry.tension_min
       << "\ntension-max=" << geometry.tension_max << "\ngrip-radius=" << geometry.grip_radius
       << '\n';
  vector("workspace-half", geometry.workspace_half);
  for (std::size_t i = 0; i < kStrings; ++i) {
    text << "[string-" << i << "]\n";
    vector("motor", geometry.motors[i]);
    vector("attachment", geometry.attachments[i]);
    text << "metres-per-count=" << geometry.metres_per_count[i]
         << "\nvolts-per-newton=" << geometry.volts_per_newton[i] << '\n';
  }
  return text.str();
}

/// A directory of its own that goes with the test.
class GeometryFile : public testing::Test {
protected:
  GeometryFile() {
    std::string pattern = (fs::temp_directory_path() / "spidar-geometry-XXXXXX").string();
    directory_ = mkdtemp(pattern.data());
  }
  ~GeometryFile() override { fs::remove_all(directory_); }

  fs::path write(const std::string &name, const std::string &text) const {
    const fs::path path = directory_ / name;
    std::ofstream(path) << text;
    return path;
  }

  /// The message with which load_geometry() refuses `text`, after checking file name and cause.
  std::string refusal(const std::string &text) const {
    const fs::path path = write("unit.ini", text);
    try {
      load_geometry(path.string());
    } catch (const Error &error) {
      EXPECT_EQ(error.cause(), Cause::geometry) << error.what();
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
      return error.what();
    }
    return "accepted";
  }

  fs::path directory_;
};

std::string replaced(std::string text, const std::string &from, const std::string &to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// Motors in the corners of a box: the order of signs is that of the frames in the table.
Geometry with_strings(const std::array<Vector3, kStrings> &motors,
                      const std::array<Vector3, kStrings> &attachments) {
  Geometry geometry = load_geometry(kDefaultGeometry);
  geometry.name = "test";
  geometry.motors = motors;
  geometry.attachments = attachments;
  return geometry;
}

Geometry finger_grip_6x3f() {
  constexpr double x = 0.060, y = 0.073, z = 0.060, r = 0.016;
  return with_strings({{{-x, -y, -z},
                        {x, -y, -z},
                        {x, -y, z},
                        {-x, -y, z},
                        {-x, y, -z},
                        {x, y, -z},
                        {x, y, z},
                        {-x, y, z}}},
                      {{{-r, 0, 0},
                        {0, 0, -r},
                        {r, 0, 0},
                        {0, 0, r},
                        {-r, 0, 0},
                        {0, 0, -r},
                        {r, 0, 0},
                        {0, 0, r}}});
}

Geometry printed_2021_6x4() {
  constexpr double x = 0.069, y = 0.095, z = 0.069, r = 0.0225;
  return with_strings({{{x, -y, z},
                        {x, -y, -z},
                        {-x, -y, -z},
                        {-x, -y, z},
                        {x, y, z},
                        {x, y, -z},
                        {-x, y, -z},
                        {-x, y, z}}},
                      {{{0, -r, 0},
                        {0, -r, 0},
                        {r, 0, 0},
                        {-r, 0, 0},
                        {0, r, 0},
                        {0, r, 0},
                        {r, 0, 0},
                        {-r, 0, 0}}});
}

TEST(BuiltinGeometries, AllLoadAndPullInEveryDirection) {
  const std::vector<std::string> names = builtin_geometries();
  ASSERT_EQ(names.size(), 4U);
  for (const std::string &name : names) {
    const Geometry geometry = load_geometry(name);
    EXPECT_EQ(geometry.name, name);
    EXPECT_EQ(unreachable_directions(geometry), "") << name;
    EXPECT_EQ(geometry.tension_min, 0.3) << name;
    EXPECT_EQ(geometry.tension_max, 5.0) << name;
    EXPECT_EQ(geometry.workspace_half, Vector3::Constant(0.025)) << name;
  }
}

// Lengths and counts of the reference table. Mirroring z must not change them.
TEST(BuiltinGeometries, HomeLengthsAreThoseOfTheTable) {
  const auto lengths_mm = [](const char *name) {
    return StringLengths(1000 * string_lengths(load_geometry(name), {}));
  };
  StringLengths g6x3;
  g6x3 << 103.8376, 103.8376, 100.3108, 100.3108, 103.8376, 103.8376, 100.3108, 100.3108;
  StringLengths g6x4;
  g6x4 << 121.5658, 126.2864, 126.2864, 121.5658, 121.5658, 126.2864, 126.2864, 121.5658;
  StringLengths g6x5;
  g6x5 << 123.7528, 123.7528, 124.2367, 124.2367, 123.7528, 123.7528, 124.2367, 124.2367;
  constexpr double kPrinted = 2e-4; // mm
  EXPECT_LT((lengths_mm("spidar-g6x3r") - g6x3).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_LT((lengths_mm("spidar-g6x3l") - g6x3).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_LT((lengths_mm("spidar-g6x4") - g6x4).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_LT((lengths_mm("spidar-g6x5r") - g6x5).cwiseAbs().maxCoeff(), kPrinted);
}

TEST(BuiltinGeometries, CountsAtHomeHaveTheSignsOfTheTable) {
  const Geometry geometry = load_geometry("spidar-g6x3r");
  const StringLengths lengths = string_lengths(geometry, {});
  const double expected[] = {6234, 6234, -6022, -6022, -6234, -6234, 6022, 6022};
  for (std::size_t i = 0; i < kStrings; ++i)
    EXPECT_EQ(std::trunc(lengths[i] / geometry.metres_per_count[i]), expected[i]) << i;
}

// In the table motor 1 is at +z, which is away from the user there, and motor 3 at -z.
TEST(BuiltinGeometries, ZPointsTowardsTheUser) {
  const Geometry geometry = load_geometry("spidar-g6x3r");
  EXPECT_NEAR(geometry.motors[1].z(), -0.084853, 1e-9);
  EXPECT_NEAR(geometry.motors[3].z(), +0.084853, 1e-9);
}

TEST(WrenchClosure, NamesTheTurnThatNoStringMakes) {
  // Mirrored with z, the turn about +y that all eight strings make becomes one about -y.
  EXPECT_EQ(unreachable_directions(finger_grip_6x3f()), "turn about +y");
  EXPECT_NE(unreachable_directions(printed_2021_6x4()).find("turn about"), std::string::npos);
  EXPECT_EQ(unreachable_directions(printed_2021_6x4()).find("pull"), std::string::npos);
}

TEST(WrenchClosure, NamesBothTurnsWhenAllStringsMeetInOnePoint) {
  Geometry geometry = load_geometry("spidar-g6x3r");
  geometry.attachments.fill(Vector3::Zero());
  EXPECT_EQ(unreachable_directions(geometry),
            "turn about +x, turn about -x, turn about +y, turn about -y, turn about +z, turn about "
            "-z");
}

TEST(WrenchClosure, NamesThePullWhenAllMotorsAreOnOneSide) {
  Geometry geometry = load_geometry("spidar-g6x3r");
  for (std::size_t i = 0; i < kStrings; ++i) {
    geometry.motors[i].x() += 0.2;
    geometry.attachments[i].x() = 0;
  }
  EXPECT_NE(unreachable_directions(geometry).find("pull along -x"), std::string::npos);
  EXPECT_EQ(unreachable_directions(geometry).find("pull along +x"), std::string::npos);
}

TEST_F(GeometryFile, ReadsBackWhatWasWritten) {
  Geometry written = load_geometry("spidar-g6x3l");
  written.tension_max = 4.25;
  const Geometry read = load_geometry(write("mine.ini", as_file(written)).string());
  EXPECT_EQ(read.name, "mine");
  EXPECT_EQ(read.motors, written.motors);
  EXPECT_EQ(read.attachments, written.attachments);
  EXPECT_EQ(read.metres_per_count, written.metres_per_count);
  EXPECT_EQ(read.volts_per_newton, written.volts_per_newton);
  EXPECT_EQ(read.tension_max, 4.25);
}

TEST_F(GeometryFile, ANameIsFoundInTheSearchPathBeforeTheBuiltinOnes) {
  const std::string before =
      std::getenv("SPIDAR_GEOMETRY_PATH") != nullptr ? std::getenv("SPIDAR_GEOMETRY_PATH") : "";
  Geometry measured = load_geometry("spidar-g6x3r");
  measured.tension_max = 3;
  write("spidar-g6x3r.ini", as_file(measured));
  setenv("SPIDAR_GEOMETRY_PATH", ("/nowhere:" + directory_.string()).c_str(), 1);
  const Geometry found = load_geometry("spidar-g6x3r");
  setenv("SPIDAR_GEOMETRY_PATH", before.c_str(), 1);
  EXPECT_EQ(found.tension_max, 3);
}

TEST_F(GeometryFile, AnUnknownNameListsTheKnownOnes) {
  try {
    load_geometry("spidar-x");
    FAIL();
  } catch (const Error &error) {
    EXPECT_EQ(error.cause(), Cause::not_found);
    EXPECT_NE(std::string(error.what()).find("spidar-g6x3r"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("SPIDAR_GEOMETRY_PATH"), std::string::npos);
  }
}

TEST_F(GeometryFile, AMissingFileIsNotFound) {
  const std::string path = (directory_ / "none.ini").string();
  try {
    load_geometry(path);
    FAIL();
  } catch (const Error &error) {
    EXPECT_EQ(error.cause(), Cause::not_found);
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
  }
}

TEST_F(GeometryFile, AFifoIsRefusedAndNotWaitedFor) {
  const std::string fifo = (directory_ / "fifo.ini").string();
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THROW(load_geometry(fifo), Error);
}

TEST_F(GeometryFile, WhatIsNoKeyFileIsRefused) {
  EXPECT_NE(refusal("hello"), "accepted");
  EXPECT_NE(refusal(""), "accepted");
  EXPECT_NE(refusal(std::string("[device]\n\xff\xfe\x00=1", 15)), "accepted");
}

TEST_F(GeometryFile, EveryKeyIsNeeded) {
  const std::string whole = as_file(load_geometry(kDefaultGeometry));
  std::istringstream lines(whole);
  int tried = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos)
      continue;
    const std::string message = refusal(replaced(whole, line + "\n", ""));
    EXPECT_NE(message.find(line.substr(0, equals) + " is missing"), std::string::npos) << message;
    ++tried;
  }
  EXPECT_EQ(tried, 6 + 8 * 4);
}

TEST_F(GeometryFile, TheButtonIsNamedByPinAndLevelTogetherOrNotAtAll) {
  const std::string whole = as_file(load_geometry(kDefaultGeometry));
  EXPECT_FALSE(load_geometry(write("unit.ini", whole)).button);
  const auto with = [&](const std::string &keys) {
    return replaced(whole, "[device]\n", "[device]\n" + keys);
  };
  const Geometry named = load_geometry(write("unit.ini", with("button-bit=3\nbutton-pressed=0\n")));
  ASSERT_TRUE(named.button);
  EXPECT_TRUE(named.button->is_pressed(0x7));
  EXPECT_FALSE(named.button->is_pressed(0x8));
  for (const auto &[keys, reason] :
       {std::pair{"button-bit=1\n", "button-pressed is missing"},
        {"button-pressed=1\n", "button-bit is missing"},
        {"button-bit=4\nbutton-pressed=1\n", "button-bit must be a whole number from 0 to 3"},
        {"button-bit=0\nbutton-pressed=0.5\n", "button-pressed must be a whole number"}})
    EXPECT_NE(refusal(with(keys)).find(reason), std::string::npos) << keys;
}

TEST_F(GeometryFile, AMisspeltKeyIsRefused) {
  const std::string whole = as_file(load_geometry(kDefaultGeometry));
  EXPECT_NE(refusal(whole + "tension-max=1\n").find("[string-7] tension-max is not a key"),
            std::string::npos);
}

TEST_F(GeometryFile, ImpossibleValuesAreRefusedWithKeyAndReason) {
  const std::string whole = as_file(load_geometry(kDefaultGeometry));
  const auto reason = [&](const std::string &from, const std::string &to) {
    return refusal(replaced(whole, from, to));
  };
  const auto names = [](const std::string &message, const std::string &part) {
    return message.find(part) != std::string::npos ? testing::AssertionSuccess()
                                                   : testing::AssertionFailure() << message;
  };
  EXPECT_TRUE(names(reason("tension-max=5", "tension-max=nan"), "tension-max has 'nan'"));
  EXPECT_TRUE(names(reason("tension-max=5", "tension-max=inf"), "tension-max has 'inf'"));
  EXPECT_TRUE(names(reason("tension-max=5", "tension-max=much"), "tension-max has 'much'"));
  EXPECT_TRUE(names(reason("tension-max=5", "tension-max=0.2"), "smaller than tension-max"));
  EXPECT_TRUE(names(reason("tension-min=0", "tension-min=-0"), "tension-min must be"));
  EXPECT_TRUE(names(reason("digits-per-volt=415", "digits-per-volt=0"), "digits-per-volt must"));
  EXPECT_TRUE(names(reason("dac-limit=4095", "dac-limit=40950"), "dac-limit must"));
  EXPECT_TRUE(names(reason("dac-limit=4095", "dac-limit=12.5"), "dac-limit must"));
  EXPECT_TRUE(names(reason("dac-limit=4095", "dac-limit=10"), "needs more than dac-limit"));
  EXPECT_TRUE(names(reason("grip-radius=0", "grip-radius=-0"), "grip-radius must"));
  EXPECT_TRUE(names(reason("workspace-half=0", "workspace-half=1"), "workspace-half must"));
  EXPECT_TRUE(names(reason("workspace-half=0", "workspace-half=0;0"), "three numbers"));
  EXPECT_TRUE(names(reason("metres-per-count=1.66", "metres-per-count=0;1.66"), "number"));
  EXPECT_TRUE(names(reason("motor=-0.08", "motor=-80"), "[string-0] motor must be"));
}

TEST_F(GeometryFile, ZeroCountsAndZeroVoltsAreRefused) {
  Geometry geometry = load_geometry(kDefaultGeometry);
  geometry.metres_per_count[3] = 0;
  EXPECT_NE(refusal(as_file(geometry)).find("[string-3] metres-per-count"), std::string::npos);
  geometry = load_geometry(kDefaultGeometry);
  geometry.volts_per_newton[5] = 0;
  EXPECT_NE(refusal(as_file(geometry)).find("[string-5] volts-per-newton"), std::string::npos);
}

TEST_F(GeometryFile, StringsThatCannotPullEverywhereAreRefused) {
  const std::string finger = refusal(as_file(finger_grip_6x3f()));
  EXPECT_NE(finger.find("missing: turn about +y"), std::string::npos) << finger;
  const std::string printed = refusal(as_file(printed_2021_6x4()));
  EXPECT_NE(printed.find("missing: turn about"), std::string::npos) << printed;
}

TEST(CheckGeometry, RefusesNumbersThatAreNone) {
  Geometry geometry = load_geometry(kDefaultGeometry);
  geometry.motors[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check_geometry(geometry), Error);
  geometry = load_geometry(kDefaultGeometry);
  geometry.tension_max = std::numeric_limits<double>::infinity();
  EXPECT_THROW(check_geometry(geometry), Error);
}

} // namespace spidar_geometry_test
