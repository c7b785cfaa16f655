// SPDX-License-Identifier: LGPL-2.1-or-later
// Pads of an element that lets a stream through and has a third pad beside it.
#pragma once

#include <gst/gst.h>

namespace haptic {

/// Events and queries that default functions forward go between `sink` and `src` alone. Both must
/// belong to an element; the third pad has no links.
inline void link_inside(GstPad *sink, GstPad *src) {
  const auto links = [](GstPad *pad, GstObject *) -> GstIterator * {
    auto *other = static_cast<GstPad *>(gst_pad_get_element_private(pad));
    GValue value = G_VALUE_INIT;
    g_value_init(&value, GST_TYPE_PAD);
    g_value_set_object(&value, other);
    GstIterator *one = gst_iterator_new_single(GST_TYPE_PAD, &value);
    g_value_unset(&value);
    return one;
  };
  gst_pad_set_element_private(sink, src);
  gst_pad_set_element_private(src, sink);
  gst_pad_set_iterate_internal_links_function(sink, links);
  gst_pad_set_iterate_internal_links_function(src, links);
  for (GstPad *pad : {sink, src}) {
    GST_PAD_SET_PROXY_CAPS(pad);
    GST_PAD_SET_PROXY_ALLOCATION(pad);
    GST_PAD_SET_PROXY_SCHEDULING(pad);
  }
}

inline void link_nothing(GstPad *pad) {
  gst_pad_set_iterate_internal_links_function(
      pad, [](GstPad *, GstObject *) -> GstIterator * { return nullptr; });
}

} // namespace haptic
