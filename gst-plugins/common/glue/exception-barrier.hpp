// SPDX-License-Identifier: LGPL-2.1-or-later
// Keeps C++ exceptions out of GLib's and GStreamer's C frames.
#pragma once

#include "glue/messages.hpp"

#include <exception>
#include <gst/gst.h>
#include <tuple>
#include <type_traits>
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

/// What a function of GStreamer returns after an exception.
template <typename Result>
inline constexpr Result kFailure{};
template <>
inline constexpr GstFlowReturn kFailure<GstFlowReturn> = GST_FLOW_ERROR;
template <>
inline constexpr GstStateChangeReturn kFailure<GstStateChangeReturn> = GST_STATE_CHANGE_FAILURE;

/// See kGuarded.
template <auto kBody>
class GuardedFunction {
  template <typename Result, typename Self, typename... Needed, typename... Given>
  static Result call(Result (*body)(Self *, Needed...), gpointer self, const Given &...given) {
    return [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
      return body(static_cast<Self *>(self), std::get<kIndex>(std::tie(given...))...);
    }
    (std::index_sequence_for<Needed...>());
  }

public:
  template <typename Result, typename Object, typename... Arguments>
  using Pointer = Result (*)(Object *, Arguments...);

  template <typename Result, typename Object, typename... Arguments>
  constexpr operator Pointer<Result, Object, Arguments...>() const noexcept {
    return [](Object *object, Arguments... arguments) {
      gpointer element = object;
      if constexpr (std::is_same_v<Object, GstPad>)
        element = std::get<0>(std::tie(arguments...)); // the parent of the pad
      if constexpr (std::is_void_v<Result>)
        guarded(element, [&] { call(+kBody, object, arguments...); });
      else
        return guarded(element, kFailure<Result>,
                       [&]() -> Result { return call(+kBody, object, arguments...); });
    };
  }
};

/// A virtual function of an element, or a function of its pad, that runs kBody as guarded() does:
/// `klass->start = kGuarded<start>`. kBody takes as many of its arguments as it needs, the first
/// one by the element's own type. After an exception it returns kFailure.
template <auto kBody>
inline constexpr GuardedFunction<kBody> kGuarded;

} // namespace haptic
