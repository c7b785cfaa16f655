// SPDX-License-Identifier: LGPL-2.1-or-later
// The caps that a haptic track travels under.
#pragma once

#include "motion-field.hpp"

#define HAPTIC_KLV_CAPS "meta/x-klv, parsed=(boolean)true"
#define HAPTIC_HMPG_FILE_CAPS "haptics/hmpg"
#define HAPTIC_HMPG_CAPS                                                                           \
  "haptics/hmpg, stream-format=(string)mihs, alignment=(string)unit, rate=(int)[1,48000]"
#define HAPTIC_HJIF_CAPS "haptics/hjif"
#define HAPTIC_HMPG_RTP_CAPS                                                                       \
  "application/x-rtp, media=(string)haptics, payload=(int)[96,127], clock-rate=(int)[1,48000], "   \
  "encoding-name=(string)HMPG"
