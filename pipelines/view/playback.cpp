// SPDX-License-Identifier: LGPL-2.1-or-later
#include "playback.hpp"

#include <cmath>

namespace view {
namespace {
constexpr double kSlowest = 1.0 / 8;
constexpr double kFastest = 8;
} // namespace

bool Playback::set_paused(bool paused) {
  if (gst_element_set_state(pipeline_, paused ? GST_STATE_PAUSED : GST_STATE_PLAYING) ==
      GST_STATE_CHANGE_FAILURE)
    return false;
  paused_ = paused;
  return true;
}

bool Playback::play_at(double rate) {
  gint64 position = 0;
  return std::abs(rate) >= kSlowest && std::abs(rate) <= kFastest &&
         gst_element_query_position(pipeline_, GST_FORMAT_TIME, &position) && seek(rate, position);
}

bool Playback::restart() {
  gint64 duration = 0;
  if (rate_ > 0)
    return seek(rate_, 0);
  return gst_element_query_duration(pipeline_, GST_FORMAT_TIME, &duration) && seek(rate_, duration);
}

bool Playback::seek(double rate, gint64 position) {
  const auto flags = static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | GST_SEEK_FLAG_ACCURATE);
  // With a negative rate, a segment plays from its stop to its start.
  const gint64 start = rate > 0 ? position : 0;
  const gint64 stop = rate > 0 ? -1 : position;
  if (!gst_element_seek(pipeline_, rate, GST_FORMAT_TIME, flags, GST_SEEK_TYPE_SET, start,
                        GST_SEEK_TYPE_SET, stop))
    return false;
  rate_ = rate;
  return true;
}

} // namespace view
