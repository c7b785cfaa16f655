// SPDX-License-Identifier: LGPL-2.1-or-later
// What uridecodebin may choose for the content of a film.
#include "glue/content-only.hpp"
#include "glue/gst-raii.hpp"

#include <gst/gst.h>
#include <gtest/gtest.h>

namespace content_only_test {

constexpr gint kTry = 0; // GstAutoplugSelectResult
constexpr gint kSkip = 2;

class ContentOnly : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override { haptic::open_content_only(autoplugger_.get(), "refused"); }

  // What it does with an element of this factory; -1 if there is none here.
  gint chosen(const char *name) {
    GstElementFactory *factory = gst_element_factory_find(name);
    if (!factory)
      return -1;
    gint result = -1;
    g_signal_emit_by_name(autoplugger_.get(), "autoplug-select", pad_.get(), caps_.get(), factory,
                          &result);
    gst_object_unref(factory);
    return result;
  }

  haptic::ElementPtr autoplugger_{
      GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("uridecodebin", nullptr)))};
  haptic::PadPtr pad_{GST_PAD(gst_object_ref_sink(gst_pad_new("content", GST_PAD_SRC)))};
  haptic::CapsPtr caps_{gst_caps_new_any()};
};

TEST_F(ContentOnly, WhatOpensOtherAddressesIsRefused) {
  EXPECT_EQ(chosen("sdpdemux"), kSkip);
  EXPECT_EQ(chosen("hlsdemux"), kSkip);
  EXPECT_EQ(chosen("dashdemux"), kSkip);
}

TEST_F(ContentOnly, DemuxersDecodersAndTheDepayloadersOfRtspAreTaken) {
  EXPECT_EQ(chosen("matroskademux"), kTry);
  EXPECT_EQ(chosen("jpegdec"), kTry);
  EXPECT_EQ(chosen("rtph264depay"), kTry);
}

} // namespace content_only_test
