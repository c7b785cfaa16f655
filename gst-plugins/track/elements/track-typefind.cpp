// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/track-typefind.hpp"

#include "core/track-caps.hpp"
#include "mpeg-haptics/hmpg.hpp"

#include <string_view>

namespace haptic {
namespace {

constexpr guint kLookedAt = 4096; // bytes of text

// Suggests .hmpg if the file begins with a sound initialization unit.
void find_hmpg(GstTypeFind *find, gpointer) {
  const guint8 *bytes = gst_type_find_peek(find, 0, kUnitHeaderSize);
  if (!bytes)
    return;
  const auto header = read_unit_header({bytes, kUnitHeaderSize});
  if (!header || header->type != UnitType::initialization || header->length == 0)
    return;
  const auto size = static_cast<guint>(kUnitHeaderSize + header->length);
  bytes = gst_type_find_peek(find, 0, size);
  if (bytes && !read_unit({bytes, size}, nullptr).error)
    gst_type_find_suggest_empty_simple(find, GST_TYPE_FIND_MAXIMUM, HAPTIC_HMPG_TYPE);
}

// Suggests .hjif if the file is a JSON object with the members that clause 6.2.1 of ISO/IEC
// 23090-31:2025 (MPEG_haptics) requires.
void find_hjif(GstTypeFind *find, gpointer) {
  guint size = kLookedAt;
  if (const guint64 length = gst_type_find_get_length(find); length > 0 && length < size)
    size = static_cast<guint>(length);
  const guint8 *bytes = gst_type_find_peek(find, 0, size);
  while (!bytes && (size /= 2) > 0) // the file is shorter, and its length is unknown
    bytes = gst_type_find_peek(find, 0, size);
  if (!bytes)
    return;
  const std::string_view text(reinterpret_cast<const char *>(bytes), size);
  const auto begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos || text[begin] != '{')
    return;
  const auto has = [&](std::string_view key) { return text.find(key) != std::string_view::npos; };
  if (has(R"("perceptions")") && has(R"("timescale")") && has(R"("profile")"))
    gst_type_find_suggest_empty_simple(find, GST_TYPE_FIND_MAXIMUM, HAPTIC_HJIF_TYPE);
}

template <GstTypeFindFunction kFinder>
void barrier(GstTypeFind *find, gpointer data) noexcept {
  try {
    kFinder(find, data);
  } catch (...) { // the type stays unknown; there is no element that could post an error
  }
}

} // namespace

gboolean register_track_typefinders(GstPlugin *plugin) {
  const auto add = [&](const char *name, GstTypeFindFunction finder, const char *extensions,
                       const char *caps) {
    GstCaps *possible = gst_caps_from_string(caps);
    const gboolean done = gst_type_find_register(plugin, name, GST_RANK_PRIMARY, finder, extensions,
                                                 possible, nullptr, nullptr);
    gst_caps_unref(possible);
    return done;
  };
  return add("haptics/hmpg", barrier<find_hmpg>, "hmpg", HAPTIC_HMPG_TYPE) &&
         add("haptics/hjif", barrier<find_hjif>, "hjif", HAPTIC_HJIF_TYPE);
}

} // namespace haptic
