// SPDX-License-Identifier: LGPL-2.1-or-later
// What detectors of other projects marked in a frame.
#pragma once

#include "pixels/luma-view.hpp"

#include <gst/gst.h>
#include <optional>

namespace haptic {

/// Returns the smallest marked object in which a pixel lies (origin at the frame's top left
/// corner), clipped at the frame. Objects are GstVideoRegionOfInterestMeta, and boxes of
/// GstAnalytics where GStreamer has it (1.24 and later), but not those that roitracker attaches.
std::optional<Rectangle> marked_object_at(GstBuffer *buffer, int x, int y, int frame_width,
                                          int frame_height);

} // namespace haptic
