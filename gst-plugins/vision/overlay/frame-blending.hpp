// SPDX-License-Identifier: LGPL-2.1-or-later
// Blends painted pixels with video frames of any format, or attaches them for downstream to draw.
#pragma once

#include "glue/gst-raii.hpp"
#include "overlay/overlay-drawing.hpp"

#include <gst/video/video-overlay-composition.h>
#include <gst/video/video.h>
#include <memory>

namespace haptic {

struct CompositionUnref {
  void operator()(GstVideoOverlayComposition *composition) const {
    gst_video_overlay_composition_unref(composition);
  }
  void operator()(GstVideoOverlayRectangle *rectangle) const {
    gst_video_overlay_rectangle_unref(rectangle);
  }
};
using CompositionPtr = std::unique_ptr<GstVideoOverlayComposition, CompositionUnref>;
using RectanglePtr = std::unique_ptr<GstVideoOverlayRectangle, CompositionUnref>;

/// An overlay and its place in the frame.
struct OverlayPixels {
  BufferPtr pixels; ///< with its GstVideoMeta
  Rectangle extent;
};

OverlayPixels paint(const OverlayDrawing &drawing);

/// The overlay as a composition whose top left corner lies at (x, y).
CompositionPtr compose(const OverlayPixels &overlay, int x, int y);

/// Copies the pixels of one frame to another. Returns false if they do not fit.
bool copy_pixels(const GstVideoFrame &from, GstVideoFrame &to);

/// Draws the overlay on the frame. Returns false if it cannot be drawn.
bool blend(const OverlayPixels &overlay, GstVideoFrame &frame);

} // namespace haptic
