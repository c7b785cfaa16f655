// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that this room shows a user, with its cure. docs/troubleshooting.md is made
// from it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
#define VISION_MESSAGES(MESSAGE)                                                                   \
  MESSAGE(kNoMetadata, "The frames have no motion metadata.",                                      \
          "Put roitracker directly before velocityavg.")                                           \
  MESSAGE(kNotMeasured,                                                                            \
          "The motion of a frame could not be measured, so the frame gives no force.",             \
          "With method=opencv, try method=fast.")                                                  \
  MESSAGE(kNoDepth,                                                                                \
          "No pixel of the depth is between near=%g m and far=%g m, so there is no surface.",      \
          "Correct kind and scale. near must be less than far.")                                   \
  MESSAGE(kTableUnknown, "There is no table \"%s\".",                                              \
          "Use generic, fabric, foliage, or the path of a file that ends in .ini.")                \
  MESSAGE(kTableUnreadable, "The table %s cannot be read: %s.",                                    \
          "The page docs/formats/touch-table.md explains the format.")                             \
  MESSAGE(kTableUnit, "%s: [table] has no unit of length.",                                        \
          "Add a line such as unit=mm (m, cm or mm).")                                             \
  MESSAGE(kTableBy, "%s: [table] by=%s is neither colour nor lightness.",                          \
          "Correct the value, or remove the key to compare colours.")                              \
  MESSAGE(kTableColour, "%s: '%s' is not a colour.",                                               \
          "Write a colour as #rrggbb, with two hexadecimal digits each for red, green and blue.")  \
  MESSAGE(kTableKeyMissing, "%s: [%s] has no %s.",                                                 \
          "An entry needs colour, height, stiffness and friction.")                                \
  MESSAGE(kTableKeyUnknown, "%s: [%s] has an unknown key, %s.",                                    \
          "Correct the key, or number the entries from 1 on without a gap.")                       \
  MESSAGE(kTableNumber, "%s: [%s] %s=%s is not a number from %g to %g.", "Correct the number.")    \
  MESSAGE(kTableCount, "%s has %zu entries.", "A table has 1 to 64 entries.")                      \
  MESSAGE(kUnreadableFrame,                                                                        \
          "A frame cannot be read, because its memory does not match its format.",                 \
          "Put videoconvert before this element, and report it to the maker of the element that "  \
          "made the frame.")                                                                       \
  MESSAGE(kUndrawableFrame,                                                                        \
          "A frame cannot be drawn on, because its memory does not match its format.",             \
          "Put videoconvert before hapticoverlay, and report it to the maker of the element that " \
          "made the frame.")

namespace haptic::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
VISION_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace haptic::messages
