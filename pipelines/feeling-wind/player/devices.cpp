// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/devices.hpp"

#include "glue/gst-raii.hpp"

#include <algorithm>
#include <utility>

namespace program {
namespace {

using haptic::BusPtr;
using haptic::ElementPtr;
using haptic::GCharPtr;
using haptic::StructurePtr;

// Returns the first of these properties, or an empty text.
std::string property(GstDevice *device, std::initializer_list<const char *> names) {
  const StructurePtr properties(gst_device_get_properties(device));
  for (const char *name : names)
    if (const char *text = properties ? gst_structure_get_string(properties.get(), name) : nullptr)
      return text;
  return "";
}

std::vector<ListedDevice> list(GstDeviceMonitor *monitor,
                               std::initializer_list<const char *> names) {
  std::vector<ListedDevice> found;
  GList *devices = gst_device_monitor_get_devices(monitor);
  for (GList *item = devices; item; item = item->next) {
    auto *device = GST_DEVICE(item->data);
    const GCharPtr title(gst_device_get_display_name(device));
    ListedDevice listed{title.get(), property(device, names), property(device, {"problem"})};
    const bool known = std::ranges::any_of(
        found, [&](const ListedDevice &other) { return other.name == listed.name; });
    if (!listed.name.empty() && !known)
      found.push_back(std::move(listed));
  }
  g_list_free_full(devices, gst_object_unref);
  return found;
}

// A sink with its device, as gst-launch-1.0 reads it. Empty if it chooses devices in another way.
std::string line_of(GstDevice *device) {
  const ElementPtr sink(gst_device_create_element(device, nullptr));
  if (!sink)
    return "";
  gst_object_ref_sink(sink.get());
  if (!g_object_class_find_property(G_OBJECT_GET_CLASS(sink.get()), "device"))
    return "";
  gchar *name = nullptr;
  g_object_get(sink.get(), "device", &name, nullptr);
  const GCharPtr owned(name);
  const char *factory = GST_OBJECT_NAME(gst_element_get_factory(sink.get()));
  return name ? std::string(factory) + " device=\"" + name + "\"" : "";
}

} // namespace

Devices::Monitor Devices::make_monitor(const char *classes) {
  Monitor monitor(gst_device_monitor_new());
  gst_device_monitor_add_filter(monitor.get(), classes, nullptr);
  return monitor;
}

Devices::Devices(std::function<void()> on_change)
    : on_change_(std::move(on_change)), haptic_(make_monitor("Sink/Haptics")),
      sound_(make_monitor("Audio/Sink")), cameras_(make_monitor("Video/Source")) {
  const BusPtr bus(gst_device_monitor_get_bus(cameras_.get()));
  watch_ = gst_bus_add_watch(
      bus.get(),
      [](GstBus *, GstMessage *, gpointer self) noexcept -> gboolean {
        static_cast<Devices *>(self)->on_change_();
        return G_SOURCE_CONTINUE;
      },
      this);
  gst_device_monitor_start(cameras_.get());
}

Devices::~Devices() {
  g_source_remove(watch_);
  gst_device_monitor_stop(cameras_.get());
}

// PipeWire lists the cameras of Video4Linux too.
std::vector<ListedDevice> Devices::cameras() const {
  return list(cameras_.get(), {"device.path", "api.v4l2.path"});
}

std::vector<ListedDevice> Devices::sound_devices() const {
  std::vector<ListedDevice> found = {{"The usual sound device", "autoaudiosink", ""}};
  GList *devices = gst_device_monitor_get_devices(sound_.get());
  for (GList *item = devices; item; item = item->next) {
    const GCharPtr title(gst_device_get_display_name(GST_DEVICE(item->data)));
    if (std::string line = line_of(GST_DEVICE(item->data)); !line.empty())
      found.push_back({title.get(), std::move(line), ""});
  }
  g_list_free_full(devices, gst_object_unref);
  return found;
}

std::vector<ListedDevice> Devices::haptic_devices() const {
  std::vector<ListedDevice> devices = list(haptic_.get(), {"device"});
  devices.insert(devices.begin(), {"Simulated, the mouse points", "sim", ""});
  return devices;
}

} // namespace program
