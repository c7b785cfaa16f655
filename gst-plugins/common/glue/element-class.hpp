// SPDX-License-Identifier: LGPL-2.1-or-later
// What the class of every element has.
#pragma once

#include <gst/gst.h>
#include <initializer_list>
#include <string>

namespace haptic {

/// Describes an element for gst-inspect-1.0: its texts, which are not copied, its page, if there is
/// one (Meson's option documentation-uri), and its pads.
inline void describe(GstElementClass *klass, const std::string &element, const char *name,
                     const char *classification, const char *description,
                     std::initializer_list<GstStaticPadTemplate *> pads) {
  gst_element_class_set_static_metadata(klass, name, classification, description,
                                        "Feeling Wind project");
  const std::string base = DOCUMENTATION_URI;
  if (!base.empty())
    gst_element_class_add_metadata(klass, GST_ELEMENT_METADATA_DOC_URI,
                                   (base + "/elements/" + element + ".html").c_str());
  for (GstStaticPadTemplate *pad : pads)
    gst_element_class_add_static_pad_template(klass, pad);
}

/// GObjectClass::finalize of an element whose `state` was made by its _init.
template <typename Element, gpointer &kParentClass>
void delete_state(GObject *object) {
  delete static_cast<Element *>(static_cast<void *>(object))->state;
  G_OBJECT_CLASS(kParentClass)->finalize(object);
}

} // namespace haptic
