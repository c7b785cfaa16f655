// SPDX-License-Identifier: LGPL-2.1-or-later
// The form haptics/hmpg (docs/formats/hmpg.md).
#pragma once

#include "forms/track-form.hpp"

#include <cstdint>
#include <memory>

namespace haptic {

/// Units of MPEG haptics: haptics/hmpg. They last for `unit_duration` ns.
std::unique_ptr<TrackForm> make_hmpg_form(std::uint64_t unit_duration);

} // namespace haptic
