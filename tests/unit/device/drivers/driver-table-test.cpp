// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/driver-table.hpp"

#include "messages.hpp"

#include <gtest/gtest.h>
#include <set>
#include <spidar/error.hpp>

namespace driver_table_test {

// The word, and not a part of another one.
bool has_word(const std::string &text, const std::string &word) {
  for (const char *after : {",", ".", " "})
    if (text.find(" " + word + after) != std::string::npos)
      return true;
  return false;
}

TEST(DriverTable, EachSchemeIsDifferentAndNamedWhereADeviceIsNotKnown) {
  std::set<std::string> schemes;
  for (const haptic::Driver &driver : haptic::drivers()) {
    EXPECT_TRUE(schemes.insert(driver.scheme).second) << driver.scheme;
    EXPECT_TRUE(has_word(haptic::messages::kUnknownDevice, driver.scheme)) << driver.scheme;
  }
}

TEST(DriverTable, OnlyADriverWithIdsTakesOne) {
  for (const haptic::Driver &driver : haptic::drivers()) {
    if (driver.has_ids)
      continue;
    try {
      haptic::open_device({.device = std::string(driver.scheme) + ":1"});
      ADD_FAILURE() << driver.scheme << " took an ID";
    } catch (const spidar::Error &error) {
      EXPECT_EQ(error.cause(), spidar::Cause::argument) << driver.scheme;
    }
  }
}

} // namespace driver_table_test
