// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/force-defaults.hpp"

#include <gtest/gtest.h>

namespace force_defaults_test {

TEST(ConfidenceGate, OpensFromAFifthToAHalf) {
  EXPECT_EQ(haptic::confidence_gate(0.2), 0);
  EXPECT_NEAR(haptic::confidence_gate(0.35), 0.5, 1e-12);
  EXPECT_EQ(haptic::confidence_gate(0.5), 1);
}

} // namespace force_defaults_test
