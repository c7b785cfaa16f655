// SPDX-License-Identifier: LGPL-2.1-or-later
#include "convert-caps.hpp"

#include "track-caps.hpp"
#include "track-time.hpp"

#include <array>
#include <utility>

namespace haptic {
namespace {

constexpr std::array<std::pair<TrackFormKind, const char *>, 4> kForms = {{
    {TrackFormKind::raw, HAPTIC_RAW_TYPE},
    {TrackFormKind::klv, HAPTIC_KLV_TYPE},
    {TrackFormKind::text, HAPTIC_TEXT_TYPE},
    {TrackFormKind::hmpg, HAPTIC_HMPG_TYPE},
}};

// Returns whether one can become the other: a field becomes no point, and MPEG haptics holds
// points.
bool is_convertible(const GstStructure *one, const GstStructure *other) {
  const auto is_field = [](const GstStructure *structure) {
    return layout_of(structure) == TrackLayout::field;
  };
  const auto holds_points_only = [&](const GstStructure *structure) {
    return gst_structure_has_name(structure, HAPTIC_HMPG_TYPE) ||
           (gst_structure_has_name(structure, HAPTIC_RAW_TYPE) && !is_field(structure));
  };
  return !(is_field(one) && holds_points_only(other)) &&
         !(is_field(other) && holds_points_only(one));
}

// Copies to `other` what a conversion from `structure` keeps of the caps.
void keep_fields(GstPadDirection from, const GstStructure *structure, GstStructure *other) {
  const bool same = gst_structure_has_name(structure, gst_structure_get_name(other));
  if (same && gst_structure_has_name(other, HAPTIC_RAW_TYPE))
    for (const char *field : {"width", "height", "pixel-aspect-ratio", "framerate"})
      if (const GValue *value = gst_structure_get_value(structure, field))
        gst_structure_set_value(other, field, value);
  if (!gst_structure_has_name(other, HAPTIC_HMPG_TYPE))
    return;
  if (!same && from == GST_PAD_SINK)
    gst_structure_set(other, "rate", G_TYPE_INT, static_cast<gint>(haptic::kTrackTimescale),
                      nullptr);
  else if (const GValue *rate = gst_structure_get_value(structure, "rate"); same && rate)
    gst_structure_set_value(other, "rate", rate);
}

} // namespace

TrackFormKind form_of(const GstCaps *caps) {
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  for (const auto &[form, name] : kForms)
    if (gst_structure_has_name(structure, name))
      return form;
  return TrackFormKind::raw;
}

TrackLayout layout_of(const GstStructure *structure) {
  const char *name = gst_structure_get_string(structure, "layout");
  return name && g_str_equal(name, "field") ? TrackLayout::field : TrackLayout::point;
}

CapsPtr convertible_caps(const GstCaps *caps, GstStaticPadTemplate *other_pad,
                         GstPadDirection direction) {
  CapsPtr result(gst_caps_new_empty());
  for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
    const GstStructure *structure = gst_caps_get_structure(caps, i);
    CapsPtr all(gst_static_pad_template_get_caps(other_pad));
    all.reset(gst_caps_make_writable(all.release()));
    for (guint j = gst_caps_get_size(all.get()); j-- > 0;) {
      GstStructure *other = gst_caps_get_structure(all.get(), j);
      if (is_convertible(structure, other))
        keep_fields(direction, structure, other);
      else
        gst_caps_remove_structure(all.get(), j);
    }
    result.reset(gst_caps_merge(result.release(), all.release()));
  }
  return result;
}

} // namespace haptic
