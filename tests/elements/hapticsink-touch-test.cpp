// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink plays reliefs; what the hand touched is read from its log.
#include "hapticsink-fixture.hpp"

#include "relief-field.hpp"

namespace {

using namespace test;

constexpr const char *kReliefCaps = HAPTIC_RELIEF_CAPS ", framerate=30/1";
constexpr double kDepth = 0.003 * 1000 / 1200; // m: 200 N/m against the 1000 N/m of the hand

haptic::ReliefField plane(float height = 0.003F) {
  haptic::ReliefField relief;
  relief.interval = kFrame;
  relief.frame_width = 352;
  relief.frame_height = 288;
  relief.columns = 8;
  relief.rows = 6;
  relief.cells.assign(48, {height, 500, 0, 1});
  return relief;
}

GstBuffer *packed(const haptic::ReliefField &relief, GstClockTime pts) {
  std::vector<std::uint8_t> bytes(haptic::packed_size(relief));
  haptic::pack_relief_field(relief, bytes);
  return test::packed(bytes, pts);
}

class HapticSinkTouch : public HapticSink {
protected:
  void set_caps(const char *text) {
    const haptic::CapsPtr caps(gst_caps_from_string(text));
    gst_app_src_set_caps(GST_APP_SRC(source_.get()), caps.get());
  }
  void push_reliefs(const haptic::ReliefField &relief, double seconds) {
    for (int n = static_cast<int>(seconds * 30); n > 0; --n, pts_ += kFrame)
      push(packed(relief, pts_));
  }
  // A second source for the pad `relief`.
  void add_relief_source() {
    relief_source_ = gst_element_factory_make("appsrc", "reliefs");
    const haptic::CapsPtr caps(gst_caps_from_string(kReliefCaps));
    g_object_set(relief_source_, "format", GST_FORMAT_TIME, "caps", caps.get(), nullptr);
    gst_bin_add(GST_BIN(pipeline_.get()), relief_source_);
    ASSERT_TRUE(gst_element_link_pads(relief_source_, "src", sink_.get(), "relief"));
  }
  void push_beside(const haptic::ReliefField &relief, double seconds) {
    GstClockTime pts = 0;
    for (int n = static_cast<int>(seconds * 30); n > 0; --n, pts += kFrame)
      ASSERT_EQ(gst_app_src_push_buffer(GST_APP_SRC(relief_source_), packed(relief, pts)),
                GST_FLOW_OK);
    gst_app_src_end_of_stream(GST_APP_SRC(relief_source_));
  }

  GstElement *relief_source_ = nullptr;
};

TEST_F(HapticSinkTouch, AReliefAloneIsTouched) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  push_reliefs(plane(), 0.8);
  const Row row = row_at(play_and_read_log(), 0.7);
  EXPECT_NEAR(row.fz, 200 * kDepth, 0.02);
  EXPECT_NEAR(row.proxy[2], 0.003, 1e-4);
  EXPECT_EQ(row.touch, 1);
}

TEST_F(HapticSinkTouch, ReliefsBesideTheMotionAddTheirForce) {
  build_logging("touch=surface+motion");
  add_relief_source();
  push_motion(100, 0, 0.8);
  push_beside(plane(), 0.8);
  const Row row = row_at(play_and_read_log(), 0.7);
  EXPECT_NEAR(row.fz, 200 * kDepth, 0.02);
  EXPECT_NEAR(row.fx, 0.5, 0.02);
}

TEST_F(HapticSinkTouch, WithoutTouchReliefsAreThrownAway) {
  build_logging("");
  add_relief_source();
  push_motion(100, 0, 0.5);
  push_beside(plane(), 0.5);
  const Row row = row_at(play_and_read_log(), 0.4);
  EXPECT_EQ(row.fz, 0);
  EXPECT_NEAR(row.fx, 0.5, 1e-6);
  EXPECT_EQ(row.touch, 0);
}

TEST_F(HapticSinkTouch, HolesEverywhereAreSilence) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  haptic::ReliefField holes = plane();
  for (auto &cell : holes.cells)
    cell = {};
  push_reliefs(holes, 0.4);
  for (const Row &row : play_and_read_log())
    ASSERT_EQ(row.force(), 0);
}

TEST_F(HapticSinkTouch, ADamagedReliefIsSilenceAndOneWarning) {
  build_logging("touch=surface");
  set_caps(kReliefCaps);
  push_reliefs(plane(std::numeric_limits<float>::quiet_NaN()), 0.2);
  push_reliefs(plane(1000), 0.2); // millimetres
  push_end();
  set(GST_STATE_PLAYING);
  const auto warning = message(GST_MESSAGE_WARNING);
  ASSERT_TRUE(warning);
  wait_for_end();
  EXPECT_EQ(count("bad-reliefs"), 12U);
  EXPECT_EQ(message(GST_MESSAGE_WARNING, 0), nullptr);
  for (const Row &row : stop_and_read_log())
    ASSERT_EQ(row.force(), 0);
}

TEST_F(HapticSinkTouch, StopsWhileReliefsWait) {
  build_logging("touch=surface+motion");
  add_relief_source();
  push_motion(100, 0, 0.3);
  push_beside(plane(), 30);
  ASSERT_NE(gst_element_set_state(pipeline_.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  ASSERT_EQ(gst_element_get_state(pipeline_.get(), nullptr, nullptr, GST_CLOCK_TIME_NONE),
            GST_STATE_CHANGE_SUCCESS);
  EXPECT_EQ(gst_element_set_state(pipeline_.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
}

} // namespace
