// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/poster.hpp"

#include "core/track-buffer.hpp"
#include "film/pipeline.hpp"
#include "package/transport-stream.hpp"

#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>

namespace haptic {
namespace {

constexpr char kPipeline[] =
    "appsrc name=in caps=video/x-h264,stream-format=byte-stream,alignment=au ! h264parse"
    " ! decodebin caps=video/x-raw(ANY) expose-all-streams=false ! videoconvert ! videoscale"
    " ! video/x-raw,pixel-aspect-ratio=1/1 ! jpegenc quality=85 ! appsink name=out sync=false";

} // namespace

std::vector<std::uint8_t> poster_of(const FilmFormat &format, const SegmentFrame &frame) {
  try {
    const ElementPtr pipeline = make_pipeline(kPipeline);
    const ElementPtr in = element_in(pipeline.get(), "in");
    const ElementPtr out = element_in(pipeline.get(), "out");
    const Running running(pipeline.get(), GST_STATE_PAUSED);
    gst_app_src_push_buffer(GST_APP_SRC(in.get()),
                            make_buffer(byte_stream_of(format, frame), 0, GST_SECOND).release());
    gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
    Flow none;
    wait_for(pipeline.get(), GST_MESSAGE_ASYNC_DONE,
             [&] { none.check(messages::kFileStandsStill); });
    const SamplePtr sample(gst_app_sink_try_pull_preroll(GST_APP_SINK(out.get()), 0));
    if (!sample)
      throw TrackFileError("its frames are damaged");
    const ReadableBuffer readable(gst_sample_get_buffer(sample.get()));
    return {readable.bytes().begin(), readable.bytes().end()};
  } catch (const TrackFileError &failure) {
    throw_error(messages::kPosterFails, failure.what());
  }
}

} // namespace haptic
