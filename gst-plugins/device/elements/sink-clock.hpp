// SPDX-License-Identifier: LGPL-2.1-or-later
// For the tests of hapticsink, which link it: the module exports nothing of this.
#pragma once

#include "elements/gsthapticsink.h"
#include "share/loop-clock.hpp"

namespace haptic {

/// Before the sink leaves NULL for the first time. `clock` outlives the sink.
void set_clock(GstHapticSink *sink, LoopClock &clock);

} // namespace haptic
