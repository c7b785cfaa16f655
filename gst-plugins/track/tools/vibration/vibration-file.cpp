// SPDX-License-Identifier: LGPL-2.1-or-later
#include "vibration/vibration-file.hpp"

#include "glue/gst-raii.hpp"
#include "vibration/ahap.hpp"

#include <filesystem>
#include <fstream>
#include <vector>

namespace haptic {
namespace {

void write_vibration(const std::string &path, const TrackFile &track, const std::string &form,
                     const VibrationOptions &options) {
  write_container(path, track, "haptics/x-raw ! hapticarray name=array ! " + form,
                  [&](GstElement *pipeline) {
                    const ElementPtr array(gst_bin_get_by_name(GST_BIN(pipeline), "array"));
                    set_vibration(array.get(), options, !track.fields.empty());
                  });
}

// The carrier of the layout is that of coils-2.
std::string ahap_of(const std::string &part, const TrackFile &track, VibrationOptions options) {
  constexpr int kRate = 48000;     // as of .wav, in steps as short
  constexpr double kCarrier = 180; // Hz, of coils-2
  options.layout = "coils-2";
  write_vibration(part, track, "audio/x-raw,rate=" + std::to_string(kRate), options);
  std::ifstream file(part, std::ios::binary);
  std::vector<float> samples(std::filesystem::file_size(part) / sizeof(float));
  file.read(reinterpret_cast<char *>(samples.data()),
            static_cast<std::streamsize>(samples.size() * sizeof(float)));
  return write_ahap({samples, 2, kRate}, kCarrier);
}

} // namespace

bool is_vibration_file(const std::string &path) {
  return path.ends_with(".wav") || path.ends_with(".ahap");
}

void write_vibration_file(const std::string &path, const TrackFile &track,
                          const VibrationOptions &options) {
  if (track.empty())
    throw_error(messages::kOutputHoldsMotion, path.c_str());
  if (path.ends_with(".ahap")) {
    write_bytes(path, ahap_of(part_of(path), track, options));
    return;
  }
  write_vibration(part_of(path), track, "wavenc", options);
  keep_part(path);
}

} // namespace haptic
