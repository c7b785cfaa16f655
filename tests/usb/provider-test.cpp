// SPDX-License-Identifier: LGPL-2.1-or-later
// gst-device-monitor-1.0 and its like find a SPIDAR, and hapticsink is made from what they found.
#include "bus-fixture.hpp"

#include "glue/gst-raii.hpp"

#include <gst/gst.h>

namespace provider_test {

class Provider : public test::OnBus {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  struct Found {
    std::string name, device, problem;
    std::string of_sink; ///< property `device` of the element made from it
  };
  static std::vector<Found> found() {
    GstDeviceMonitor *monitor = gst_device_monitor_new();
    gst_device_monitor_add_filter(monitor, "Sink/Haptics", nullptr);
    GList *devices = gst_device_monitor_get_devices(monitor);
    std::vector<Found> all;
    for (GList *entry = devices; entry; entry = entry->next)
      all.push_back(told_by(GST_DEVICE(entry->data)));
    g_list_free_full(devices, gst_object_unref);
    gst_object_unref(monitor);
    return all;
  }

private:
  static std::string text(const gchar *text) { return text ? text : ""; }
  static Found told_by(GstDevice *device) {
    Found found;
    const haptic::GCharPtr name(gst_device_get_display_name(device));
    found.name = name.get();
    const haptic::StructurePtr properties(gst_device_get_properties(device));
    found.device = text(gst_structure_get_string(properties.get(), "device"));
    found.problem = text(gst_structure_get_string(properties.get(), "problem"));
    GstElement *sink = gst_device_create_element(device, "felt");
    EXPECT_TRUE(sink);
    gchar *choice = nullptr;
    g_object_get(sink, "device", &choice, nullptr);
    found.of_sink = text(choice);
    g_free(choice);
    gst_object_unref(gst_object_ref_sink(sink));
    return found;
  }
};

TEST_F(Provider, FindsWhatIsPluggedInAndTheSinkOpensIt) {
  EXPECT_TRUE(found().empty());
  plug(test::Model::simple, 6);
  const auto devices = found();
  ASSERT_EQ(devices.size(), 1U);
  EXPECT_NE(devices[0].name.find("SPIDAR-G"), std::string::npos) << devices[0].name;
  EXPECT_EQ(devices[0].device, "usb:6");
  EXPECT_EQ(devices[0].of_sink, "usb:6");
  EXPECT_EQ(devices[0].problem, "");
}

TEST_F(Provider, WhatCannotBeUsedIsListedWithTheReason) {
  bus_->hold(plug(test::Model::sh4, 3), true);
  const auto devices = found();
  ASSERT_EQ(devices.size(), 1U);
  EXPECT_EQ(devices[0].of_sink, "usb");
  EXPECT_NE(devices[0].problem, "");
}

} // namespace provider_test
