// SPDX-License-Identifier: LGPL-2.1-or-later
// The media types and caps of a haptic track.
#pragma once

#include "glue/gst-raii.hpp"
#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#define HAPTIC_RAW_TYPE "haptics/x-raw"
#define HAPTIC_RELIEF_TYPE "haptics/x-field"
#define HAPTIC_KLV_TYPE "meta/x-klv"
#define HAPTIC_TEXT_TYPE "text/x-raw"
#define HAPTIC_HMPG_TYPE "haptics/hmpg" // RFC 9695, section 4.3.3
#define HAPTIC_HJIF_TYPE "haptics/hjif" // RFC 9695, section 4.3.2

#define HAPTIC_KLV_CAPS HAPTIC_KLV_TYPE ", parsed=(boolean)true"
#define HAPTIC_TEXT_CAPS HAPTIC_TEXT_TYPE ", format=(string)utf8"
#define HAPTIC_HMPG_CAPS                                                                           \
  HAPTIC_HMPG_TYPE ", stream-format=(string)mihs, alignment=(string)unit, rate=(int)[1,48000]"
#define HAPTIC_HMPG_RTP_CAPS                                                                       \
  "application/x-rtp, media=(string)haptics, clock-rate=(int)[1,48000], "                          \
  "encoding-name=(string)HMPG"

namespace haptic {

/// Returns the caps of units with `rate` ticks per second.
inline CapsPtr make_hmpg_caps(gint rate) {
  return CapsPtr(gst_caps_new_simple(HAPTIC_HMPG_TYPE, "stream-format", G_TYPE_STRING, "mihs",
                                     "alignment", G_TYPE_STRING, "unit", "rate", G_TYPE_INT, rate,
                                     nullptr));
}

} // namespace haptic
