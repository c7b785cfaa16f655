// SPDX-License-Identifier: LGPL-2.1-or-later
// The caps of hapticconvert: which form they mean, and what can become what.
#pragma once

#include "forms/track-form.hpp"
#include "glue/gst-raii.hpp"

namespace haptic {

enum class TrackFormKind { raw, klv, text, hmpg };

/// Returns the form of fixed caps.
TrackFormKind form_of(const GstCaps *caps);

/// Returns what the samples of a layout are, for a message.
constexpr const char *layout_name(TrackLayout layout) noexcept {
  return layout == TrackLayout::relief  ? "reliefs"
         : layout == TrackLayout::field ? "fields of the whole frame"
                                        : "of one point";
}

/// Returns whether it is that of packed samples, fields or reliefs.
bool is_raw(const GstStructure *structure);

/// Makes of caps of one layout those of another. They must be writable.
void set_layout(GstCaps *raw_caps, TrackLayout layout);

/// Returns the layout that the structure names, or that of a point.
TrackLayout layout_of(const GstStructure *structure);

/// Returns everything of `other_pad` that caps at the pad of this direction can become, packed
/// samples first.
CapsPtr convertible_caps(const GstCaps *caps, GstStaticPadTemplate *other_pad,
                         GstPadDirection direction);

/// Returns fixed caps; if packed samples come first, those of this layout.
CapsPtr fixated_caps(CapsPtr caps, TrackLayout layout);

} // namespace haptic
