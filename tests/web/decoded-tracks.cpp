// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes coded fields and KLV sets, whole and damaged, with what the C++ readers make of them, for
// web-decoder-test.mjs:
//
//   decoded-tracks GOLDEN.klv GOLDEN-RELIEF.klv COUNT >tracks.bin
//
// Numbers are little-endian. A record is its type (u8: 0 a new stream, 1 a coded field of the
// stream, 2 KLV, 3 a new stream of reliefs), the bytes with their length (u32) and the number of
// numbers with them (u32).
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "mutator.hpp"
#include "track-samples.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>

namespace {

using test::Bytes;

// FNV-1a of whole numbers.
class Hash {
public:
  void add(std::uint32_t number) { value_ = (value_ ^ number) * 16777619U; }
  void add(float number) { add(std::bit_cast<std::uint32_t>(number)); }
  std::uint32_t value() const { return value_; }

private:
  std::uint32_t value_ = 2166136261U;
};

void put(std::uint32_t number) {
  for (int shift = 0; shift < 32; shift += 8)
    std::putchar(static_cast<int>(number >> shift & 0xFF));
}

enum Record { kNewStream, kCode, kKlv, kNewReliefs };

void put_record(Record type, std::span<const std::uint8_t> bytes,
                const std::vector<std::uint32_t> &numbers) {
  std::putchar(type);
  put(static_cast<std::uint32_t>(bytes.size()));
  for (const auto byte : bytes)
    std::putchar(byte);
  put(static_cast<std::uint32_t>(numbers.size()));
  for (const auto number : numbers)
    put(number);
}

std::array<float, 3> values_of(const haptic::FieldCell &cell) {
  return {cell.velocity_x, cell.velocity_y, cell.confidence};
}

std::array<float, 4> values_of(const haptic::ReliefCell &cell) {
  return {cell.height, cell.stiffness, cell.friction, cell.validity};
}

template <typename Cell>
std::uint32_t hash_of(const haptic::Field<Cell> &field) {
  Hash hash;
  const std::uint64_t interval = field.interval / 1000; // us
  for (const auto number :
       {static_cast<std::uint32_t>(interval), static_cast<std::uint32_t>(interval >> 32),
        std::uint32_t{field.flags}, std::uint32_t{field.columns}, std::uint32_t{field.rows},
        field.frame_width, field.frame_height, field.pixel_aspect_n, field.pixel_aspect_d})
    hash.add(number);
  for (const auto &cell : field.cells)
    for (const float value : values_of(cell))
      hash.add(value);
  return hash.value();
}

template <typename Cells>
void put_field(haptic::GridDecoder<Cells> &decoder, std::span<const std::uint8_t> bytes) {
  const auto result = decoder.push(bytes);
  std::vector<std::uint32_t> numbers = {static_cast<std::uint32_t>(result), decoder.lost()};
  if (result == haptic::GridDecoder<Cells>::Result::field) {
    numbers.push_back(hash_of(decoder.field()));
    if (decoder.rested())
      numbers.push_back(hash_of(decoder.rest()));
  }
  put_record(kCode, bytes, numbers);
}

std::uint32_t hash_of(const haptic::MotionSample &s) {
  Hash hash;
  for (const float value :
       {s.velocity_x, s.velocity_y, s.spin, s.divergence, s.pointer_x, s.pointer_y, s.region_width,
        s.region_height, s.confidence, s.held.x, s.held.y, s.held.radius})
    hash.add(value);
  for (const auto number :
       {std::uint32_t{s.flags}, s.frame_width, s.frame_height, s.pixel_aspect_n, s.pixel_aspect_d,
        std::uint32_t{s.points}, static_cast<std::uint32_t>(s.model),
        static_cast<std::uint32_t>(s.held.state)})
    hash.add(number);
  return hash.value();
}

// The number of a kind of item that KlvKind has not.
constexpr std::uint32_t kRelief = static_cast<std::uint32_t>(haptic::KlvKind::damaged) + 1;

void put_klv(std::span<const std::uint8_t> bytes) {
  haptic::KlvReader reader(bytes);
  std::vector<std::uint32_t> numbers;
  while (const auto item = reader.next()) {
    const bool is_relief =
        item->kind == haptic::KlvKind::field && item->field_kind == haptic::FieldKind::relief;
    numbers.push_back(is_relief ? kRelief : static_cast<std::uint32_t>(item->kind));
    numbers.push_back(static_cast<std::uint32_t>(item->offset));
    Hash hash;
    if (item->kind == haptic::KlvKind::motion)
      numbers.push_back(hash_of(item->sample.motion));
    if (item->kind == haptic::KlvKind::field)
      for (const auto bytes_of_item : {item->field, item->things})
        for (const auto byte : bytes_of_item)
          hash.add(std::uint32_t{byte});
    numbers.push_back(hash.value());
  }
  put_record(kKlv, bytes, numbers);
}

// Fields of few cells with every kind of change: cuts, rests, other grids, other intervals.
class OddFields {
public:
  explicit OddFields(unsigned seed) : random_(seed) {}

  haptic::MotionField next() {
    if (below(40) == 0)
      change_grid();
    if (below(10) == 0)
      rests_ = !rests_;
    if (below(20) == 0)
      speed_ = std::exp(number(-2, 10));
    field_.flags = static_cast<std::uint16_t>(below(30) == 0 ? 1 + below(15) : 0);
    for (auto &cell : field_.cells) {
      if (below(4) == 0)
        cell.confidence = static_cast<float>(number(-0.3, 1) < 0 ? 0 : number(0, 1));
      if (below(3) == 0)
        cell.velocity_x = static_cast<float>(number(-speed_, speed_));
      if (below(3) == 0)
        cell.velocity_y = static_cast<float>(number(-speed_, speed_));
      if (rests_ || cell.confidence == 0)
        cell.velocity_x = cell.velocity_y = 0;
    }
    return field_;
  }
  unsigned below(unsigned limit) { return static_cast<unsigned>(random_() % limit); }

private:
  double number(double from, double to) {
    return from + (to - from) * static_cast<double>(random_()) / static_cast<double>(random_.max());
  }
  void change_grid() {
    field_.columns = static_cast<std::uint16_t>(1 + below(9));
    field_.rows = static_cast<std::uint16_t>(1 + below(6));
    field_.frame_width = 1 + below(4000);
    field_.frame_height = 1 + below(4000);
    field_.pixel_aspect_n = 1 + below(20);
    field_.pixel_aspect_d = 1 + below(20);
    // Up to the longest there is.
    field_.interval = below(3) ? 33'333'333 : static_cast<std::uint64_t>(std::exp(number(0, 44)));
    field_.cells.assign(std::size_t{field_.columns} * field_.rows, {});
  }

  std::mt19937 random_;
  haptic::MotionField field_ = {
      33'333'333, 640, 360, 1, 1, 0, 4, 3, std::vector<haptic::FieldCell>(12)};
  bool rests_ = false;
  double speed_ = 100; // px/s
};

// Reliefs of few cells with every kind of change: cuts, holes, other grids, other ranges of height.
class OddReliefs {
public:
  explicit OddReliefs(unsigned seed) : random_(seed) { change_grid(); }

  haptic::ReliefField next() {
    if (below(40) == 0)
      change_grid();
    if (below(50) == 0)
      range_ = std::exp(number(-9, 0));
    field_.flags = static_cast<std::uint16_t>(below(30) == 0 ? 1 + below(15) : 0);
    const unsigned still = below(8);
    for (auto &cell : field_.cells) {
      if (below(3) == 0 && still > 0)
        cell.height = static_cast<float>(number(-range_, range_));
      if (below(20) == 0)
        change_material(cell);
    }
    return field_;
  }
  unsigned below(unsigned limit) { return static_cast<unsigned>(random_() % limit); }

private:
  double number(double from, double to) {
    return from + (to - from) * static_cast<double>(random_()) / static_cast<double>(random_.max());
  }
  void change_material(haptic::ReliefCell &cell) {
    if (below(4) == 0) {
      cell = {};
      return;
    }
    cell.validity = static_cast<float>(number(0.01, 1));
    cell.stiffness = static_cast<float>(std::exp(number(-2, std::log(1e5))));
    cell.friction = static_cast<float>(number(0, 1) * number(0, 10));
  }
  void change_grid() {
    field_.columns = static_cast<std::uint16_t>(1 + below(9));
    field_.rows = static_cast<std::uint16_t>(1 + below(6));
    field_.frame_width = 1 + below(4000);
    field_.frame_height = 1 + below(4000);
    field_.interval = below(3) ? 33'333'333 : static_cast<std::uint64_t>(std::exp(number(0, 44)));
    field_.cells.assign(std::size_t{field_.columns} * field_.rows, {});
    for (auto &cell : field_.cells)
      change_material(cell);
  }

  std::mt19937 random_;
  haptic::ReliefField field_;
  double range_ = 0.02; // m
};

template <typename Cells>
void put_golden(const std::string &path, Record stream, std::vector<Bytes> &sets) {
  std::ifstream file(path, std::ios::binary);
  const Bytes track(std::istreambuf_iterator<char>(file), {});
  if (track.empty())
    std::exit(EXIT_FAILURE);
  put_klv(track);
  put_record(stream, {}, {});
  haptic::GridDecoder<Cells> decoder;
  haptic::KlvReader reader(track);
  while (const auto item = reader.next()) {
    if (item->kind != haptic::KlvKind::field)
      continue;
    put_field(decoder, item->field);
    sets.push_back(write_klv(haptic::coded_field_of(*item)));
  }
}

// Streams that lose a field now and then; each other field comes twice damaged before it comes
// whole.
template <typename Cells, typename Fields>
void put_streams(unsigned count, Record stream, Fields fields) {
  test::Mutator mutator(2);
  std::vector<Bytes> before;
  haptic::GridEncoder<Cells> encoder;
  haptic::GridDecoder<Cells> decoder;
  for (unsigned i = 0; i < count; ++i) {
    if (i % 1000 == 0) {
      put_record(stream, {}, {});
      encoder = haptic::GridEncoder<Cells>(haptic::kKeyInterval,
                                           static_cast<std::uint8_t>(fields.below(256)));
      decoder = {};
      before.clear();
    }
    const auto coded = encoder.push(fields.next());
    if (!coded || fields.below(20) == 0)
      continue;
    before.push_back(*coded);
    for (int times = 0; times < 2; ++times) {
      Bytes damaged = *coded;
      mutator.mutate(damaged, before);
      put_field(decoder, damaged);
    }
    put_field(decoder, *coded);
  }
}

} // namespace

int main(int argc, char **argv) {
  if (argc != 4)
    return EXIT_FAILURE;
  const auto count = static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10));
  std::vector<Bytes> sets;
  put_golden<haptic::MotionCells>(argv[1], kNewStream, sets);
  put_golden<haptic::ReliefCells>(argv[2], kNewReliefs, sets);
  put_streams<haptic::MotionCells>(count, kNewStream, OddFields(1));
  put_streams<haptic::ReliefCells>(count, kNewReliefs, OddReliefs(1));
  test::TrackSamples samples(1);
  for (int i = 0; i < 12; ++i)
    sets.push_back(write_klv(samples.next()));
  for (std::size_t size = 0; size <= haptic::kMostFieldThings; size += 4) {
    haptic::CodedField field{{1, 2, 3}};
    const std::vector<haptic::FieldThing> things(size, {7, haptic::HoldState::held, 0.5F, 0.5F});
    field.things.resize(packed_size(things));
    pack_field_things(things, field.things);
    sets.push_back(write_klv(field));
  }
  test::Mutator mutator(3);
  for (unsigned i = 0; i < count / 4; ++i) {
    Bytes bytes = sets[mutator.below(sets.size())];
    mutator.mutate(bytes, sets);
    put_klv(bytes);
  }
  return EXIT_SUCCESS;
}
