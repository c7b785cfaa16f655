// SPDX-License-Identifier: LGPL-2.1-or-later
// The page of an element, for gst-inspect-1.0.
#pragma once

#include <gst/gst.h>
#include <string>

namespace haptic {

/// Adds the address of the element's page, if there is one: Meson's option documentation-uri.
inline void add_documentation(GstElementClass *klass, const std::string &element) {
  const std::string base = DOCUMENTATION_URI;
  if (!base.empty())
    gst_element_class_add_metadata(klass, GST_ELEMENT_METADATA_DOC_URI,
                                   (base + "/elements/" + element + ".html").c_str());
}

} // namespace haptic
