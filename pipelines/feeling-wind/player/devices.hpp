// SPDX-License-Identifier: LGPL-2.1-or-later
// The cameras and haptic devices that are plugged in.
#pragma once

#include <functional>
#include <gst/gst.h>
#include <memory>
#include <string>
#include <vector>

namespace program {

struct ListedDevice {
  std::string title;
  std::string name;    ///< device file of a camera; `device` of hapticsink
  std::string problem; ///< why it cannot be used, or empty

  bool operator==(const ListedDevice &) const = default;
};

/// Main thread only.
class Devices {
public:
  /// Calls `on_change` when a camera was plugged in or out.
  explicit Devices(std::function<void()> on_change);
  ~Devices();
  Devices(const Devices &) = delete;
  Devices &operator=(const Devices &) = delete;

  std::vector<ListedDevice> cameras() const;
  /// Looks for haptic devices now. The simulated one is always there.
  std::vector<ListedDevice> haptic_devices() const;
  /// Looks for sound devices now. Their names are sinks, as gst-launch-1.0 reads them.
  std::vector<ListedDevice> sound_devices() const;

private:
  struct Unref {
    void operator()(gpointer object) const noexcept { gst_object_unref(object); }
  };
  using Monitor = std::unique_ptr<GstDeviceMonitor, Unref>;

  static Monitor make_monitor(const char *classes);

  std::function<void()> on_change_;
  Monitor haptic_;
  Monitor sound_;
  // Made last: a provider, PipeWire's for example, tells only the monitor that was made last.
  Monitor cameras_;
  guint watch_ = 0;
};

} // namespace program
