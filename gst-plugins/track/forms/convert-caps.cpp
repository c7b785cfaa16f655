// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/convert-caps.hpp"

#include "core/track-caps.hpp"
#include "core/track-time.hpp"

#include <array>
#include <optional>
#include <utility>

namespace haptic {
namespace {

constexpr std::array<std::pair<TrackFormKind, const char *>, 5> kForms = {{
    {TrackFormKind::raw, HAPTIC_RAW_TYPE},
    {TrackFormKind::raw, HAPTIC_RELIEF_TYPE},
    {TrackFormKind::klv, HAPTIC_KLV_TYPE},
    {TrackFormKind::text, HAPTIC_TEXT_TYPE},
    {TrackFormKind::hmpg, HAPTIC_HMPG_TYPE},
}};

// Returns what the structure holds, or nothing if that is not certain. MPEG haptics holds points.
std::optional<TrackLayout> content_of(const GstStructure *structure) {
  if (gst_structure_has_name(structure, HAPTIC_HMPG_TYPE))
    return TrackLayout::point;
  return is_raw(structure) ? std::optional(layout_of(structure)) : std::nullopt;
}

// A field becomes no point, and a relief no motion.
bool is_convertible(const GstStructure *one, const GstStructure *other) {
  const auto first = content_of(one);
  const auto second = content_of(other);
  return !first || !second || *first == *second;
}

// Copies to `other` what a conversion from `structure` keeps of the caps.
void keep_fields(GstPadDirection from, const GstStructure *structure, GstStructure *other) {
  const bool same = gst_structure_has_name(structure, gst_structure_get_name(other));
  if (same && is_raw(other))
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

bool is_raw(const GstStructure *structure) {
  return gst_structure_has_name(structure, HAPTIC_RAW_TYPE) ||
         gst_structure_has_name(structure, HAPTIC_RELIEF_TYPE);
}

void set_layout(GstCaps *raw_caps, TrackLayout layout) {
  GstStructure *structure = gst_caps_get_structure(raw_caps, 0);
  const bool is_relief = layout == TrackLayout::relief;
  gst_structure_set_name(structure, is_relief ? HAPTIC_RELIEF_TYPE : HAPTIC_RAW_TYPE);
  gst_structure_remove_fields(structure, "modality", "layout", "kind", nullptr);
  if (is_relief)
    gst_structure_set(structure, "kind", G_TYPE_STRING, "relief", nullptr);
  else
    gst_structure_set(structure, "modality", G_TYPE_STRING, "velocity", "layout", G_TYPE_STRING,
                      layout == TrackLayout::field ? "field" : "point", nullptr);
}

TrackLayout layout_of(const GstStructure *structure) {
  if (gst_structure_has_name(structure, HAPTIC_RELIEF_TYPE))
    return TrackLayout::relief;
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

CapsPtr fixated_caps(CapsPtr caps, TrackLayout layout) {
  if (is_raw(gst_caps_get_structure(caps.get(), 0)))
    for (guint i = 0; i < gst_caps_get_size(caps.get()); ++i)
      if (const GstStructure *structure = gst_caps_get_structure(caps.get(), i);
          is_raw(structure) && layout_of(structure) == layout) {
        caps.reset(gst_caps_copy_nth(caps.get(), i));
        break;
      }
  return CapsPtr(gst_caps_fixate(caps.release()));
}

} // namespace haptic
