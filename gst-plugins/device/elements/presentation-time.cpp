// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/presentation-time.hpp"

#include "glue/gst-raii.hpp"

#include <algorithm>
#include <cmath>

GST_DEBUG_CATEGORY_EXTERN(haptic_sink_debug);
#define GST_CAT_DEFAULT haptic_sink_debug

namespace haptic {

// Asked of the peer: the base class answers only once it has prerolled, which costs a live source
// its first sample.
bool PresentationTime::is_live() {
  if (liveness_ == Liveness::unknown) {
    const QueryPtr query(gst_query_new_latency());
    if (gst_pad_peer_query(GST_BASE_SINK_PAD(sink_), query.get())) {
      gboolean live = FALSE;
      gst_query_parse_latency(query.get(), &live, nullptr, nullptr);
      liveness_ = live ? Liveness::live : Liveness::not_live;
      GST_INFO_OBJECT(sink_, "%s",
                      live ? "live: samples are felt as soon as they come"
                           : "not live: samples are felt at their time stamps");
    }
  }
  return liveness_ == Liveness::live;
}

bool PresentationTime::is_immediate() {
  return haptic::is_immediate(locked_copy(sink_, settings_.latency_mode),
                              gst_base_sink_get_sync(sink_), [this] { return is_live(); });
}

std::int64_t PresentationTime::of(const GstSegment &segment, GstClockTime pts) {
  if (is_immediate() || !GST_CLOCK_TIME_IS_VALID(pts) || segment.format != GST_FORMAT_TIME)
    return kAtOnce;
  guint64 running = 0;
  const int sign = gst_segment_to_running_time_full(&segment, GST_FORMAT_TIME, pts, &running);
  if (sign == 0)
    return kAtOnce;
  return sign * static_cast<std::int64_t>(running) +
         static_cast<std::int64_t>(gst_base_sink_get_latency(sink_)) +
         gst_base_sink_get_ts_offset(sink_);
}

// Not before the segment begins: a buffer outside it is dropped.
void PresentationTime::look_ahead(GstClockTime &start, GstClockTime &end) const {
  const GstSegment &segment = sink_->segment;
  const std::uint64_t look_ahead = session_.intake().look_ahead();
  const auto ahead =
      static_cast<GstClockTime>(static_cast<double>(look_ahead) * std::abs(segment.rate));
  if (segment.rate > 0 && GST_CLOCK_TIME_IS_VALID(start) && start > segment.start)
    start -= std::min(ahead, start - segment.start);
  if (segment.rate < 0 && GST_CLOCK_TIME_IS_VALID(end) && GST_CLOCK_TIME_IS_VALID(segment.stop) &&
      end < segment.stop)
    end += std::min(ahead, segment.stop - end);
}

} // namespace haptic
