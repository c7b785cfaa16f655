// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that this room shows a user, with its cure. docs/troubleshooting.md is made
// from it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
#define VISION_MESSAGES(MESSAGE)                                                                   \
  MESSAGE(kNoMetadata, "The frames carry no motion.",                                              \
          "Put roitracker directly before velocityavg.")                                           \
  MESSAGE(kNotMeasured,                                                                            \
          "The motion of a frame could not be measured; such frames are felt as nothing.",         \
          "With method=opencv, try method=fast.")                                                  \
  MESSAGE(kNoDepth,                                                                                \
          "No pixel of the depth is between near=%g m and far=%g m; there is no surface.",         \
          "Correct kind and scale; near must be less than far.")                                   \
  MESSAGE(kUnreadableFrame,                                                                        \
          "A frame cannot be read: its memory does not hold what its format says.",                \
          "Put videoconvert before this element, and report it to the maker of the element that "  \
          "made the frame.")                                                                       \
  MESSAGE(kUndrawableFrame,                                                                        \
          "A frame cannot be drawn on: its memory does not hold what its format says.",            \
          "Put videoconvert before hapticoverlay, and report it to the maker of the element that " \
          "made the frame.")

namespace haptic::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
VISION_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace haptic::messages
