// SPDX-License-Identifier: LGPL-2.1-or-later
#include "glue/content-only.hpp"

#include <string_view>

namespace haptic {
namespace {

// GstAutoplugSelectResult, which no header declares.
constexpr gint kTry = 0;
constexpr gint kSkip = 2;

// Demuxers of playlists are of the class Codec/Demuxer/Adaptive, sdpdemux is of
// Codec/Demuxer/Network/RTP. Codec/Depayloader/Network/RTP opens nothing, and rtsp:// needs it.
gint choose(GstElement *autoplugger, GstPad *, GstCaps *, GstElementFactory *factory,
            gpointer error) {
  const std::string_view all =
      gst_element_factory_get_metadata(factory, GST_ELEMENT_METADATA_KLASS);
  const auto is = [&](std::string_view word) { return all.find(word) != all.npos; };
  if (!is("Adaptive") && (!is("Network") || is("Depayloader")))
    return kTry;
  GST_ELEMENT_ERROR(autoplugger, STREAM, WRONG_TYPE, ("%s", static_cast<const char *>(error)),
                    ("%s was not taken", GST_OBJECT_NAME(factory)));
  return kSkip;
}

} // namespace

void open_content_only(GstElement *autoplugger, const char *error) {
  g_signal_connect(autoplugger, "autoplug-select", G_CALLBACK(choose), const_cast<char *>(error));
}

} // namespace haptic
