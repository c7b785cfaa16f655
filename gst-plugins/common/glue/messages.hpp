// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that all elements share, with its cure. docs/troubleshooting.md is made from it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
#define COMMON_MESSAGES(MESSAGE)                                                                   \
  MESSAGE(kInternalError, "An internal error stopped this element: %s.",                           \
          "Report it with the line that you ran and the debug line below the message.")

namespace haptic::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
COMMON_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace haptic::messages
