// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vibration/vibration-file.hpp"

#include "film/pipeline.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "vibration/ahap.hpp"

#include <algorithm>
#include <gst/app/gstappsink.h>

namespace haptic {
namespace {

constexpr double kLongest = 27 * 3600;    // s, as of a track that is read
constexpr double kMostBytes = 4294901760; // of .wav, whose sizes have 32 bits

double length_of(const TrackFile &track) {
  std::uint64_t first = kNoTime;
  std::uint64_t last = 0;
  const auto widen = [&](const auto &all) {
    for (const auto &one : all) {
      first = std::min(first, one.time);
      last = std::max(last, one.time);
    }
  };
  widen(track.samples);
  widen(track.fields);
  return seconds(last - first);
}

struct SoundLimit {
  std::string path;
  double length; // s
};

// Before the first byte is written.
GstPadProbeReturn refuse_large(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  const auto &limit = *static_cast<const SoundLimit *>(data);
  const GstCaps *caps = caps_in(GST_PAD_PROBE_INFO_EVENT(info));
  if (!caps)
    return GST_PAD_PROBE_OK;
  gint rate = 0;
  gint channels = 0;
  gst_structure_get_int(gst_caps_get_structure(caps, 0), "rate", &rate);
  gst_structure_get_int(gst_caps_get_structure(caps, 0), "channels", &channels);
  const double fits = kMostBytes / (4.0 * rate * channels); // s, floats
  if (limit.length <= fits)
    return GST_PAD_PROBE_OK;
  const ElementPtr array(gst_pad_get_parent_element(pad));
  GST_ELEMENT_ERROR(array.get(), RESOURCE, NO_SPACE_LEFT,
                    (messages::kSoundIsTooLarge, limit.path.c_str(),
                     static_cast<unsigned>(channels), fits / 60, limit.length / 60),
                    (nullptr));
  return GST_PAD_PROBE_DROP;
}

void write_sound(const std::string &path, const TrackFile &track, const VibrationOptions &options) {
  SoundLimit limit{path, length_of(track)};
  write_container(path, track, "haptics/x-raw ! hapticarray name=array ! wavenc",
                  [&](GstElement *pipeline) {
                    const ElementPtr array(gst_bin_get_by_name(GST_BIN(pipeline), "array"));
                    set_vibration(array.get(), options, !track.fields.empty());
                    const PadPtr out(gst_element_get_static_pad(array.get(), "src"));
                    gst_pad_add_probe(out.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, refuse_large,
                                      &limit, nullptr);
                  });
}

GstFlowReturn measure(GstAppSink *sink, gpointer meter) {
  const SamplePtr sample(gst_app_sink_pull_sample(sink));
  if (!sample)
    return GST_FLOW_EOS;
  const ReadableBuffer readable(gst_sample_get_buffer(sample.get()));
  const auto bytes = readable.bytes();
  static_cast<IntensityMeter *>(meter)->push(
      {reinterpret_cast<const float *>(bytes.data()), bytes.size() / sizeof(float)});
  return GST_FLOW_OK;
}

// The carrier of the layout is that of coils-2.
std::string ahap_of(const std::string &path, const TrackFile &track, VibrationOptions options) {
  constexpr int kRate = 48000;     // as of .wav, in steps as short
  constexpr double kCarrier = 180; // Hz, of coils-2
  options.layout = "coils-2";
  IntensityMeter meter(2, kRate, kCarrier);
  play_track(path, track,
             "haptics/x-raw ! hapticarray name=array ! audio/x-raw,rate=" + std::to_string(kRate) +
                 " ! appsink name=out sync=false",
             [&](GstElement *pipeline) {
               const ElementPtr array(gst_bin_get_by_name(GST_BIN(pipeline), "array"));
               set_vibration(array.get(), options, !track.fields.empty());
               const ElementPtr out(gst_bin_get_by_name(GST_BIN(pipeline), "out"));
               GstAppSinkCallbacks callbacks = {};
               callbacks.new_sample = measure;
               gst_app_sink_set_callbacks(GST_APP_SINK(out.get()), &callbacks, &meter, nullptr);
             });
  return write_ahap(meter.intensities());
}

} // namespace

bool is_vibration_file(const std::string &path) {
  return path.ends_with(".wav") || path.ends_with(".ahap");
}

void write_vibration_file(const std::string &path, const TrackFile &track,
                          const VibrationOptions &options) {
  if (track.empty())
    throw_error(messages::kOutputHoldsMotion, path.c_str());
  if (const double length = length_of(track); length > kLongest)
    throw_error(messages::kOutputIsTooLong, path.c_str(), length / 3600, kLongest / 3600);
  if (path.ends_with(".ahap"))
    write_bytes(path, ahap_of(path, track, options));
  else
    write_sound(path, track, options);
}

} // namespace haptic
