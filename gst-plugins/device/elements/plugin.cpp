// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/gsthapticsink.h"

#include <gst/gst.h>

GST_ELEMENT_REGISTER_DECLARE(hapticarray)
GST_DEVICE_PROVIDER_REGISTER_DECLARE(hapticdeviceprovider)

static gboolean plugin_init(GstPlugin *plugin) {
  gboolean any = FALSE;
  any |= GST_ELEMENT_REGISTER(hapticarray, plugin);
  any |= GST_ELEMENT_REGISTER(hapticsink, plugin);
  any |= GST_DEVICE_PROVIDER_REGISTER(hapticdeviceprovider, plugin);
  return any;
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, hapticdevice,
                  "Motion in frames as force on the hand", plugin_init, VERSION, GST_LICENSE,
                  GST_PACKAGE_NAME, GST_PACKAGE_ORIGIN)
