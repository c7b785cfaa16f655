// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion vectors that a decoder of H.264 has anyway, as a peer.
#pragma once

#include "results/report.hpp"

#include <filesystem>
#include <optional>

namespace lab {

/// Empty if the vectors can be measured, else the reason why not.
std::string why_no_motion_vectors();

/// The mean of the vectors over a region against trackers on the decoded frames: on rendered
/// scenes with their truth, and on the clips of a folder. Nothing if there is a reason why not.
std::vector<VectorRow> measure_vectors(bool quick,
                                       const std::optional<std::filesystem::path> &clips);

} // namespace lab
