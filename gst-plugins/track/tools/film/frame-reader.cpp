// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/frame-reader.hpp"

#include "film/pipeline.hpp"
#include "glue/display-orientation.hpp"

#include <gst/app/gstappsink.h>

namespace haptic {
namespace {

// A seek in a transport stream does not find a key frame. Frames are wrong until the next one,
// which usual encoders write every 250 frames.
constexpr GstClockTime kBeforeAKey = 20 * GST_SECOND;
constexpr GstClockTime kPatience = 5 * GST_SECOND;

} // namespace

std::vector<Frame> read_frames(const std::string &path, const std::vector<std::uint64_t> &times,
                               int width, int height) {
  std::vector<Frame> frames(times.size());
  // With these properties decodebin leaves the sound out: unlinked, it could keep it from starting.
  FilePipeline file(
      path, "decodebin caps=video/x-raw(ANY) expose-all-streams=false",
      format_text(" ! videoconvert ! videoflip video-direction=%s ! videoscale add-borders=false ! "
                  "video/x-raw,format=RGB,pixel-aspect-ratio=1/1,width=%d,height=%d ! "
                  "appsink name=out sync=false max-buffers=2",
                  direction_of(orientation_in(path)), width, height));
  const ElementPtr out = element_in(file.get(), "out");
  gst_element_set_state(file.get(), GST_STATE_PAUSED);
  if (gst_element_get_state(file.get(), nullptr, nullptr, kPatience) != GST_STATE_CHANGE_SUCCESS)
    return frames;
  gst_element_set_state(file.get(), GST_STATE_PLAYING);
  GstClockTime now = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] > now + 2 * kBeforeAKey)
      gst_element_seek_simple(file.get(), GST_FORMAT_TIME,
                              static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH |
                                                        GST_SEEK_FLAG_KEY_UNIT |
                                                        GST_SEEK_FLAG_SNAP_BEFORE),
                              static_cast<gint64>(times[i] - kBeforeAKey));
    SamplePtr sample;
    do {
      sample.reset(gst_app_sink_try_pull_sample(GST_APP_SINK(out.get()), kPatience));
      if (!sample)
        return frames;
      now = gst_segment_to_stream_time(gst_sample_get_segment(sample.get()), GST_FORMAT_TIME,
                                       GST_BUFFER_PTS(gst_sample_get_buffer(sample.get())));
    } while (now + GST_MSECOND < times[i]);
    const ReadableBuffer readable(gst_sample_get_buffer(sample.get()));
    frames[i].assign(readable.bytes().begin(), readable.bytes().end());
  }
  return frames;
}

} // namespace haptic
