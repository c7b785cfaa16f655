// SPDX-License-Identifier: LGPL-2.1-or-later
// The enumerations of properties that choose how velocities become one.
#pragma once

#include <glib-object.h>

namespace haptic {

GType average_type();      ///< of Average
GType motion_model_type(); ///< of ModelChoice

} // namespace haptic
