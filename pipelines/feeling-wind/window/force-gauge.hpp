// SPDX-License-Identifier: LGPL-2.1-or-later
// A bar beside the hand that shows the force.
#pragma once

#include <cairo.h>
#include <gst/gst.h>

namespace program {

/// Draws over a widget of width x height that shows `frame` in its own aspect ratio, centred. Draws
/// nothing while the pointer of the frame is not known. `max_force`: N, the whole bar.
void draw_force_gauge(cairo_t *cairo, GstSample *frame, double width, double height,
                      double max_force);

} // namespace program
