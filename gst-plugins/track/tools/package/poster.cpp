// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/poster.hpp"

#include "core/track-buffer.hpp"
#include "film/pipeline.hpp"
#include "glue/gst-raii.hpp"
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
  GError *wrong = nullptr;
  GstElement *made = gst_parse_launch(kPipeline, &wrong);
  const ErrorPtr error(wrong);
  const ElementPtr pipeline(made ? GST_ELEMENT(gst_object_ref_sink(made)) : nullptr);
  if (error)
    throw_error(messages::kPosterFails, error->message);
  const ElementPtr in(gst_bin_get_by_name(GST_BIN(made), "in"));
  const ElementPtr out(gst_bin_get_by_name(GST_BIN(made), "out"));
  gst_element_set_state(made, GST_STATE_PLAYING);
  gst_app_src_push_buffer(GST_APP_SRC(in.get()),
                          make_buffer(byte_stream_of(format, frame), 0, GST_SECOND).release());
  gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
  // An error leaves the sink without a sample and without an end.
  const BusPtr bus(gst_element_get_bus(made));
  SamplePtr sample;
  std::string failure;
  while (!sample && failure.empty()) {
    sample.reset(gst_app_sink_try_pull_sample(GST_APP_SINK(out.get()), 10 * GST_MSECOND));
    const MessagePtr message(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
    if (message)
      failure = error_of(message.get());
    else if (!sample && gst_app_sink_is_eos(GST_APP_SINK(out.get())))
      failure = "its frames are damaged";
  }
  std::vector<std::uint8_t> bytes;
  if (sample)
    if (const ReadableBuffer readable(gst_sample_get_buffer(sample.get())); readable)
      bytes.assign(readable.bytes().begin(), readable.bytes().end());
  sample.reset();
  gst_element_set_state(made, GST_STATE_NULL);
  if (bytes.empty())
    throw_error(messages::kPosterFails, failure.c_str());
  return bytes;
}

} // namespace haptic
