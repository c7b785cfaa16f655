// SPDX-License-Identifier: LGPL-2.1-or-later
// What the class of every element has.
#pragma once

#include "glue/gst-raii.hpp"

#include <gst/gst.h>
#include <string>

namespace haptic {

/// Describes an element for gst-inspect-1.0: its texts, which are not copied, its page, if there is
/// one (Meson's option documentation-uri), and the caps of its pads `sink` and `src`, if they are
/// always there.
inline void describe(GstElementClass *klass, const std::string &element, const char *name,
                     const char *classification, const char *description,
                     const char *sink_caps = nullptr, const char *src_caps = nullptr) {
  gst_element_class_set_static_metadata(klass, name, classification, description,
                                        "Feeling Wind project");
  const std::string base = DOCUMENTATION_URI;
  if (!base.empty())
    gst_element_class_add_metadata(klass, GST_ELEMENT_METADATA_DOC_URI,
                                   (base + "/elements/" + element + ".html").c_str());
  const auto add_pad = [klass](const char *pad, GstPadDirection direction, const char *caps) {
    const CapsPtr parsed(caps ? gst_caps_from_string(caps) : nullptr);
    if (parsed)
      gst_element_class_add_pad_template(
          klass, gst_pad_template_new(pad, direction, GST_PAD_ALWAYS, parsed.get()));
  };
  add_pad("sink", GST_PAD_SINK, sink_caps);
  add_pad("src", GST_PAD_SRC, src_caps);
}

/// GObjectClass::finalize of an element whose `state` was made by its _init.
template <typename Element, gpointer &kParentClass>
void delete_state(GObject *object) {
  delete static_cast<Element *>(static_cast<void *>(object))->state;
  G_OBJECT_CLASS(kParentClass)->finalize(object);
}

} // namespace haptic
