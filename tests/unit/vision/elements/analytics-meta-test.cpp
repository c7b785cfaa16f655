// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/analytics-meta.hpp"
#include "elements/marked-object.hpp"
#include "glue/gst-raii.hpp"

#include <gst/analytics/analytics.h>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace analytics_meta_test {

using haptic::BufferPtr;

constexpr GstClockTime kFrame = GST_SECOND / 30;

struct Box {
  std::string kind;
  int x, y, width, height;
  bool operator==(const Box &) const = default;
};

struct Track {
  guint64 id = 0;
  GstClockTime first_seen = 0, last_seen = 0;
  gboolean lost = FALSE;
};

class Analytics : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  // The next frame, 30 of which make a second.
  void pass(GstHapticHold hold) {
    motion.hold = hold;
    motion.held_time = frames > taken ? (frames - taken) * kFrame : 0;
    frame.reset(gst_buffer_new());
    GST_BUFFER_PTS(frame.get()) = frames++ * kFrame;
    writer.attach(frame.get(), motion);
  }

  std::vector<Box> boxes() const {
    std::vector<Box> boxes;
    GstAnalyticsODMtd mtd;
    for (gpointer state = nullptr; gst_analytics_relation_meta_iterate(
             relations(), &state, gst_analytics_od_mtd_get_mtd_type(), &mtd);) {
      Box box{g_quark_to_string(gst_analytics_od_mtd_get_obj_type(&mtd)), 0, 0, 0, 0};
      gfloat confidence = 0;
      gst_analytics_od_mtd_get_location(&mtd, &box.x, &box.y, &box.width, &box.height, &confidence);
      EXPECT_EQ(confidence, 1);
      boxes.push_back(box);
    }
    return boxes;
  }

  std::optional<Track> track() const {
    GstAnalyticsTrackingMtd mtd;
    gpointer state = nullptr;
    if (!gst_analytics_relation_meta_iterate(relations(), &state,
                                             gst_analytics_tracking_mtd_get_mtd_type(), &mtd))
      return std::nullopt;
    Track track;
    gst_analytics_tracking_mtd_get_info(&mtd, &track.id, &track.first_seen, &track.last_seen,
                                        &track.lost);
    return track;
  }

  GstAnalyticsRelationMeta *relations() const {
    return gst_buffer_get_analytics_relation_meta(frame.get());
  }

  const Box region{"haptic-roi", 10, 20, 30, 40};
  const Box held{"haptic-held", 90, 40, 20, 20};
  GstHapticMotionMeta motion{.region_x = 10,
                             .region_y = 20,
                             .region_width = 30,
                             .region_height = 40,
                             .held_x = 100,
                             .held_y = 50,
                             .held_radius = 10};
  haptic::AnalyticsWriter writer;
  BufferPtr frame;
  GstClockTime frames = 0;
  GstClockTime taken = 2; // the frame in which the thing was taken
};

TEST_F(Analytics, TheRegionIsABox) {
  pass(GST_HAPTIC_HOLD_NONE);
  EXPECT_EQ(boxes(), std::vector<Box>{region});
  EXPECT_FALSE(track());
}

TEST_F(Analytics, AHeldThingIsABoxWithATrackThatKeepsItsNumber) {
  pass(GST_HAPTIC_HOLD_NONE);
  pass(GST_HAPTIC_HOLD_NONE);
  for (int i = 2; i < 5; ++i) {
    pass(i == 4 ? GST_HAPTIC_HOLD_ABOUT : GST_HAPTIC_HOLD_HELD);
    EXPECT_EQ(boxes(), (std::vector<Box>{region, held}));
    ASSERT_TRUE(track());
    EXPECT_EQ(track()->id, 2 * kFrame);
    EXPECT_EQ(track()->first_seen, 2 * kFrame);
    EXPECT_EQ(track()->last_seen, static_cast<guint64>(i) * kFrame);
    EXPECT_FALSE(track()->lost);
    // In the order in which they were added: region, track, thing.
    EXPECT_EQ(gst_analytics_relation_meta_get_relation(relations(), 2, 1),
              GST_ANALYTICS_REL_TYPE_RELATE_TO);
  }
}

TEST_F(Analytics, WhileItIsHiddenOrLostOnlyItsTrackGoesOn) {
  for (int i = 0; i < 4; ++i)
    pass(i < 2 ? GST_HAPTIC_HOLD_NONE : GST_HAPTIC_HOLD_HELD);
  for (const GstHapticHold hold : {GST_HAPTIC_HOLD_HIDDEN, GST_HAPTIC_HOLD_LOST}) {
    pass(hold);
    EXPECT_EQ(boxes(), std::vector<Box>{region});
    ASSERT_TRUE(track());
    EXPECT_EQ(track()->last_seen, 3 * kFrame);
    EXPECT_EQ(track()->lost, hold == GST_HAPTIC_HOLD_LOST);
  }
}

TEST_F(Analytics, AThingThatIsTakenNextHasAnotherNumber) {
  for (int i = 0; i < 4; ++i)
    pass(i < 2 ? GST_HAPTIC_HOLD_NONE : GST_HAPTIC_HOLD_HELD);
  EXPECT_EQ(track()->id, 2 * kFrame);
  taken = 4;
  pass(GST_HAPTIC_HOLD_HELD);
  EXPECT_EQ(track()->id, 4 * kFrame);
}

TEST_F(Analytics, WhatIsRefusedHasNone) {
  pass(GST_HAPTIC_HOLD_REFUSED);
  EXPECT_EQ(boxes(), std::vector<Box>{region});
  EXPECT_FALSE(track());
}

TEST_F(Analytics, ThoseOfAnotherDetectorStay) {
  frame.reset(gst_buffer_new());
  GST_BUFFER_PTS(frame.get()) = 0;
  gst_analytics_relation_meta_add_od_mtd(gst_buffer_add_analytics_relation_meta(frame.get()),
                                         g_quark_from_static_string("leaf"), 1, 2, 3, 4, 1,
                                         nullptr);
  writer.attach(frame.get(), motion);
  EXPECT_EQ(boxes(), (std::vector<Box>{{"leaf", 1, 2, 3, 4}, region}));
}

TEST_F(Analytics, BoxesOfAnotherDetectorAreObjectsAndOursAreNot) {
  frame.reset(gst_buffer_new());
  GST_BUFFER_PTS(frame.get()) = 0;
  gst_analytics_relation_meta_add_od_mtd(gst_buffer_add_analytics_relation_meta(frame.get()),
                                         g_quark_from_static_string("leaf"), 5, 6, 70, 80, 1,
                                         nullptr);
  writer.attach(frame.get(), motion); // a smaller box about the same place
  EXPECT_EQ(haptic::marked_object_at(frame.get(), 25, 40, 176, 144),
            (haptic::Rectangle{5, 6, 70, 80}));
  EXPECT_FALSE(haptic::marked_object_at(frame.get(), 4, 40, 176, 144));
}

TEST_F(Analytics, NumbersWithoutSenseGiveNoBox) {
  motion.region_x = std::numeric_limits<gfloat>::quiet_NaN();
  motion.held_radius = std::numeric_limits<gfloat>::infinity();
  pass(GST_HAPTIC_HOLD_HELD);
  EXPECT_TRUE(boxes().empty());
}

} // namespace analytics_meta_test
