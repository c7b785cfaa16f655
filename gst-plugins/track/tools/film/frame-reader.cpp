// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/frame-reader.hpp"

#include "film/pipeline.hpp"
#include "glue/content-only.hpp"
#include "glue/display-orientation.hpp"

#include <gst/app/gstappsink.h>

namespace haptic {
namespace {

// A seek in a transport stream does not find a key frame. Frames are wrong until the next one,
// which usual encoders write every 250 frames.
constexpr GstClockTime kBeforeAKey = 20 * GST_SECOND;
constexpr GstClockTime kPatience = 5 * GST_SECOND;

Frame frame_of(GstSample *sample, std::size_t row_size, std::size_t rows) {
  Frame frame;
  const ReadableBuffer readable(gst_sample_get_buffer(sample));
  const auto bytes = readable.bytes();
  const std::size_t stride = bytes.size() / rows; // rows are padded to four bytes
  for (std::size_t row = 0; stride >= row_size && row < rows; ++row) {
    const auto line = bytes.subspan(row * stride, row_size);
    frame.rgb.insert(frame.rgb.end(), line.begin(), line.end());
  }
  return frame;
}

} // namespace

std::vector<Frame> read_frames(const std::string &path, const std::vector<std::uint64_t> &times,
                               int width, int height) {
  std::vector<Frame> frames(times.size());
  const std::string line =
      // With these properties decodebin leaves the sound out: unlinked, it could keep it from
      // starting.
      "filesrc name=in ! decodebin name=decoder caps=\"video/x-raw(ANY)\" expose-all-streams=false "
      "! videoconvert ! videoflip video-direction=" +
      std::string(direction_of(orientation_in(path))) +
      " ! videoscale add-borders=false ! video/x-raw,format=RGB,"
      "pixel-aspect-ratio=1/1,width=" +
      std::to_string(width) + ",height=" + std::to_string(height) +
      " ! appsink name=out sync=false max-buffers=2";
  GstElement *made = gst_parse_launch(line.c_str(), nullptr);
  if (!made)
    return frames;
  const ElementPtr pipeline(made);
  const ElementPtr in(gst_bin_get_by_name(GST_BIN(made), "in"));
  const ElementPtr out(gst_bin_get_by_name(GST_BIN(made), "out"));
  const ElementPtr decoder(gst_bin_get_by_name(GST_BIN(made), "decoder"));
  open_content_only(decoder.get(), messages::kFileNamesOthers);
  g_object_set(in.get(), "location", path.c_str(), nullptr);
  const Running running(made, GST_STATE_PAUSED);
  if (gst_element_get_state(made, nullptr, nullptr, kPatience) != GST_STATE_CHANGE_SUCCESS)
    return frames;
  gst_element_set_state(made, GST_STATE_PLAYING);
  GstClockTime now = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] > now + 2 * kBeforeAKey)
      gst_element_seek_simple(made, GST_FORMAT_TIME,
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
    frames[i] = frame_of(sample.get(), 3 * static_cast<std::size_t>(width),
                         static_cast<std::size_t>(height));
  }
  return frames;
}

} // namespace haptic
