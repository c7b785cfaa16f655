// SPDX-License-Identifier: LGPL-2.1-or-later
// The caps of hapticconvert: which form they mean, and what can become what.
#pragma once

#include "gst-raii.hpp"
#include "track-form.hpp"

namespace haptic {

enum class TrackFormKind { raw, klv, text, hmpg };

/// Returns the form of fixed caps.
TrackFormKind form_of(const GstCaps *caps);

/// Returns "point" or "field".
constexpr const char *layout_name(TrackLayout layout) noexcept {
  return layout == TrackLayout::field ? "field" : "point";
}

/// Returns the layout that the structure names, or that of a point.
TrackLayout layout_of(const GstStructure *structure);

/// Returns everything of `other_pad` that caps at the pad of this direction can become, packed
/// samples first.
CapsPtr convertible_caps(const GstCaps *caps, GstStaticPadTemplate *other_pad,
                         GstPadDirection direction);

} // namespace haptic
