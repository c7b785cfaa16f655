// SPDX-License-Identifier: LGPL-2.1-or-later
#include "glue/exception-barrier.hpp"

#include "glue/gst-raii.hpp"

#include <gtest/gtest.h>
#include <stdexcept>

namespace exception_barrier_test {

using haptic::kGuarded;

GstStateChangeReturn change_bin(GstBin *bin, GstStateChange transition) {
  return GST_IS_BIN(bin) && transition == GST_STATE_CHANGE_READY_TO_NULL
             ? GST_STATE_CHANGE_NO_PREROLL
             : GST_STATE_CHANGE_ASYNC;
}

class Barrier : public ::testing::Test {
protected:
  void SetUp() override {
    gst_init(nullptr, nullptr);
    bin_.reset(GST_ELEMENT(gst_object_ref_sink(gst_bin_new("bin"))));
    bus_.reset(gst_bus_new());
    gst_element_set_bus(bin_.get(), bus_.get());
  }
  void TearDown() override { gst_element_set_bus(bin_.get(), nullptr); }
  bool posted_an_error() {
    return haptic::MessagePtr(gst_bus_pop_filtered(bus_.get(), GST_MESSAGE_ERROR)) != nullptr;
  }

  haptic::ElementPtr bin_;
  haptic::BusPtr bus_;
};

TEST_F(Barrier, PassesTheElementByItsOwnTypeAndTheArgumentsThatTheBodyNeeds) {
  GstStateChangeReturn (*change)(GstElement *, GstStateChange, guint) = kGuarded<change_bin>;
  EXPECT_EQ(change(bin_.get(), GST_STATE_CHANGE_READY_TO_NULL, 1), GST_STATE_CHANGE_NO_PREROLL);
  EXPECT_FALSE(posted_an_error());
}

TEST_F(Barrier, TurnsAnExceptionIntoAnErrorOfTheElementAndAFailure) {
  constexpr auto kFlow =
      kGuarded<[](GstElement *) -> GstFlowReturn { throw std::runtime_error("no"); }>;
  GstFlowReturn (*flow)(GstElement *) = kFlow;
  EXPECT_EQ(flow(bin_.get()), GST_FLOW_ERROR);
  EXPECT_TRUE(posted_an_error());
  constexpr auto kCaps = kGuarded<[](GstElement *) -> GstCaps * { throw 1; }>;
  GstCaps *(*caps)(GstElement *) = kCaps;
  EXPECT_EQ(caps(bin_.get()), nullptr);
  EXPECT_TRUE(posted_an_error());
}

TEST_F(Barrier, PostsTheErrorOfAPadsFunctionAsOneOfItsParent) {
  const haptic::PadPtr pad(GST_PAD(gst_object_ref_sink(gst_pad_new("pad", GST_PAD_SINK))));
  gboolean (*event)(GstPad *, GstObject *, GstEvent *) =
      kGuarded<[](GstPad *, GstObject *) -> gboolean { throw std::runtime_error("no"); }>;
  EXPECT_FALSE(event(pad.get(), GST_OBJECT(bin_.get()), nullptr));
  EXPECT_TRUE(posted_an_error());
}

} // namespace exception_barrier_test
