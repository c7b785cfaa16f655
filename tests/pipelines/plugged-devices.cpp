// SPDX-License-Identifier: LGPL-2.1-or-later
// A device provider of cameras and haptic devices that are plugged in by a test. The file that the
// environment variable PLUGGED_DEVICES names has a line for each, "camera PATH TITLE" or "haptic
// DEVICE TITLE".
#include <fstream>
#include <gst/gst.h>
#include <map>
#include <sstream>
#include <string>

#define PACKAGE "plugged-devices"

G_DECLARE_FINAL_TYPE(PluggedDevice, plugged_device, PLUGGED, DEVICE, GstDevice)
struct _PluggedDevice {
  GstDevice parent;
};
G_DEFINE_TYPE(PluggedDevice, plugged_device, GST_TYPE_DEVICE)

static void plugged_device_class_init(PluggedDeviceClass *) {}
static void plugged_device_init(PluggedDevice *) {}

G_DECLARE_FINAL_TYPE(PluggedProvider, plugged_provider, PLUGGED, PROVIDER, GstDeviceProvider)
struct _PluggedProvider {
  GstDeviceProvider parent;
  std::map<std::string, GstDevice *> *listed; // by line
  guint timer;
};
G_DEFINE_TYPE(PluggedProvider, plugged_provider, GST_TYPE_DEVICE_PROVIDER)

namespace {

constexpr guint kBetweenLooks = 50; // ms

GstDevice *make_device(const std::string &line) {
  std::istringstream words(line);
  std::string kind, name, title;
  words >> kind >> name >> std::ws;
  std::getline(words, title);
  const bool camera = kind == "camera";
  GstStructure *properties = gst_structure_new("plugged", camera ? "device.path" : "device",
                                               G_TYPE_STRING, name.c_str(), nullptr);
  GstCaps *caps = gst_caps_new_any();
  auto *device = GST_DEVICE(g_object_new(plugged_device_get_type(), "display-name", title.c_str(),
                                         "device-class", camera ? "Video/Source" : "Sink/Haptics",
                                         "caps", caps, "properties", properties, nullptr));
  gst_caps_unref(caps);
  gst_structure_free(properties);
  return device;
}

void look(PluggedProvider *self) {
  std::map<std::string, GstDevice *> gone;
  gone.swap(*self->listed);
  std::ifstream file(g_getenv("PLUGGED_DEVICES"));
  for (std::string line; std::getline(file, line);) {
    if (const auto node = gone.extract(line); !node.empty()) {
      self->listed->emplace(line, node.mapped());
      continue;
    }
    GstDevice *device = make_device(line);
    self->listed->emplace(line, device);
    gst_device_provider_device_add(GST_DEVICE_PROVIDER(self), device);
  }
  for (const auto &[line, device] : gone)
    gst_device_provider_device_remove(GST_DEVICE_PROVIDER(self), device);
}

} // namespace

static void plugged_provider_class_init(PluggedProviderClass *klass) {
  auto *provider_class = GST_DEVICE_PROVIDER_CLASS(klass);
  gst_device_provider_class_set_static_metadata(
      provider_class, "Plugged devices", "Video/Source/Sink/Haptics", "Lists what a test plugs in",
      "Feeling Wind project");
  provider_class->start = [](GstDeviceProvider *provider) -> gboolean {
    auto *self = reinterpret_cast<PluggedProvider *>(provider);
    look(self);
    self->timer = g_timeout_add(
        kBetweenLooks,
        [](gpointer user) -> gboolean {
          look(static_cast<PluggedProvider *>(user));
          return G_SOURCE_CONTINUE;
        },
        self);
    return TRUE;
  };
  provider_class->stop = [](GstDeviceProvider *provider) {
    auto *self = reinterpret_cast<PluggedProvider *>(provider);
    g_source_remove(self->timer);
    self->listed->clear();
  };
  G_OBJECT_CLASS(klass)->finalize = [](GObject *object) {
    delete reinterpret_cast<PluggedProvider *>(object)->listed;
    G_OBJECT_CLASS(plugged_provider_parent_class)->finalize(object);
  };
}

static void plugged_provider_init(PluggedProvider *self) {
  self->listed = new std::map<std::string, GstDevice *>;
}

static gboolean plugin_init(GstPlugin *plugin) {
  return gst_device_provider_register(plugin, "pluggeddevices", GST_RANK_PRIMARY,
                                      plugged_provider_get_type());
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, pluggeddevices,
                  "Devices that a test plugs in", plugin_init, VERSION, "LGPL", PACKAGE, PACKAGE)
