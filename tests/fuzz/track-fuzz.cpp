// SPDX-License-Identifier: LGPL-2.1-or-later
// Feeds damaged tracks to every parser: whole ones with mutations, always the same ones. Built with
// the sanitizers, any finding ends the program.
//
//   track-fuzz [PARSER [INPUTS [SEED]]]     PARSER: klv, pointer, text, field, relief,
//                                           hmpg, hjif, rtp or all
//   track-fuzz PARSER --seeds FOLDER        writes the whole ones
//   track-fuzz PARSER --file FILE           feeds one input
//
// Built by afl++ (coverage.sh), `track-fuzz PARSER` gets its inputs from afl-fuzz.
#include "depth-scene.hpp"
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "leaf-fields.hpp"
#include "mpeg-haptics/bits.hpp"
#include "mpeg-haptics/hjif.hpp"
#include "mpeg-haptics/hmpg-rtp.hpp"
#include "mpeg-haptics/hmpg-track.hpp"
#include "mutator.hpp"
#include "track-samples.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <unistd.h> // read(), in the macros of afl++

#ifdef __AFL_COMPILER
__AFL_FUZZ_INIT();
#endif

namespace {

constexpr std::size_t kLargestAllocation = std::size_t{64} << 20; // bytes
std::size_t largest_allocation = 0;

} // namespace

// Counts what is asked for, and ends the program where it is too much. Inlined, GCC 14 would
// compare malloc() with the operator that frees.
[[gnu::noinline]] void *operator new(std::size_t size) {
  largest_allocation = std::max(largest_allocation, size);
  void *memory = size <= kLargestAllocation ? std::malloc(size) : nullptr;
  if (!memory) {
    std::fprintf(stderr, "an allocation of %zu bytes\n", size);
    std::abort();
  }
  return memory;
}
[[gnu::noinline]] void *operator new(std::size_t size,
                                     const std::nothrow_t &) noexcept { // of std::stable_sort
  return operator new(size);
}
[[gnu::noinline]] void operator delete(void *memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::size_t) noexcept {
  std::free(memory);
}

namespace {

using test::Bytes;

void require(bool condition, const char *what) {
  if (!condition) {
    std::fprintf(stderr, "%s\n", what);
    std::abort();
  }
}

void require_valid(const haptic::MotionSample &sample) {
  require(haptic::is_valid(sample), "a sample that is not valid got through");
}

// ---- seeds --------------------------------------------------------------------------------------

std::vector<haptic::TrackSample> track() {
  test::TrackSamples random(1);
  std::vector<haptic::TrackSample> samples;
  for (std::uint64_t i = 0; i < 12; ++i) {
    samples.push_back(random.next());
    samples.back().time = i * 33'333'333;
    samples.back().duration = 33'333'333;
  }
  return samples;
}

std::vector<Bytes> fields() {
  test::LeafFields leaves(1);
  haptic::FieldEncoder encoder;
  std::vector<Bytes> coded;
  while (coded.size() < 4)
    coded.push_back(encoder.push(leaves.next()).value());
  return coded;
}

Bytes things() {
  const haptic::FieldThing two[] = {{1, haptic::HoldState::held, 0.25F, 0.5F, 0.01F},
                                    {2, haptic::HoldState::hidden, 1, 0, 0.02F}};
  Bytes packed(haptic::packed_size(two));
  haptic::pack_field_things(two, packed);
  return packed;
}

std::vector<Bytes> reliefs() {
  haptic::ReliefEncoder encoder;
  std::vector<Bytes> coded;
  while (coded.size() < 4)
    coded.push_back(
        encoder.push(test::DepthScene::relief(static_cast<int>(coded.size()), 16)).value());
  return coded;
}

Bytes bytes_of(const std::string &text) {
  return {text.begin(), text.end()};
}

std::vector<Bytes> units() {
  haptic::HmpgEncoder encoder(100'000'000, "2026-01-01");
  std::vector<Bytes> result;
  const auto take = [&](const std::vector<haptic::CodedUnit> &coded) {
    for (const auto &unit : coded)
      result.push_back(unit.bytes);
  };
  for (const auto &sample : track())
    take(encoder.push(sample.motion, sample.time, sample.duration));
  take(encoder.finish());
  return result;
}

// An initialization unit whose library has an effect, and a unit that refers to it, in Akima's
// curve.
Bytes library_stream() {
  auto experience = haptic::track_experience("2026-01-01");
  experience.bands[0].curve = haptic::CurveType::akima;
  const Bytes init = haptic::write_initialization_unit(experience);
  haptic::BitWriter library;
  library.put(6, 6); // the packet's header
  library.put(36, 17);
  library.put(0, 1);
  library.put(0, 8); // perception
  library.put(1, 16);
  library.put(5, 16); // id
  library.put(0, 25 + 16 + 4 + 2);
  library.put(6, 16);
  for (unsigned i = 0; i < 6; ++i) {
    library.put(3, 3);
    library.put(100 * i, 16);
    library.put(40 * i, 8);
  }
  library.put(0, 32);
  const auto append_unit = [](Bytes &stream, unsigned type, const Bytes &payload) {
    haptic::BitWriter header;
    header.put(type, 12);
    header.put(type == 64 ? 500 : 0, 24);
    header.put(payload.size(), 36U - 4);
    header.put(0, 4);
    stream.insert(stream.end(), header.bytes().begin(), header.bytes().end());
    stream.insert(stream.end(), payload.begin(), payload.end());
  };
  Bytes payload(init.begin() + haptic::kUnitHeaderSize, init.end());
  payload.insert(payload.end(), library.bytes().begin(), library.bytes().begin() + 3 + 36);
  haptic::BitWriter data;
  data.put(5, 6);
  data.put(12, 17);
  data.put(0, 1 + 1 + 8 + 16 + 8); // the header's end, independent, perception, channel, band
  data.put(1, 16);
  data.put(5, 16);
  data.put(1, 2); // a reference
  data.put(20, 25);
  Bytes stream;
  append_unit(stream, 0, payload);
  append_unit(stream, 64, data.bytes());
  return stream;
}

constexpr char kLibraryJson[] =
    R"({"version":"2023","timescale":1000,"perceptions":[{"perception_modality":"Force",)"
    R"("channels":[{"gain":2,"direction":{"X":127,"Y":0,"Z":0},"bands":[{"band_type":"Curve",)"
    R"("curve_type":"Akima","effects":[{"effect_type":"Reference","id":3,"position":50},)"
    R"({"effect_type":"Basis","position":9,"keyframes":[{"relative_position":0,)"
    R"("amplitude_modulation":0.5},{"relative_position":40,"amplitude_modulation":-1},)"
    R"({"relative_position":90,"amplitude_modulation":1}]}]}]}],"effect_library":[{"id":3,)"
    R"("effect_type":"Basis","position":0,"keyframes":[{"relative_position":0,)"
    R"("amplitude_modulation":0.1},{"relative_position":99,"amplitude_modulation":0.9}]}]}]})";

// ---- parsers ------------------------------------------------------------------------------------

struct Parser {
  const char *name;
  std::vector<Bytes> seeds;
  void (*parse)(const Bytes &bytes);
};

template <typename Decoder>
void decode_field(Decoder &decoder, std::span<const std::uint8_t> bytes) {
  if (decoder.push(bytes) == Decoder::Result::field)
    require(is_valid(decoder.field()) && (!decoder.rested() || is_valid(decoder.rest())),
            "a field that is not valid got through");
}

void require_valid_things(std::span<const std::uint8_t> bytes) {
  std::vector<haptic::FieldThing> things;
  require(haptic::unpack_field_things(bytes, things), "things that are not valid got through");
}

void decode_field(haptic::FieldKind kind, std::span<const std::uint8_t> bytes) {
  haptic::FieldDecoder fields;
  haptic::ReliefDecoder reliefs;
  if (kind == haptic::FieldKind::relief)
    decode_field(reliefs, bytes);
  else
    decode_field(fields, bytes);
}

// Coded fields with their length, two bytes, before each, and one decoder all along.
template <typename Decoder>
void parse_fields(const Bytes &bytes) {
  Decoder decoder;
  for (std::size_t at = 0; at + 2 <= bytes.size();) {
    const std::size_t size =
        std::min<std::size_t>(bytes[at] | bytes[at + 1] << 8, bytes.size() - at - 2);
    decode_field(decoder, std::span(bytes).subspan(at + 2, size));
    at += 2 + size;
  }
}

void parse_klv(const Bytes &bytes) {
  haptic::KlvReader reader(bytes);
  std::size_t items = 0;
  while (const auto item = reader.next()) {
    require(++items <= bytes.size(), "more items than bytes");
    require(item->offset <= bytes.size(), "an offset beyond the end");
    if (item->kind == haptic::KlvKind::motion)
      require_valid(item->sample.motion);
    if (item->kind == haptic::KlvKind::field)
      decode_field(item->field_kind, item->field);
    require_valid_things(item->things);
  }
}

void parse_pointer(const Bytes &bytes) {
  if (const auto pointer = haptic::read_klv_pointer(bytes))
    require(pointer->x >= 0 && pointer->x <= 1 && pointer->y >= 0 && pointer->y <= 1 &&
                pointer->z >= -1 && pointer->z <= 1 &&
                pointer->device.size() <= haptic::kLongestDeviceName,
            "a pointer out of its range got through");
}

void parse_text(const Bytes &bytes) {
  const auto line =
      haptic::read_text_line({reinterpret_cast<const char *>(bytes.data()), bytes.size()});
  if (line.sample)
    require_valid(line.sample->motion);
  else if (line.field) {
    decode_field(line.field->kind, line.field->bytes);
    require_valid_things(line.field->things);
  } else
    require(!line.error.empty(), "refused without a reason");
}

// The stream as a parser cuts it, with one decoder all along.
void parse_hmpg(const Bytes &bytes) {
  haptic::HmpgDecoder decoder;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto rest = std::span(bytes).subspan(at);
    const auto header = haptic::read_unit_header(rest);
    if (!header || haptic::kUnitHeaderSize + header->length > rest.size()) {
      const auto unit = haptic::read_unit(rest, nullptr);
      require(unit.error.has_value() && unit.error->offset <= rest.size(),
              "a damaged unit got through");
      ++at;
      continue;
    }
    const std::size_t size = haptic::kUnitHeaderSize + header->length;
    for (const auto &sample : decoder.push(rest.first(size), haptic::kNoTime).samples)
      require_valid(sample.motion);
    at += size;
  }
  for (const auto &sample : decoder.finish().samples)
    require_valid(sample.motion);
}

void parse_hjif(const Bytes &bytes) {
  const auto read = haptic::read_hjif({reinterpret_cast<const char *>(bytes.data()), bytes.size()});
  for (const auto &sample : read.samples)
    require_valid(sample.motion);
  require(read.offset <= bytes.size(), "an offset beyond the end");
}

// Packets with a length byte before each.
void parse_rtp(const Bytes &bytes) {
  haptic::UnitAssembler assembler;
  haptic::HmpgDecoder decoder;
  std::uint16_t sequence = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t size = std::min<std::size_t>(bytes[at], bytes.size() - at - 1);
    sequence = static_cast<std::uint16_t>(sequence + (bytes[at] == 77 ? 2 : 1));
    const auto result = assembler.push(sequence, std::span(bytes).subspan(at + 1, size));
    for (const auto &unit : result.units)
      for (const auto &sample : decoder.push(unit, at).samples)
        require_valid(sample.motion);
    at += 1 + size;
  }
}

std::vector<Parser> parsers() {
  Parser klv{"klv", {}, parse_klv};
  Parser text{"text", {}, parse_text};
  for (const auto &sample : track()) {
    klv.seeds.push_back(write_klv(sample));
    text.seeds.push_back(bytes_of(write_text_line(sample)));
  }
  const auto add_fields = [&](haptic::FieldKind kind, const std::vector<Bytes> &coded,
                              Parser parser) {
    Bytes sequence;
    for (const auto &bytes : coded) {
      klv.seeds.push_back(write_klv(haptic::CodedField{bytes, 1, 2, kind}));
      text.seeds.push_back(bytes_of(write_text_line(haptic::CodedField{bytes, 1, 2, kind})));
      if (kind == haptic::FieldKind::motion) {
        const haptic::CodedField with_things{bytes, 1, 2, kind, things()};
        klv.seeds.push_back(write_klv(with_things));
        text.seeds.push_back(bytes_of(write_text_line(with_things)));
      }
      sequence.push_back(static_cast<std::uint8_t>(bytes.size()));
      sequence.push_back(static_cast<std::uint8_t>(bytes.size() >> 8));
      sequence.insert(sequence.end(), bytes.begin(), bytes.end());
    }
    parser.seeds.push_back(sequence);
    return parser;
  };
  const Parser field = add_fields(haptic::FieldKind::motion, fields(),
                                  {"field", {}, parse_fields<haptic::FieldDecoder>});
  const Parser relief = add_fields(haptic::FieldKind::relief, reliefs(),
                                   {"relief", {}, parse_fields<haptic::ReliefDecoder>});
  Bytes stream;
  Bytes packets;
  std::vector<Bytes> hmpg = units();
  for (const auto &unit : hmpg) {
    stream.insert(stream.end(), unit.begin(), unit.end());
    for (const auto &payload : haptic::packetize_unit(unit, 60)) {
      packets.push_back(static_cast<std::uint8_t>(payload.size()));
      for (const auto bytes : {std::span<const std::uint8_t>(payload.head), payload.part})
        packets.insert(packets.end(), bytes.begin(), bytes.end());
    }
  }
  hmpg.push_back(stream);
  hmpg.push_back(library_stream());
  return {klv,
          {"pointer",
           {write_klv(haptic::TrackPointer{7, 0.2, 0.8, -0.5, true, "SPIDAR"})},
           parse_pointer},
          text,
          field,
          relief,
          {"hmpg", hmpg, parse_hmpg},
          {"hjif",
           {bytes_of(haptic::write_hjif(track(), "2026-01-01")), bytes_of(kLibraryJson)},
           parse_hjif},
          {"rtp", {packets}, parse_rtp}};
}

#ifdef __AFL_COMPILER
void fuzz_for_afl(const Parser &parser) {
  __AFL_INIT();
  const unsigned char *input = __AFL_FUZZ_TESTCASE_BUF;
  while (__AFL_LOOP(10'000))
    parser.parse(Bytes(input, input + __AFL_FUZZ_TESTCASE_LEN));
}
#endif

void write_seeds(const Parser &parser, const std::string &folder) {
  for (std::size_t i = 0; i < parser.seeds.size(); ++i) {
    std::ofstream file(folder + "/" + std::to_string(i), std::ios::binary);
    file.write(reinterpret_cast<const char *>(parser.seeds[i].data()),
               static_cast<std::streamsize>(parser.seeds[i].size()));
  }
}

void parse_file(const Parser &parser, const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  parser.parse(Bytes(std::istreambuf_iterator<char>(file), {}));
}

void fuzz(const Parser &parser, std::uint64_t inputs, unsigned seed) {
  const auto begin = std::chrono::steady_clock::now();
  test::Mutator mutator(seed);
  Bytes bytes;
  for (std::uint64_t i = 0; i < inputs; ++i) {
    bytes = parser.seeds[mutator.below(parser.seeds.size())];
    mutator.mutate(bytes, parser.seeds);
    parser.parse(bytes);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("%s: %llu inputs, no finding, %.1f s, largest allocation %zu bytes\n", parser.name,
              static_cast<unsigned long long>(inputs), took.count(), largest_allocation);
}

} // namespace

int main(int argc, char **argv) {
  const std::string which = argc > 1 ? argv[1] : "all";
  const std::uint64_t inputs = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 20'000;
  const unsigned seed = argc > 3 ? static_cast<unsigned>(std::atoi(argv[3])) : 1;
  bool any = false;
  const std::string option = argc > 3 ? argv[2] : "";
  for (const auto &parser : parsers()) {
    if (which != "all" && which != parser.name)
      continue;
    any = true;
    if (option == "--seeds") {
      write_seeds(parser, argv[3]);
      continue;
    }
    if (option == "--file") {
      parse_file(parser, argv[3]);
      continue;
    }
#ifdef __AFL_COMPILER
    if (argc == 2) {
      fuzz_for_afl(parser);
      continue;
    }
#endif
    fuzz(parser, inputs, seed);
  }
  if (!any)
    std::fprintf(stderr, "there is no parser '%s'\n", which.c_str());
  return any ? EXIT_SUCCESS : EXIT_FAILURE;
}
