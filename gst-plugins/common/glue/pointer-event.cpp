// SPDX-License-Identifier: LGPL-2.1-or-later
#include "glue/pointer-event.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic {

namespace {
static_assert(kNoTimestamp == GST_CLOCK_TIME_NONE);

constexpr const char *kStructureName = "haptic-pointer";
constexpr const char *kForceFields[] = {"force-x", "force-y", "force-z"};

std::optional<std::array<double, 3>> parse_force(const GstStructure *fields) {
  std::array<double, 3> force{};
  for (std::size_t i = 0; i < force.size(); ++i)
    if (!gst_structure_get_double(fields, kForceFields[i], &force[i]) || !std::isfinite(force[i]))
      return std::nullopt;
  return force;
}

std::optional<ProxyPosition> parse_proxy(const GstStructure *fields) {
  ProxyPosition proxy;
  for (const auto &[name, value] :
       {std::pair("proxy-x", &proxy.x), {"proxy-y", &proxy.y}, {"depth", &proxy.depth}})
    if (!gst_structure_get_double(fields, name, value) || !std::isfinite(*value))
      return std::nullopt;
  return ProxyPosition{std::clamp(proxy.x, 0.0, 1.0), std::clamp(proxy.y, 0.0, 1.0),
                       std::max(proxy.depth, 0.0)};
}
} // namespace

EventPtr make_pointer_event(const PointerPosition &position) {
  GstStructure *fields = gst_structure_new(
      kStructureName, "x", G_TYPE_DOUBLE, position.x, "y", G_TYPE_DOUBLE, position.y, "z",
      G_TYPE_DOUBLE, position.z, "pressed", G_TYPE_BOOLEAN, static_cast<gboolean>(position.pressed),
      "device", G_TYPE_STRING, position.device.c_str(), "timestamp", G_TYPE_UINT64,
      position.timestamp, nullptr);
  if (position.force)
    for (std::size_t i = 0; i < position.force->size(); ++i)
      gst_structure_set(fields, kForceFields[i], G_TYPE_DOUBLE, (*position.force)[i], nullptr);
  if (position.proxy)
    gst_structure_set(fields, "proxy-x", G_TYPE_DOUBLE, position.proxy->x, "proxy-y", G_TYPE_DOUBLE,
                      position.proxy->y, "depth", G_TYPE_DOUBLE, position.proxy->depth, nullptr);
  return EventPtr(gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM, fields));
}

std::optional<PointerPosition> parse_pointer_event(GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_CUSTOM_UPSTREAM ||
      !gst_event_has_name(event, kStructureName))
    return std::nullopt;
  const GstStructure *fields = gst_event_get_structure(event);
  PointerPosition position;
  if (!gst_structure_get_double(fields, "x", &position.x) ||
      !gst_structure_get_double(fields, "y", &position.y) || !std::isfinite(position.x) ||
      !std::isfinite(position.y))
    return std::nullopt;
  position.x = std::clamp(position.x, 0.0, 1.0);
  position.y = std::clamp(position.y, 0.0, 1.0);
  if (gst_structure_get_double(fields, "z", &position.z))
    position.z = std::isfinite(position.z) ? std::clamp(position.z, -1.0, 1.0) : 0.0;
  gboolean pressed = FALSE;
  gst_structure_get_boolean(fields, "pressed", &pressed);
  position.pressed = pressed;
  if (const gchar *device = gst_structure_get_string(fields, "device"))
    position.device = device;
  gst_structure_get_uint64(fields, "timestamp", &position.timestamp);
  position.force = parse_force(fields);
  position.proxy = parse_proxy(fields);
  return position;
}

} // namespace haptic
