// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

GST_ELEMENT_REGISTER_DECLARE(depthfield)
GST_ELEMENT_REGISTER_DECLARE(hapticoverlay)
GST_ELEMENT_REGISTER_DECLARE(motionfield)
GST_ELEMENT_REGISTER_DECLARE(reliefmap)
GST_ELEMENT_REGISTER_DECLARE(roitracker)
GST_ELEMENT_REGISTER_DECLARE(velocityavg)

static gboolean plugin_init(GstPlugin *plugin) {
  gboolean registered = FALSE;
  registered |= GST_ELEMENT_REGISTER(roitracker, plugin);
  registered |= GST_ELEMENT_REGISTER(velocityavg, plugin);
  registered |= GST_ELEMENT_REGISTER(motionfield, plugin);
  registered |= GST_ELEMENT_REGISTER(hapticoverlay, plugin);
  registered |= GST_ELEMENT_REGISTER(depthfield, plugin);
  registered |= GST_ELEMENT_REGISTER(reliefmap, plugin);
  return registered;
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, hapticvision,
                  "Motion under a pointer in a video, and of the whole frame", plugin_init, VERSION,
                  GST_LICENSE, GST_PACKAGE_NAME, GST_PACKAGE_ORIGIN)
