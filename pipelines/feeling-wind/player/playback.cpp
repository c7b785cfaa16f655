// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/playback.hpp"

#include "glue/gst-raii.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace program {
namespace {
constexpr double kSlowest = 1.0 / 8;
constexpr double kFastest = 8;
// A seek that is not over then never will be.
constexpr std::chrono::seconds kLongestSeek{3};
} // namespace

bool Playback::set_paused(bool paused) {
  const bool before = paused_;
  paused_ = paused;
  if (update_state())
    return true;
  paused_ = before;
  return false;
}

bool Playback::set_held(bool held) {
  held_ = held;
  return update_state();
}

bool Playback::update_state() {
  return gst_element_set_state(pipeline_,
                               paused_ || held_ ? GST_STATE_PAUSED : GST_STATE_PLAYING) !=
         GST_STATE_CHANGE_FAILURE;
}

gint64 Playback::position() const {
  gint64 position = -1;
  return gst_element_query_position(pipeline_, GST_FORMAT_TIME, &position) ? position : -1;
}

gint64 Playback::duration() const {
  gint64 duration = -1;
  return gst_element_query_duration(pipeline_, GST_FORMAT_TIME, &duration) ? duration : -1;
}

bool Playback::can_seek() const {
  const haptic::QueryPtr query(gst_query_new_seeking(GST_FORMAT_TIME));
  gboolean seekable = FALSE;
  if (gst_element_query(pipeline_, query.get()))
    gst_query_parse_seeking(query.get(), nullptr, &seekable, nullptr, nullptr);
  return seekable;
}

bool Playback::play_at(double rate) {
  const gint64 now = position();
  return std::abs(rate) >= kSlowest && std::abs(rate) <= kFastest && now >= 0 && seek({rate, now});
}

bool Playback::seek_to(gint64 position) {
  const gint64 end = duration();
  position = std::max<gint64>(position, 0);
  return seek({rate_, end >= 0 ? std::min(position, end) : position});
}

bool Playback::restart() {
  if (rate_ > 0)
    return seek({rate_, 0});
  const gint64 end = duration();
  return end >= 0 && seek({rate_, end});
}

bool Playback::seek(const Target &target) {
  const auto now = std::chrono::steady_clock::now();
  if (seeking_since_ && now - *seeking_since_ < kLongestSeek) {
    waiting_ = target;
    rate_ = target.rate;
    return true;
  }
  const auto flags = static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | GST_SEEK_FLAG_ACCURATE);
  // With a negative rate, a segment plays from its stop to its start.
  const gint64 start = target.rate > 0 ? target.position : 0;
  const gint64 stop = target.rate > 0 ? -1 : target.position;
  if (!gst_element_seek(pipeline_, target.rate, GST_FORMAT_TIME, flags, GST_SEEK_TYPE_SET, start,
                        GST_SEEK_TYPE_SET, stop))
    return false;
  seeking_since_ = now;
  waiting_.reset(); // older, of a seek that never ended
  rate_ = target.rate;
  return true;
}

void Playback::end_seek() {
  seeking_since_.reset();
  if (const auto target = std::exchange(waiting_, std::nullopt))
    seek(*target);
}

} // namespace program
