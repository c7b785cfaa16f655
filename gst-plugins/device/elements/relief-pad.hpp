// SPDX-License-Identifier: LGPL-2.1-or-later
// The request pad `relief` of hapticsink: reliefs beside the motion of the pad `sink`.
#pragma once

#include "elements/presentation-time.hpp"
#include "session/haptic-session.hpp"

#include <gst/gst.h>

namespace haptic {

/// Adds the pad, which hands reliefs to the session, each at most 1.5 intervals before it is due.
/// It waits while the session is paused, and no longer once the pad is flushing or inactive. A GAP
/// event is a relief without a surface. `session` and `time` outlive the pad; there is one pad at
/// most.
GstPad *add_relief_pad(GstElement *element, GstPadTemplate *of, HapticSession &session,
                       PresentationTime &time);
void remove_relief_pad(GstElement *element, GstPad *pad, HapticSession &session);

} // namespace haptic
