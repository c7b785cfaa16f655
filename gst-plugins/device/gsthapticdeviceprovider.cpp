// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:provider-hapticdeviceprovider
 *
 * The devices that hapticsink can open. See docs/elements/hapticsink.md.
 */
#include "gsthapticdeviceprovider.h"

#include "device-list.hpp"
#include "gst-raii.hpp"
#include "motion-field.hpp"

#include <exception>

GST_DEBUG_CATEGORY_STATIC(haptic_device_provider_debug);
#define GST_CAT_DEFAULT haptic_device_provider_debug

// ---- a device -----------------------------------------------------------------------------------

// What hapticsink needs to know is in the device's properties.
#define GST_TYPE_HAPTIC_DEVICE (gst_haptic_device_get_type())
G_DECLARE_FINAL_TYPE(GstHapticDevice, gst_haptic_device, GST, HAPTIC_DEVICE, GstDevice)

struct _GstHapticDevice {
  GstDevice parent;
};

G_DEFINE_TYPE(GstHapticDevice, gst_haptic_device, GST_TYPE_DEVICE)

static GstElement *gst_haptic_device_create_element(GstDevice *device, const gchar *name) {
  GstElement *sink = gst_element_factory_make("hapticsink", name);
  if (!sink)
    return nullptr;
  const haptic::StructurePtr properties(gst_device_get_properties(device));
  g_object_set(sink, "device", gst_structure_get_string(properties.get(), "device"), nullptr);
  return sink;
}

static void gst_haptic_device_class_init(GstHapticDeviceClass *klass) {
  GST_DEVICE_CLASS(klass)->create_element = gst_haptic_device_create_element;
}

static void gst_haptic_device_init(GstHapticDevice * /*self*/) {}

// ---- the provider -------------------------------------------------------------------------------

struct _GstHapticDeviceProvider {
  GstDeviceProvider parent;
};

G_DEFINE_TYPE_WITH_CODE(GstHapticDeviceProvider, gst_haptic_device_provider,
                        GST_TYPE_DEVICE_PROVIDER,
                        GST_DEBUG_CATEGORY_INIT(haptic_device_provider_debug,
                                                "hapticdeviceprovider", 0, "haptic devices"))
GST_DEVICE_PROVIDER_REGISTER_DEFINE(hapticdeviceprovider, "hapticdeviceprovider",
                                    GST_RANK_SECONDARY, GST_TYPE_HAPTIC_DEVICE_PROVIDER)

namespace {

constexpr const char *kDeviceClass = "Sink/Haptics";

GstDevice *make_device(const haptic::FoundDevice &found) {
  const haptic::CapsPtr caps(gst_caps_from_string(HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS));
  const haptic::StructurePtr properties(
      gst_structure_new("haptic-device", "device", G_TYPE_STRING, found.device.c_str(), nullptr));
  if (!found.problem.empty())
    gst_structure_set(properties.get(), "problem", G_TYPE_STRING, found.problem.c_str(), nullptr);
  return GST_DEVICE(g_object_new(GST_TYPE_HAPTIC_DEVICE, "display-name", found.name.c_str(),
                                 "device-class", kDeviceClass, "caps", caps.get(), "properties",
                                 properties.get(), nullptr));
}

} // namespace

static GList *gst_haptic_device_provider_probe(GstDeviceProvider *provider) {
  GList *devices = nullptr;
  try {
    for (const haptic::FoundDevice &found : haptic::list_devices())
      devices = g_list_append(devices, gst_object_ref_sink(make_device(found)));
  } catch (const std::exception &error) {
    GST_WARNING_OBJECT(provider, "not all devices are listed: %s", error.what());
  }
  return devices;
}

static void gst_haptic_device_provider_class_init(GstHapticDeviceProviderClass *klass) {
  GstDeviceProviderClass *provider_class = GST_DEVICE_PROVIDER_CLASS(klass);
  provider_class->probe = gst_haptic_device_provider_probe;
  gst_device_provider_class_set_static_metadata(
      provider_class, "Haptic device provider", kDeviceClass,
      "Lists SPIDARs, and joysticks with force feedback", "Feeling Wind project");
}

static void gst_haptic_device_provider_init(GstHapticDeviceProvider * /*self*/) {}
