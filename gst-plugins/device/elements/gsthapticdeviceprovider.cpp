// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:provider-hapticdeviceprovider
 *
 * Lists the devices that hapticsink can open. See docs/elements/hapticsink.md.
 *
 * |[
 * gst-device-monitor-1.0 Sink/Haptics
 * ]|
 */
#include "drivers/device-list.hpp"
#include "glue/gst-raii.hpp"
#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#include <exception>
#include <gst/gst.h>
#include <utility>

G_DECLARE_FINAL_TYPE(GstHapticDeviceProvider, gst_haptic_device_provider, GST,
                     HAPTIC_DEVICE_PROVIDER, GstDeviceProvider)

GST_DEBUG_CATEGORY_STATIC(haptic_device_provider_debug);
#define GST_CAT_DEFAULT haptic_device_provider_debug

namespace {

// As haptic::guarded(). Neither a device nor a provider is an element, so that an exception only
// goes to the debug log.
template <typename Result, typename Body>
Result guarded(gpointer object, Result fallback, Body &&body) noexcept {
  try {
    return std::forward<Body>(body)();
  } catch (const std::exception &error) {
    GST_ERROR_OBJECT(object, "uncaught exception: %s", error.what());
  } catch (...) {
    GST_ERROR_OBJECT(object, "uncaught exception of unknown type");
  }
  return fallback;
}

} // namespace

// ---- a device -----------------------------------------------------------------------------------

// Its properties hold what hapticsink needs to open it.
G_DECLARE_FINAL_TYPE(GstHapticDevice, gst_haptic_device, GST, HAPTIC_DEVICE, GstDevice)

struct _GstHapticDevice {
  GstDevice parent;
};

G_DEFINE_TYPE(GstHapticDevice, gst_haptic_device, GST_TYPE_DEVICE)

namespace {

GstElement *create_element(GstDevice *device, const gchar *name) {
  GstElement *sink = gst_element_factory_make("hapticsink", name);
  if (!sink)
    return nullptr;
  const haptic::StructurePtr properties(gst_device_get_properties(device));
  g_object_set(sink, "device", gst_structure_get_string(properties.get(), "device"), nullptr);
  return sink;
}

} // namespace

static void gst_haptic_device_class_init(GstHapticDeviceClass *klass) {
  GST_DEVICE_CLASS(klass)->create_element = [](GstDevice *device, const gchar *name) {
    return guarded<GstElement *>(device, nullptr, [&] { return create_element(device, name); });
  };
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
                                    GST_RANK_SECONDARY, gst_haptic_device_provider_get_type())

namespace {

constexpr const char *kDeviceClass = "Sink/Haptics";

GstDevice *make_device(const haptic::FoundDevice &found) {
  const haptic::CapsPtr caps(
      gst_caps_from_string(HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS "; " HAPTIC_RELIEF_CAPS));
  const haptic::StructurePtr properties(
      gst_structure_new("haptic-device", "device", G_TYPE_STRING, found.device.c_str(), nullptr));
  if (!found.problem.empty())
    gst_structure_set(properties.get(), "problem", G_TYPE_STRING, found.problem.c_str(), nullptr);
  return GST_DEVICE(g_object_new(gst_haptic_device_get_type(), "display-name", found.name.c_str(),
                                 "device-class", kDeviceClass, "caps", caps.get(), "properties",
                                 properties.get(), nullptr));
}

GList *probe() {
  GList *devices = nullptr;
  for (const haptic::FoundDevice &found : haptic::list_devices())
    devices = g_list_append(devices, gst_object_ref_sink(make_device(found)));
  return devices;
}

} // namespace

static void gst_haptic_device_provider_class_init(GstHapticDeviceProviderClass *klass) {
  GstDeviceProviderClass *provider_class = GST_DEVICE_PROVIDER_CLASS(klass);
  gst_device_provider_class_set_static_metadata(
      provider_class, "Haptic device provider", kDeviceClass,
      "Lists SPIDARs, and joysticks with force feedback", "Feeling Wind project");
  provider_class->probe = [](GstDeviceProvider *provider) {
    return guarded<GList *>(provider, nullptr, [] { return probe(); });
  };
}

static void gst_haptic_device_provider_init(GstHapticDeviceProvider * /*self*/) {}
