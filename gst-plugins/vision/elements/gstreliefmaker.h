// SPDX-License-Identifier: LGPL-2.1-or-later
// The base class of the elements that make a relief of each frame.
#pragma once

#include "frames/buffer-timeline.hpp"
#include "glue/property-table.hpp"
#include "samples/relief-field.hpp"

#include <gst/base/gstbasetransform.h>
#include <gst/video/video.h>

namespace haptic {

/// Columns of a relief unless a user wants others.
inline constexpr guint kReliefColumns = 64;

/// The property of the member `columns`.
template <typename Settings>
auto relief_columns_row() {
  constexpr guint kFewest = 4;
  constexpr guint kMost = 96;
  return Rows<Settings>::template number<&Settings::columns>(
      "field-columns", "Field Columns",
      "Cells side by side; rows follow from the frame's shape. None is narrower than 8 pixels",
      kFewest, kMost);
}

/// The state of such an element. Streaming thread only, or while it is stopped.
class ReliefMaker {
public:
  ReliefMaker() { gst_video_info_init(&frame); }
  virtual ~ReliefMaker() = default;
  ReliefMaker(const ReliefMaker &) = delete;
  ReliefMaker &operator=(const ReliefMaker &) = delete;

  /// Called at each start, by the thread that changes the state; the streaming thread may be at
  /// work. Returns false after an error message.
  virtual bool start() { return true; }
  /// Called at each stop, under the lock of the stream.
  virtual void stop() {}
  /// Called before each frame. Returns the columns that are wanted.
  virtual guint follow_settings() = 0;
  /// Fills the cells of `relief`, of which all else is set, from a frame.
  virtual void make(const GstVideoFrame &mapped) = 0;

  GstVideoInfo frame; ///< of the caps
  BufferTimeline timeline;
  ReliefField relief;
};

} // namespace haptic

#define GST_TYPE_RELIEF_MAKER (gst_relief_maker_get_type())
G_DECLARE_DERIVABLE_TYPE(GstReliefMaker, gst_relief_maker, GST, RELIEF_MAKER, GstBaseTransform)

struct _GstReliefMakerClass {
  GstBaseTransformClass parent_class;
};

/// The state of an instance; deleted with it.
haptic::ReliefMaker *gst_relief_maker_state(GstReliefMaker *self);

/// To be called once, by the init function of a class.
void gst_relief_maker_set_state(GstReliefMaker *self, haptic::ReliefMaker *state);
