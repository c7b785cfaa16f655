/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* Lists the haptic devices of this machine for gst-device-monitor-1.0 and its like. */
#pragma once

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_TYPE_HAPTIC_DEVICE_PROVIDER (gst_haptic_device_provider_get_type())
G_DECLARE_FINAL_TYPE(GstHapticDeviceProvider, gst_haptic_device_provider, GST,
                     HAPTIC_DEVICE_PROVIDER, GstDeviceProvider)

GST_DEVICE_PROVIDER_REGISTER_DECLARE(hapticdeviceprovider)

G_END_DECLS
