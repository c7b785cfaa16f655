// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vibration/vibration.hpp"

#include "track-error.hpp"

namespace haptic {
namespace {

// All that the element knows.
std::string words_of(const GEnumClass *words) {
  std::string text;
  for (guint i = 0; i < words->n_values; ++i)
    text += (i == 0 ? "" : ", ") + std::string(words->values[i].value_nick);
  return text;
}

} // namespace

// Not in the text of a pipeline, where a word with "!" would be another element.
void set_vibration(GstElement *array, const VibrationOptions &options, bool has_fields) {
  GParamSpec *map = g_object_class_find_property(G_OBJECT_GET_CLASS(array), "map");
  const GEnumClass *words = G_PARAM_SPEC_ENUM(map)->enum_class;
  const GEnumValue *chosen =
      g_enum_get_value_by_nick(const_cast<GEnumClass *>(words), options.map.c_str());
  if (!chosen)
    throw_error(messages::kMapIsUnknown, words_of(words).c_str(), options.map.c_str());
  if (options.map == "field" && !has_fields)
    throw_error(messages::kMapNeedsFields);
  g_object_set(array, "map", chosen->value, "alpha", options.alpha, "layout",
               options.layout.c_str(), nullptr);
}

} // namespace haptic
