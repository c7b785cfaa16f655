// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/track-typefind.hpp"

#include <gst/gst.h>

GST_ELEMENT_REGISTER_DECLARE(hapticconvert)
GST_ELEMENT_REGISTER_DECLARE(hapticmark)
GST_ELEMENT_REGISTER_DECLARE(hmpgparse)
GST_ELEMENT_REGISTER_DECLARE(pointerextract)
GST_ELEMENT_REGISTER_DECLARE(pointerinject)
GST_ELEMENT_REGISTER_DECLARE(rtphmpgdepay)
GST_ELEMENT_REGISTER_DECLARE(rtphmpgpay)
GST_ELEMENT_REGISTER_DECLARE(rtponesender)

static gboolean plugin_init(GstPlugin *plugin) {
  gboolean any = FALSE;
  any |= GST_ELEMENT_REGISTER(hapticconvert, plugin);
  any |= GST_ELEMENT_REGISTER(hapticmark, plugin);
  any |= GST_ELEMENT_REGISTER(hmpgparse, plugin);
  any |= GST_ELEMENT_REGISTER(rtphmpgpay, plugin);
  any |= GST_ELEMENT_REGISTER(rtphmpgdepay, plugin);
  any |= GST_ELEMENT_REGISTER(rtponesender, plugin);
  any |= GST_ELEMENT_REGISTER(pointerextract, plugin);
  any |= GST_ELEMENT_REGISTER(pointerinject, plugin);
  any |= haptic::register_track_typefinders(plugin);
  return any;
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, haptictrack,
                  "Haptic tracks in files and over networks", plugin_init, VERSION, GST_LICENSE,
                  GST_PACKAGE_NAME, GST_PACKAGE_ORIGIN)
