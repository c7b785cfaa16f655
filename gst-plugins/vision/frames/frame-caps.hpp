// SPDX-License-Identifier: LGPL-2.1-or-later
// Caps and timing of elements that turn frames into haptic samples.
#pragma once

#include "glue/gst-raii.hpp"

#include <gst/base/gstbasetransform.h>
#include <gst/video/gstvideometa.h>

namespace haptic {

/// Returns the caps of the template of the other side, `pad`, with the fields that describe the
/// frame, which are the same on both sides.
inline CapsPtr with_frame_fields(GstPad *pad, const GstCaps *caps) {
  const CapsPtr pattern(gst_pad_get_pad_template_caps(pad));
  CapsPtr result(gst_caps_new_empty());
  for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
    const GstStructure *from = gst_caps_get_structure(caps, i);
    GstStructure *to = gst_structure_copy(gst_caps_get_structure(pattern.get(), 0));
    for (const char *field : {"width", "height", "pixel-aspect-ratio", "framerate"})
      if (const GValue *value = gst_structure_get_value(from, field))
        gst_structure_set_value(to, field, value);
    result.reset(gst_caps_merge_structure(result.release(), to));
  }
  return result;
}

/// A late sink must not make an element leave out frames, nor the base class clear the GAP flag.
inline void keep_every_frame(GstBaseTransform *trans) {
  gst_base_transform_set_qos_enabled(trans, FALSE);
  gst_base_transform_set_gap_aware(trans, TRUE);
}

/// For GstBaseTransform::transform_caps.
inline GstCaps *transform_frame_caps(GstBaseTransform *trans, GstPadDirection from,
                                     const GstCaps *caps, GstCaps *filter) {
  CapsPtr result = with_frame_fields(from == GST_PAD_SINK ? trans->srcpad : trans->sinkpad, caps);
  if (filter)
    result.reset(gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST));
  return result.release();
}

/// For GstBaseTransform::propose_allocation where rows are read one by one, or none: any strides
/// do.
inline gboolean accept_any_strides(GstBaseTransform *, GstQuery *, GstQuery *query) {
  gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
  return TRUE;
}

/// Copies the time stamp, the duration and the DISCONT flag of a frame.
inline void copy_timing(const GstBuffer *from, GstBuffer *to) {
  GST_BUFFER_PTS(to) = GST_BUFFER_PTS(from);
  GST_BUFFER_DURATION(to) = GST_BUFFER_DURATION(from);
  if (GST_BUFFER_IS_DISCONT(from))
    GST_BUFFER_FLAG_SET(to, GST_BUFFER_FLAG_DISCONT);
}

} // namespace haptic
