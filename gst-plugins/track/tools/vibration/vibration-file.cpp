// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vibration/vibration-file.hpp"

#include "film/pipeline.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "vibration/ahap.hpp"

#include <gst/app/gstappsink.h>
#include <vector>

namespace haptic {
namespace {

constexpr double kLongest = 27 * 3600;    // s, as of a track that is read
constexpr double kMostBytes = 4294901760; // of .wav, whose sizes have 32 bits
// Two periods of the carrier of coils-2 (180 Hz) at the rate of .wav: 533 frames of two floats,
// 4264 bytes. A shorter window at the end is dropped: less than a period has no amplitude.
constexpr double kWindow = 533.0 / 48000; // s

double length_of(const TrackFile &track) {
  const TrackTimes times = times_of(track);
  return seconds(times.last - times.first);
}

// Returns the hapticarray of a pipeline with its properties set: not in the text of the pipeline,
// where a word with "!" would be another element.
ElementPtr array_of(GstElement *pipeline, const TrackFile &track, const VibrationOptions &options) {
  ElementPtr array = element_in(pipeline, "array");
  GParamSpec *map = g_object_class_find_property(G_OBJECT_GET_CLASS(array.get()), "map");
  GEnumClass *words = G_PARAM_SPEC_ENUM(map)->enum_class;
  const GEnumValue *chosen = g_enum_get_value_by_nick(words, options.map.c_str());
  if (!chosen) {
    std::string known;
    for (guint i = 0; i < words->n_values; ++i)
      known += (i == 0 ? "" : ", ") + std::string(words->values[i].value_nick);
    throw_error(messages::kMapIsUnknown, known.c_str(), options.map.c_str());
  }
  if (options.map == "field" && track.fields.empty())
    throw_error(messages::kMapNeedsFields);
  g_object_set(array.get(), "map", chosen->value, "alpha", options.alpha, "layout",
               options.layout.c_str(), nullptr);
  return array;
}

void write_sound(const std::string &path, const TrackFile &track, const VibrationOptions &options) {
  const double length = length_of(track); // s
  const auto refuse_large = [&](GstPad *, GstEvent *event) {
    gint rate = 0;
    gint channels = 0;
    const GstCaps *caps = caps_in(event);
    if (!caps || !gst_structure_get(gst_caps_get_structure(caps, 0), "rate", G_TYPE_INT, &rate,
                                    "channels", G_TYPE_INT, &channels, nullptr))
      return;
    const double fits = kMostBytes / (4.0 * rate * channels); // s, floats
    if (length > fits)
      throw_error(messages::kSoundIsTooLarge, path.c_str(), static_cast<unsigned>(channels),
                  fits / 60, length / 60);
  };
  write_container(path, track, "haptics/x-raw ! hapticarray name=array ! wavenc",
                  [&](GstElement *pipeline) {
                    const ElementPtr array = array_of(pipeline, track, options);
                    const PadPtr out(gst_element_get_static_pad(array.get(), "src"));
                    watch_events(out.get(), refuse_large);
                  });
}

GstFlowReturn measure(GstAppSink *sink, gpointer data) {
  const SamplePtr sample(gst_app_sink_pull_sample(sink));
  if (!sample)
    return GST_FLOW_EOS;
  const ReadableBuffer readable(gst_sample_get_buffer(sample.get()));
  const auto bytes = readable.bytes();
  auto &all = *static_cast<std::vector<Intensity> *>(data);
  all.push_back(
      {(static_cast<double>(all.size()) + 0.5) * kWindow,
       amplitude_of({reinterpret_cast<const float *>(bytes.data()), bytes.size() / sizeof(float)},
                    2)});
  return GST_FLOW_OK;
}

std::string ahap_of(const std::string &path, const TrackFile &track, VibrationOptions options) {
  options.layout = "coils-2";
  std::vector<Intensity> all;
  play_track(path, track,
             "haptics/x-raw ! hapticarray name=array ! audio/x-raw,rate=48000"
             " ! audiobuffersplit output-buffer-size=4264 strict-buffer-size=true"
             " ! appsink name=out sync=false",
             [&](GstElement *pipeline) {
               array_of(pipeline, track, options);
               const ElementPtr out = element_in(pipeline, "out");
               GstAppSinkCallbacks callbacks = {};
               callbacks.new_sample = measure;
               gst_app_sink_set_callbacks(GST_APP_SINK(out.get()), &callbacks, &all, nullptr);
             });
  return write_ahap(all);
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
