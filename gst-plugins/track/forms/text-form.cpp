// SPDX-License-Identifier: LGPL-2.1-or-later
// The form text/x-raw (docs/formats/text-line.md).
#include "field-code/field-codec.hpp"
#include "forms/text-line.hpp"
#include "forms/track-form.hpp"

#include <algorithm>
#include <utility>

namespace haptic {
namespace {

std::vector<std::uint8_t> bytes_of(const std::string &text) {
  return {text.begin(), text.end()};
}

class TextForm final : public TrackForm {
public:
  bool carries_time() const noexcept override { return true; }

  void read(const InputPacket &packet, std::vector<TrackItem> &items) override {
    std::string_view text(reinterpret_cast<const char *>(packet.bytes.data()), packet.bytes.size());
    std::uint64_t time = packet.time; // of the first line only
    while (!text.empty()) {
      const auto end = std::min(text.find('\n'), text.size());
      const auto line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.find_first_not_of(std::string_view(" \r\0", 3)) == std::string_view::npos)
        continue;
      items.push_back(item_of(read_text_line(line), std::exchange(time, kNoTime), packet.duration));
    }
  }

  void write(const TimedSample &item, TrackOutput &output) override {
    output.packets.push_back(
        {bytes_of(write_text_line(item.sample)), item.time, item.sample.duration});
  }

  bool write(const TimedField &item, TrackOutput &output) override {
    output.packets.push_back({bytes_of(write_text_line(item.field)), item.time, item.duration});
    output.packets.back().delta = !is_key_field(item.field.bytes);
    return true;
  }

private:
  static TrackItem item_of(TextLine line, std::uint64_t time, std::uint64_t duration) {
    if (line.sample)
      return TimedSample{*line.sample, time};
    if (line.field)
      return TimedField{std::move(*line.field), time, duration};
    return TrackProblem{TrackProblemKind::foreign_text, line.error};
  }
};

} // namespace

std::unique_ptr<TrackForm> make_text_form() {
  return std::make_unique<TextForm>();
}

} // namespace haptic
