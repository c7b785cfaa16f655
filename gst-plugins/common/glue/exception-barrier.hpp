// SPDX-License-Identifier: LGPL-2.1-or-later
// Keeps C++ exceptions out of GLib's and GStreamer's C frames.
#pragma once

#include "glue/messages.hpp"

#include <exception>
#include <gst/gst.h>
#include <utility>

namespace haptic {

/// Posts an element error with the reason.
inline void post_internal_error(gpointer element, const char *reason) noexcept {
  GST_ELEMENT_ERROR(GST_ELEMENT_CAST(element), LIBRARY, FAILED, (messages::kInternalError, reason),
                    ("uncaught exception"));
}

/// Runs `body` and returns its result. An exception becomes an element error that stops the
/// pipeline with a message, and `fallback` is returned. To be used around the body of every virtual
/// function, pad function, thread entry and signal handler. Any thread; takes no lock of its own.
template <typename Result, typename Body>
Result guarded(gpointer element, Result fallback, Body &&body) noexcept {
  try {
    return std::forward<Body>(body)();
  } catch (const std::exception &error) {
    post_internal_error(element, error.what());
  } catch (...) {
    post_internal_error(element, "an exception of unknown type");
  }
  return fallback;
}

/// The same for functions that return nothing.
template <typename Body>
void guarded(gpointer element, Body &&body) noexcept {
  guarded(element, 0, [&] {
    std::forward<Body>(body)();
    return 0;
  });
}

} // namespace haptic
