// SPDX-License-Identifier: LGPL-2.1-or-later
// Feeds damaged tracks to every parser: whole ones with mutations, always the same ones. Built with
// the sanitizers, any finding ends the program.
//
//   track-fuzz [PARSER [INPUTS [SEED]]]     PARSER: klv, pointer, text, field, hmpg,
//                                           hjif, rtp or all
#include "field-codec.hpp"
#include "hjif.hpp"
#include "hmpg-rtp.hpp"
#include "hmpg-track.hpp"
#include "klv.hpp"
#include "leaf-fields.hpp"
#include "text-line.hpp"
#include "track-samples.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>

namespace {

constexpr std::size_t kLargestAllocation = std::size_t{64} << 20; // bytes
std::size_t largest_allocation = 0;

} // namespace

// Counts what is asked for, and ends the program where it is too much.
void *operator new(std::size_t size) {
  largest_allocation = std::max(largest_allocation, size);
  void *memory = size <= kLargestAllocation ? std::malloc(size) : nullptr;
  if (!memory) {
    std::fprintf(stderr, "an allocation of %zu bytes\n", size);
    std::abort();
  }
  return memory;
}
void operator delete(void *memory) noexcept {
  std::free(memory);
}
void operator delete(void *memory, std::size_t) noexcept {
  std::free(memory);
}

namespace {

using Bytes = std::vector<std::uint8_t>;

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

// ---- mutation -----------------------------------------------------------------------------------

class Mutator {
public:
  explicit Mutator(unsigned seed) : state_(seed * 2654435761U + 1) {}

  std::uint32_t number() { // xorshift: the mutations must not cost more than the parsers
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<std::uint32_t>(state_ >> 16);
  }
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : number() % limit; }

  void mutate(Bytes &bytes, std::span<const Bytes> seeds) {
    constexpr std::array<std::uint8_t, 9> kTelling = {0, 1, 0x7F, 0x80, 0xFF, 0x82, '0', '"', '['};
    for (auto times = 1 + below(4); times > 0; --times) {
      const std::size_t at = below(bytes.size());
      const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      switch (bytes.empty() ? 4U : number() % 7) {
      case 0:
        bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1U << below(8));
        break;
      case 1:
        bytes[at] = static_cast<std::uint8_t>(number());
        break;
      case 2:
        bytes[at] = kTelling[below(kTelling.size())];
        break;
      case 3:
        bytes.resize(at);
        break;
      case 4: { // another one from there on
        const Bytes &other = seeds[below(seeds.size())];
        const auto from = static_cast<std::ptrdiff_t>(below(other.size()));
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), other.begin() + from,
                     other.end());
        break;
      }
      case 5:
        bytes.erase(place, place + static_cast<std::ptrdiff_t>(1 + below(bytes.size() - at)));
        break;
      default:
        bytes.insert(place, static_cast<std::uint8_t>(number()));
        break;
      }
    }
  }

private:
  std::uint64_t state_;
};

// ---- parsers ------------------------------------------------------------------------------------

struct Parser {
  const char *name;
  std::vector<Bytes> seeds;
  void (*parse)(const Bytes &bytes);
};

void decode_field(haptic::FieldDecoder &decoder, std::span<const std::uint8_t> bytes) {
  if (decoder.push(bytes) == haptic::FieldDecoder::Result::field)
    require(is_valid(decoder.field()) && (!decoder.rested() || is_valid(decoder.rest())),
            "a field that is not valid got through");
  require(!decoder.has_field() || is_valid(decoder.field()), "silence that is not valid");
}

void decode_field(std::span<const std::uint8_t> bytes) {
  haptic::FieldDecoder decoder;
  decode_field(decoder, bytes);
}

// Coded fields with their length, two bytes, before each, and one decoder all along.
void parse_fields(const Bytes &bytes) {
  haptic::FieldDecoder decoder;
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
      decode_field(item->field);
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
  else if (line.field)
    decode_field(line.field->bytes);
  else
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
    if (!result.unit.empty())
      for (const auto &sample : decoder.push(result.unit, at).samples)
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
  Parser field{"field", {}, parse_fields};
  Bytes sequence;
  for (const auto &bytes : fields()) {
    klv.seeds.push_back(write_klv(haptic::CodedField{bytes, 1, 2}));
    text.seeds.push_back(bytes_of(write_text_line(haptic::CodedField{bytes, 1, 2})));
    sequence.push_back(static_cast<std::uint8_t>(bytes.size()));
    sequence.push_back(static_cast<std::uint8_t>(bytes.size() >> 8));
    sequence.insert(sequence.end(), bytes.begin(), bytes.end());
  }
  field.seeds.push_back(sequence);
  Bytes stream;
  Bytes packets;
  std::vector<Bytes> hmpg = units();
  for (const auto &unit : hmpg) {
    stream.insert(stream.end(), unit.begin(), unit.end());
    for (const auto &payload : haptic::packetize_unit(unit, 60)) {
      packets.push_back(static_cast<std::uint8_t>(payload.size()));
      packets.insert(packets.end(), payload.begin(), payload.end());
    }
  }
  hmpg.push_back(stream);
  return {klv,
          {"pointer",
           {write_klv(haptic::TrackPointer{7, 0.2, 0.8, -0.5, true, "SPIDAR"})},
           parse_pointer},
          text,
          field,
          {"hmpg", hmpg, parse_hmpg},
          {"hjif", {bytes_of(haptic::write_hjif(track(), "2026-01-01"))}, parse_hjif},
          {"rtp", {packets}, parse_rtp}};
}

void fuzz(const Parser &parser, std::uint64_t inputs, unsigned seed) {
  const auto begin = std::chrono::steady_clock::now();
  Mutator mutator(seed);
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
  for (const auto &parser : parsers())
    if (which == "all" || which == parser.name) {
      fuzz(parser, inputs, seed);
      any = true;
    }
  if (!any)
    std::fprintf(stderr, "there is no parser '%s'\n", which.c_str());
  return any ? EXIT_SUCCESS : EXIT_FAILURE;
}
