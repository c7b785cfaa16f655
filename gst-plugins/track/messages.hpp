// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that this room shows a user, with its cure. docs/troubleshooting.md is made from
// it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
// clang-format off
#define TRACK_ELEMENT_MESSAGES(MESSAGE) \
  MESSAGE(kTrackIsDamaged, \
          "A part of the haptic track is damaged and was left out. Further parts are only counted (stats).", \
          "The rest is felt. On a network, give the receiver a larger latency.") \
  MESSAGE(kTrackHasForeignKlv, \
          "There is KLV of other origin in this stream; it was passed over.", \
          "If nothing is felt, this is not a haptic track: choose another stream of the file.") \
  MESSAGE(kTrackHasForeignText, \
          "There is text in this stream that is not a haptic track; it was passed over.", \
          "If nothing is felt, choose another stream of the file.") \
  MESSAGE(kTrackIsOfLaterVersion, \
          "The haptic track was written by a later version; what this one does not know is left out.", \
          "Update this machine.") \
  MESSAGE(kTrackIsOfOtherKind, \
          "The haptic track has samples of a kind that this version does not know; they were left out.", \
          "Update this machine.") \
  MESSAGE(kTrackHasNoTimes, \
          "The haptic track has lost its time stamps. The times inside of its samples are used; they " \
          "may differ from the video's by a constant.", \
          "Record anew with record.sh, or remux with another program.") \
  MESSAGE(kTrackLostFields, \
          "A part of the motion fields was lost; they are silent until the next key sample, a second at most.", \
          "On a network, give the receiver a larger latency.") \
  MESSAGE(kTrackLayoutIsRefused, \
          "The haptic track holds motion %s, but what follows hapticconvert does not take them.", \
          "Link what takes both, such as hapticsink.") \
  MESSAGE(kTrackFieldsInHmpg, \
          "The haptic track holds motion fields of the whole frame, but MPEG haptics can hold the motion of one " \
          "point only.", \
          "Convert to KLV or text.") \
  MESSAGE(kHmpgIsDamaged, \
          "A part of the MPEG haptics stream is damaged and was left out: %s.", \
          "The rest is felt. Get the file or the stream again.") \
  MESSAGE(kHmpgIsNoUnit, \
          "A buffer is not one unit of MPEG haptics.", \
          "Put hmpgparse before rtphmpgpay.") \
  MESSAGE(kPointerIsDamaged, \
          "A buffer at the pad pointer is not a pointer, or is damaged; it was passed over.", \
          "Link what pointerextract makes to the pad, or its KLV from the network.")
// clang-format on

#define TRACK_MESSAGES(MESSAGE) TRACK_ELEMENT_MESSAGES(MESSAGE)

namespace haptic::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
TRACK_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace haptic::messages
