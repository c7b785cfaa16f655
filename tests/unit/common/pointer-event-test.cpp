// SPDX-License-Identifier: LGPL-2.1-or-later
#include "glue/pointer-event.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace pointer_event_test {

using haptic::EventPtr;
using haptic::PointerPosition;

class PointerEvent : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
  static EventPtr custom(GstStructure *structure) {
    return EventPtr(gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM, structure));
  }
};

TEST_F(PointerEvent, CarriesThePositionUpstream) {
  PointerPosition sent;
  sent.x = 0.75;
  sent.y = 0.125;
  sent.z = -0.5;
  sent.pressed = true;
  sent.device = "simulated SPIDAR-G";
  sent.timestamp = 1'234'567;
  const EventPtr event = haptic::make_pointer_event(sent);
  EXPECT_EQ(GST_EVENT_TYPE(event.get()), GST_EVENT_CUSTOM_UPSTREAM);
  const auto received = haptic::parse_pointer_event(event.get());
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(received->x, 0.75);
  EXPECT_EQ(received->y, 0.125);
  EXPECT_EQ(received->z, -0.5);
  EXPECT_TRUE(received->pressed);
  EXPECT_EQ(received->device, "simulated SPIDAR-G");
  EXPECT_EQ(received->timestamp, 1'234'567U);
}

TEST_F(PointerEvent, CarriesTheForceIfThereIsOne) {
  PointerPosition sent;
  EXPECT_FALSE(haptic::parse_pointer_event(haptic::make_pointer_event(sent).get())->force);
  sent.force = {0.25, -0.5, 1};
  const EventPtr event = haptic::make_pointer_event(sent);
  EXPECT_EQ(haptic::parse_pointer_event(event.get())->force, sent.force);
  EXPECT_TRUE(gst_structure_has_field_typed(gst_event_get_structure(event.get()), "force-y",
                                            G_TYPE_DOUBLE));
}

TEST_F(PointerEvent, AForceThatIsNotWholeAndFiniteIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto event = custom(gst_structure_new(
      "haptic-pointer", "x", G_TYPE_DOUBLE, 0.1, "y", G_TYPE_DOUBLE, 0.9, "force-x", G_TYPE_DOUBLE,
      1.0, "force-y", G_TYPE_DOUBLE, nan, "force-z", G_TYPE_DOUBLE, 0.0, nullptr));
  EXPECT_FALSE(haptic::parse_pointer_event(event.get())->force);
  const auto partly =
      custom(gst_structure_new("haptic-pointer", "x", G_TYPE_DOUBLE, 0.1, "y", G_TYPE_DOUBLE, 0.9,
                               "force-x", G_TYPE_DOUBLE, 1.0, nullptr));
  EXPECT_FALSE(haptic::parse_pointer_event(partly.get())->force);
}

TEST_F(PointerEvent, CarriesTheProxyIfItIsWholeAndFinite) {
  PointerPosition sent;
  EXPECT_FALSE(haptic::parse_pointer_event(haptic::make_pointer_event(sent).get())->proxy);
  sent.proxy = {0.25, 0.75, 0.004};
  EXPECT_EQ(haptic::parse_pointer_event(haptic::make_pointer_event(sent).get())->proxy, sent.proxy);
  sent.proxy->depth = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(haptic::parse_pointer_event(haptic::make_pointer_event(sent).get())->proxy);
}

TEST_F(PointerEvent, XAndYSuffice) {
  const auto event = custom(gst_structure_new("haptic-pointer", "x", G_TYPE_DOUBLE, 0.1, "y",
                                              G_TYPE_DOUBLE, 0.9, nullptr));
  const auto received = haptic::parse_pointer_event(event.get());
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(received->x, 0.1);
  EXPECT_EQ(received->y, 0.9);
  EXPECT_EQ(received->z, 0);
  EXPECT_EQ(received->timestamp, GST_CLOCK_TIME_NONE);
}

TEST_F(PointerEvent, AHandOutsideTheFrameIsTakenToItsBorder) {
  const auto event = custom(gst_structure_new("haptic-pointer", "x", G_TYPE_DOUBLE, -3.0, "y",
                                              G_TYPE_DOUBLE, 7.0, nullptr));
  const auto received = haptic::parse_pointer_event(event.get());
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(received->x, 0);
  EXPECT_EQ(received->y, 1);
}

TEST_F(PointerEvent, WithoutAFinitePositionItIsNoPointerEvent) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(
      haptic::parse_pointer_event(custom(gst_structure_new_empty("haptic-pointer")).get()));
  EXPECT_FALSE(
      haptic::parse_pointer_event(custom(gst_structure_new("haptic-pointer", "x", G_TYPE_DOUBLE,
                                                           nan, "y", G_TYPE_DOUBLE, 0.5, nullptr))
                                      .get()));
  EXPECT_FALSE(
      haptic::parse_pointer_event(custom(gst_structure_new("something-else", "x", G_TYPE_DOUBLE,
                                                           0.5, "y", G_TYPE_DOUBLE, 0.5, nullptr))
                                      .get()));
  const EventPtr other(gst_event_new_reconfigure());
  EXPECT_FALSE(haptic::parse_pointer_event(other.get()));
}

} // namespace pointer_event_test
