// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/fragment-writer.hpp"

#include "film/big-endian.hpp"

#include <algorithm>
#include <concepts>
#include <span>
#include <string_view>

namespace haptic {
namespace {

constexpr std::uint32_t kTicks = 90'000; // a second, of frames and events
constexpr std::uint32_t kVideo = 1;      // numbers of the tracks
constexpr std::uint32_t kSound = 2;
constexpr std::int64_t kSoundFrame = 1024; // samples of a frame of AAC
constexpr char kScheme[] = "urn:misb:KLV:bin:1910.1";
constexpr std::uint32_t kDependsOnNone = 0x02000000;
constexpr std::uint32_t kDepends = 0x01010000; // and is no sync sample

// Writes boxes: their size is known at their end.
class Boxes {
public:
  explicit Boxes(std::vector<std::uint8_t> &out) : out_(out) {}

  // Writes a box with what `content` writes.
  template <typename Content>
  void box(std::string_view type, const Content &content) {
    const std::size_t at = out_.size();
    numbers<4>(0);
    text(type);
    content();
    patch(at, out_.size() - at);
  }

  template <typename Content>
  void full_box(std::string_view type, unsigned version, unsigned flags, const Content &content) {
    box(type, [&] {
      numbers<4>(version << 24 | flags);
      content();
    });
  }

  template <unsigned size>
  void numbers(std::integral auto... values) {
    (put_number(out_, static_cast<std::uint64_t>(values), size), ...);
  }
  void zeros(std::size_t count) { out_.resize(out_.size() + count); }
  void text(std::string_view text) { out_.insert(out_.end(), text.begin(), text.end()); }
  void bytes(std::span<const std::uint8_t> bytes) {
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }
  std::size_t size() const { return out_.size(); }
  void patch(std::size_t at, std::size_t value) {
    for (std::size_t i = 0; i < 4; ++i)
      out_[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
  }

private:
  std::vector<std::uint8_t> &out_;
};

// Writes what a file keeps to, the best first (ISO/IEC 14496-12, annex E). A segment whose fragment
// holds sound and video is one of DASH, "msdh", and none of CMAF, where each has its own files.
void put_type(Boxes &out, std::string_view box, std::string_view brands) {
  out.box(box, [&] {
    out.text(brands.substr(0, 4));
    out.numbers<4>(0);
    out.text(brands);
  });
}

void put_matrix(Boxes &out) {
  out.numbers<4>(0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000);
}

// ISO/IEC 14496-15, 5.3.3.1 and 5.4.2.
void put_video_entry(Boxes &out, const FilmFormat &format) {
  out.box("avc1", [&] {
    out.zeros(6);
    out.numbers<2>(1); // data reference
    out.zeros(16);
    out.numbers<2>(format.width, format.height);
    out.numbers<4>(0x480000, 0x480000, 0); // 72 dpi
    out.numbers<2>(1);
    out.zeros(32);
    out.numbers<2>(0x18, 0xFFFF);
    out.box("avcC", [&] {
      const auto &first = format.sequence_sets[0];
      out.numbers<1>(1, first[1], first[2], first[3], 0xFF);
      const auto put_sets = [&](unsigned head, const auto &sets) {
        out.numbers<1>(head | sets.size());
        for (const auto &set : sets) {
          out.numbers<2>(set.size());
          out.bytes(set);
        }
      };
      put_sets(0xE0, format.sequence_sets);
      put_sets(0, format.picture_sets);
      if (first[1] >= 100) // the format of frames: 4:2:0 of 8 bits, since a browser plays it
        out.numbers<1>(0xFD, 0xF8, 0xF8, 0);
    });
    out.box("pasp", [&] { out.numbers<4>(format.pixel_aspect_n, format.pixel_aspect_d); });
  });
}

// ISO/IEC 14496-14, 5.6, with the descriptors of ISO/IEC 14496-1, 7.2.6.
void put_sound_entry(Boxes &out, const FilmFormat &format) {
  const std::size_t size = format.sound.size();
  out.box("mp4a", [&] {
    out.zeros(6);
    out.numbers<2>(1);
    out.zeros(8);
    out.numbers<2>(format.sound_channels, 16, 0, 0);
    // Of 16 bits, and 0 if the rate does not fit: the AudioSpecificConfig says it.
    out.numbers<2>(format.sound_rate > 0xFFFF ? 0 : format.sound_rate, 0);
    out.full_box("esds", 0, 0, [&] {
      out.numbers<1>(3, 3 + 2 + 13 + 2 + size + 3, 0, 0, 0); // elementary stream
      out.numbers<1>(4, 13 + 2 + size, 0x40, 0x15);          // AAC
      out.zeros(11);                                         // buffer and bit rates: not said
      out.numbers<1>(5, size);
      out.bytes(format.sound);
      out.numbers<1>(6, 1, 2);
    });
  });
}

void put_track(Boxes &out, const FilmFormat &format, bool is_sound) {
  const int width = format.width * std::max(format.pixel_aspect_n, 1) /
                    std::max(format.pixel_aspect_d, 1); // px, of presentation
  out.box("trak", [&] {
    out.full_box("tkhd", 0, 3, [&] { // enabled, in the movie
      out.numbers<4>(0, 0, is_sound ? kSound : kVideo, 0, 0, 0, 0);
      out.numbers<2>(0, 0, is_sound ? 0x100U : 0U, 0);
      put_matrix(out);
      out.numbers<2>(is_sound ? 0 : width, 0, is_sound ? 0 : format.height, 0);
    });
    out.box("mdia", [&] {
      out.full_box("mdhd", 0, 0, [&] {
        out.numbers<4>(0, 0, is_sound ? format.sound_rate : kTicks, 0);
        out.numbers<2>(0x55C4, 0); // language: undetermined
      });
      out.full_box("hdlr", 0, 0, [&] {
        out.numbers<4>(0);
        out.text(is_sound ? "soun" : "vide");
        out.zeros(13);
      });
      out.box("minf", [&] {
        out.full_box(is_sound ? "smhd" : "vmhd", 0, is_sound ? 0 : 1,
                     [&] { out.zeros(is_sound ? 4 : 8); });
        out.box("dinf", [&] {
          out.full_box("dref", 0, 0, [&] {
            out.numbers<4>(1);
            out.full_box("url ", 0, 1, [] {});
          });
        });
        out.box("stbl", [&] {
          out.full_box("stsd", 0, 0, [&] {
            out.numbers<4>(1);
            is_sound ? put_sound_entry(out, format) : put_video_entry(out, format);
          });
          for (const char *empty : {"stts", "stsc", "stco"})
            out.full_box(empty, 0, 0, [&] { out.numbers<4>(0); });
          out.full_box("stsz", 0, 0, [&] { out.zeros(8); });
        });
      });
    });
  });
}

void put_event(Boxes &out, const SegmentField &field, std::uint32_t number) {
  out.full_box("emsg", 1, 0, [&] {
    out.numbers<4>(kTicks);
    out.numbers<8>(std::max<std::int64_t>(field.presentation, 0));
    out.numbers<4>(0, number); // duration
    out.text({kScheme, sizeof kScheme});
    out.numbers<1>(0); // no value
    out.bytes(field.set);
  });
}

// Returns where the place of the data is written.
template <typename Items, typename Put>
std::size_t put_fragment(Boxes &out, std::uint32_t track, std::int64_t time, const Items &items,
                         unsigned flags, const Put &put) {
  std::size_t place = 0;
  out.box("traf", [&] {
    out.full_box("tfhd", 0, 0x020000, [&] { out.numbers<4>(track); }); // from the fragment on
    out.full_box("tfdt", 1, 0, [&] { out.numbers<8>(time); });
    out.full_box("trun", 1, flags | 1, [&] {
      out.numbers<4>(items.size());
      place = out.size();
      out.numbers<4>(0);
      std::ranges::for_each(items, put);
    });
  });
  return place;
}

} // namespace

std::vector<std::uint8_t> FragmentWriter::head() const {
  std::vector<std::uint8_t> head;
  Boxes out(head);
  put_type(out, "ftyp", "iso6");
  const bool has_sound = !format_.sound.empty();
  out.box("moov", [&] {
    out.full_box("mvhd", 0, 0, [&] {
      out.numbers<4>(0, 0, kTicks, 0, 0x10000);
      out.numbers<2>(0x100);
      out.zeros(10);
      put_matrix(out);
      out.zeros(24);
      out.numbers<4>(kSound + 1);
    });
    put_track(out, format_, false);
    if (has_sound)
      put_track(out, format_, true);
    out.box("mvex", [&] {
      for (std::uint32_t track = kVideo; track <= (has_sound ? kSound : kVideo); ++track)
        out.full_box("trex", 0, 0, [&] { out.numbers<4>(track, 1, 0, 0, 0); });
    });
  });
  return head;
}

std::vector<std::uint8_t> FragmentWriter::write(const FilmSegment &segment) {
  std::vector<std::uint8_t> bytes;
  Boxes out(bytes);
  put_type(out, "styp", "msdhiso6");
  const std::size_t head = out.size();
  for (const SegmentField &field : segment.fields)
    put_event(out, field, events_++);
  const std::size_t begin = out.size();
  track_bytes_ += begin - head;
  std::size_t video_place = 0;
  std::size_t sound_place = 0;
  out.box("moof", [&] {
    out.full_box("mfhd", 0, 0, [&] { out.numbers<4>(segment.number + 1); });
    // Each frame has duration, size, flags and offset.
    video_place = put_fragment(out, kVideo, segment.frames.empty() ? 0 : segment.frames[0].turn,
                               segment.frames, 0x0F00, [&](const auto &frame) {
                                 out.numbers<4>(frame.duration, frame.bytes.size(),
                                                frame.is_idr ? kDependsOnNone : kDepends,
                                                frame.presentation - frame.turn);
                               });
    if (segment.sounds.empty())
      return;
    const std::int64_t wanted =
        (segment.sounds[0].time * format_.sound_rate + 500'000'000) / 1'000'000'000;
    if (sounded_ < 0 || wanted > sounded_ + kSoundFrame / 2)
      sounded_ = wanted;
    sound_place =
        put_fragment(out, kSound, sounded_, segment.sounds, 0x0300,
                     [&](const auto &sound) { out.numbers<4>(kSoundFrame, sound.bytes.size()); });
    sounded_ += kSoundFrame * static_cast<std::int64_t>(segment.sounds.size());
  });
  out.box("mdat", [&] {
    out.patch(video_place, out.size() - begin);
    for (const SegmentFrame &frame : segment.frames)
      out.bytes(frame.bytes);
    if (sound_place > 0)
      out.patch(sound_place, out.size() - begin);
    for (const SegmentSound &sound : segment.sounds)
      out.bytes(sound.bytes);
  });
  return bytes;
}

} // namespace haptic
