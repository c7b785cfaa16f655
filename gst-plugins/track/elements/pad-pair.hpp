// SPDX-License-Identifier: LGPL-2.1-or-later
// The pads of an element that passes a stream on untouched and has a third pad beside it.
#pragma once

#include "glue/exception-barrier.hpp"

#include <gst/gst.h>

namespace haptic {

inline GstStaticPadTemplate any_sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
inline GstStaticPadTemplate any_src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);

/// Owned by the element.
struct PadPair {
  GstPad *sink = nullptr;
  GstPad *src = nullptr;
};

/// Lets default functions forward events and queries between `sink` and `src` alone.
inline void link_inside(const PadPair &pads) {
  const auto links = [](GstPad *pad, GstObject *parent) -> GstIterator * {
    return guarded(parent, static_cast<GstIterator *>(nullptr), [&] {
      auto *other = static_cast<GstPad *>(gst_pad_get_element_private(pad));
      GValue value = G_VALUE_INIT;
      g_value_init(&value, GST_TYPE_PAD);
      g_value_set_object(&value, other);
      GstIterator *one = gst_iterator_new_single(GST_TYPE_PAD, &value);
      g_value_unset(&value);
      return one;
    });
  };
  gst_pad_set_element_private(pads.sink, pads.src);
  gst_pad_set_element_private(pads.src, pads.sink);
  for (GstPad *pad : {pads.sink, pads.src}) {
    gst_pad_set_iterate_internal_links_function(pad, links);
    GST_PAD_SET_PROXY_CAPS(pad);
    GST_PAD_SET_PROXY_ALLOCATION(pad);
  }
}

/// Adds two pads to the element. What comes at `sink` leaves at `src`.
inline PadPair add_pad_pair(GstElement *element) {
  const PadPair pads = {gst_pad_new_from_static_template(&any_sink_template, "sink"),
                        gst_pad_new_from_static_template(&any_src_template, "src")};
  gst_pad_set_chain_function(pads.sink, [](GstPad *pad, GstObject *parent, GstBuffer *buffer) {
    return guarded(parent, GST_FLOW_ERROR, [&] {
      return gst_pad_push(static_cast<GstPad *>(gst_pad_get_element_private(pad)), buffer);
    });
  });
  link_inside(pads);
  gst_element_add_pad(element, pads.sink);
  gst_element_add_pad(element, pads.src);
  return pads;
}

/// Adds the third pad, from which default functions forward nothing.
inline GstPad *add_lone_pad(GstElement *element, GstStaticPadTemplate *pad_template) {
  GstPad *pad = gst_pad_new_from_static_template(pad_template, "pointer");
  gst_pad_set_iterate_internal_links_function(
      pad, [](GstPad *, GstObject *) -> GstIterator * { return nullptr; });
  gst_element_add_pad(element, pad);
  return pad;
}

/// Adds the templates of the three pads.
inline void add_pad_templates(GstElementClass *element_class, GstStaticPadTemplate *lone) {
  gst_element_class_add_static_pad_template(element_class, &any_sink_template);
  gst_element_class_add_static_pad_template(element_class, &any_src_template);
  gst_element_class_add_static_pad_template(element_class, lone);
}

} // namespace haptic
