// SPDX-License-Identifier: LGPL-2.1-or-later
// The branch of the pipeline that makes the film felt on an array of actuators, and its drawing.
//
//   tee. ! queue ! velocityavg ! hapticarray ! level ! audioconvert ! autoaudiosink
#pragma once

#include "array/array-layout.hpp"

#include <cairo.h>
#include <gst/gst.h>
#include <string>
#include <vector>

namespace program {

struct ArraySetup {
  std::string layout;                 ///< of hapticarray; empty: no array
  std::string sink = "autoaudiosink"; ///< as gst-launch-1.0 reads it
};

/// Main thread only.
class ArrayOutput {
public:
  /// Adds the branch "array-branch", with a hapticarray "array", behind the tee. Returns why it
  /// cannot be added and the cure, in a sentence. Empty if it is there.
  std::string add(GstBin *pipeline, GstElement *tee, const ArraySetup &setup);
  void remove();

  /// Takes over a message of the element level.
  void read_levels(const GstStructure *message);
  /// Draws the actuators at their places, each with its amplitude, into the lower right corner of
  /// a widget of width x height. Draws nothing without an array.
  void draw(cairo_t *cairo, double width, double height) const;

private:
  std::string name_; // of the layout
  std::vector<haptic::Actuator> actuators_;
  std::vector<double> levels_; // 0..1 of full scale
};

} // namespace program
