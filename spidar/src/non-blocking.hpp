// SPDX-License-Identifier: LGPL-2.1-or-later
// Marks a function that never allocates, locks or waits, with all that it calls. Clang's
// RealtimeSanitizer holds it to that (tests/referees/real-time-sanitizer.sh).
#pragma once

#if __has_cpp_attribute(clang::nonblocking)
#define HAPTIC_NONBLOCKING [[clang::nonblocking]]
#else
#define HAPTIC_NONBLOCKING
#endif
