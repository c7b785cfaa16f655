// SPDX-License-Identifier: LGPL-2.1-or-later
// Latency queries of an element that holds buffers back.
#pragma once

#include "glue/gst-raii.hpp"

namespace haptic {

/// Whether the source behind this sink pad is live.
inline bool is_live(GstPad *sink) {
  const QueryPtr query(gst_query_new_latency());
  gboolean live = FALSE;
  if (gst_pad_peer_query(sink, query.get()))
    gst_query_parse_latency(query.get(), &live, nullptr, nullptr);
  return live;
}

/// Adds to the answer of a latency query what `held(live)` returns, ns.
template <typename Held>
void add_latency(GstQuery *query, const Held &held) {
  gboolean live = FALSE;
  GstClockTime least = 0;
  GstClockTime most = GST_CLOCK_TIME_NONE;
  gst_query_parse_latency(query, &live, &least, &most);
  const GstClockTime more = held(live != FALSE);
  gst_query_set_latency(query, live, least + more,
                        GST_CLOCK_TIME_IS_VALID(most) ? most + more : most);
}

} // namespace haptic
