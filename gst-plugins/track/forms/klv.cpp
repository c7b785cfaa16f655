// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/klv.hpp"

#include "samples/motion-field.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <initializer_list>

namespace haptic {
namespace {

using Bytes = std::span<const std::uint8_t>;
constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kPointSample = 0;
constexpr std::uint8_t kFieldSample = 1;
constexpr std::uint8_t kReliefSample = 2;

enum MotionTag : std::uint8_t {
  kTagVersion = 1,
  kTagKind,
  kTagTime,
  kTagDuration,
  kTagFlags,
  kTagInterval,
  kTagVelocity,
  kTagSpin,
  kTagDivergence,
  kTagPointer,
  kTagRegion,
  kTagConfidence,
  kTagFrame,
  kTagPixelAspect,
  kTagPoints,
  kTagModel,
  kTagHeld,
  kTagHeldPlace,
  kTagHeldRadius,
  kTagHeldTime,
  kTagField = 32,
  kTagRelief = 33,
  kTagThings = 34,
  kMotionTags
};

enum PointerTag : std::uint8_t {
  kTagPointerVersion = 1,
  kTagSequence,
  kTagPosition,
  kTagDepth,
  kTagPressed,
  kTagDevice,
  kPointerTags
};

// ---- writing ------------------------------------------------------------------------------------

class SetWriter {
public:
  explicit SetWriter(const KlvKey &key) : bytes_(key.begin(), key.end()) {
    // The length has two bytes in BER's long form, so that finish() can fill it in.
    bytes_.insert(bytes_.end(), {0x82, 0, 0});
  }

  void unsigned_values(std::uint8_t tag, std::size_t size,
                       std::initializer_list<std::uint64_t> values) {
    begin(tag, size * values.size());
    for (const auto value : values)
      for (std::size_t i = size; i-- > 0;)
        bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void floats(std::uint8_t tag, std::initializer_list<float> values) {
    begin(tag, 4 * values.size());
    for (const auto value : values) {
      const auto bits = std::bit_cast<std::uint32_t>(value);
      for (int shift = 24; shift >= 0; shift -= 8)
        bytes_.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }
  void doubles(std::uint8_t tag, std::initializer_list<double> values) {
    begin(tag, 8 * values.size());
    for (const auto value : values) {
      const auto bits = std::bit_cast<std::uint64_t>(value);
      for (int shift = 56; shift >= 0; shift -= 8)
        bytes_.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }
  /// Fewer than 64 KiB.
  template <typename Text>
  void bytes(std::uint8_t tag, const Text &bytes) {
    begin(tag, bytes.size());
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }

  std::vector<std::uint8_t> finish() {
    const std::size_t length = bytes_.size() - kMotionKey.size() - 3;
    bytes_[kMotionKey.size() + 1] = static_cast<std::uint8_t>(length >> 8);
    bytes_[kMotionKey.size() + 2] = static_cast<std::uint8_t>(length);
    return std::move(bytes_);
  }

private:
  void begin(std::uint8_t tag, std::size_t length) {
    bytes_.push_back(tag);
    if (length >= 0x80) {
      bytes_.push_back(0x82);
      bytes_.push_back(static_cast<std::uint8_t>(length >> 8));
    }
    bytes_.push_back(static_cast<std::uint8_t>(length));
  }

  std::vector<std::uint8_t> bytes_;
};

// ---- reading ------------------------------------------------------------------------------------

// Reads a BER length at `at` and moves `at` behind it. Returns nothing if it is cut off, indefinite
// or larger than the rest.
std::optional<std::size_t> read_length(Bytes bytes, std::size_t &at) {
  if (at >= bytes.size())
    return std::nullopt;
  const std::uint8_t first = bytes[at++];
  std::uint64_t length = first;
  if (first >= 0x80) {
    const std::size_t count = first & 0x7FU;
    if (count == 0 || count > 8 || count > bytes.size() - at)
      return std::nullopt;
    length = 0;
    for (std::size_t i = 0; i < count; ++i)
      length = length << 8 | bytes[at++];
  }
  if (length > bytes.size() - at)
    return std::nullopt;
  return static_cast<std::size_t>(length);
}

std::uint64_t read_unsigned(Bytes bytes) {
  std::uint64_t value = 0;
  for (const auto byte : bytes)
    value = value << 8 | byte;
  return value;
}

float read_float(Bytes bytes) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(read_unsigned(bytes.first(4))));
}

double read_double(Bytes bytes) {
  return std::bit_cast<double>(read_unsigned(bytes.first(8)));
}

// The values of a local set by their tags. A tag that is absent has no data.
template <std::size_t kTags>
struct Set {
  std::array<Bytes, kTags> values;
  std::array<std::size_t, kTags> offsets{}; // in the set
  const char *error = nullptr;
  std::size_t offset = 0; // of the error
};

template <std::size_t kTags>
Set<kTags> read_set(Bytes bytes) {
  Set<kTags> set;
  std::size_t at = 0;
  while (at < bytes.size()) {
    const std::size_t begin = at;
    const std::uint8_t first = bytes[at++];
    std::uint8_t tag = first;
    // A tag of several bytes (BER-OID) belongs to a later version.
    while (at < bytes.size() && (bytes[at - 1] & 0x80U) != 0)
      ++at;
    if ((first & 0x80U) != 0)
      tag = 0;
    const auto length = read_length(bytes, at);
    if (!length) {
      set.error = "a length leads beyond the end of the set";
      set.offset = begin;
      return set;
    }
    if (tag > 0 && tag < kTags) {
      if (set.values[tag].data()) {
        set.error = "a tag is there twice";
        set.offset = begin;
        return set;
      }
      set.values[tag] = bytes.subspan(at, *length);
      set.offsets[tag] = at;
    }
    at += *length;
  }
  return set;
}

struct MotionValue {
  std::uint8_t tag;
  std::uint8_t size; // bytes
  bool needed;
};

constexpr MotionValue kMotionValues[] = {
    {kTagTime, 8, false},      {kTagDuration, 8, false},   {kTagFlags, 2, true},
    {kTagInterval, 8, true},   {kTagVelocity, 8, true},    {kTagSpin, 4, true},
    {kTagDivergence, 4, true}, {kTagPointer, 8, true},     {kTagRegion, 8, true},
    {kTagConfidence, 4, true}, {kTagFrame, 8, true},       {kTagPixelAspect, 8, true},
    {kTagPoints, 2, true},     {kTagModel, 1, true},       {kTagHeld, 1, false},
    {kTagHeldPlace, 8, false}, {kTagHeldRadius, 4, false}, {kTagHeldTime, 8, false},
};
constexpr MotionTag kOfAHeldThing[] = {kTagHeldPlace, kTagHeldRadius, kTagHeldTime};

constexpr std::uint8_t tag_of(FieldKind kind) {
  return kind == FieldKind::relief ? kTagRelief : kTagField;
}

KlvItem damaged(const char *error, std::size_t offset) {
  KlvItem item;
  item.error = error;
  item.offset = offset;
  return item;
}

KlvItem read_motion(Bytes bytes, std::size_t offset) {
  const auto set = read_set<kMotionTags>(bytes);
  if (set.error)
    return damaged(set.error, offset + set.offset);
  const auto &values = set.values;
  KlvItem item;
  item.offset = offset;
  if (values[kTagVersion].size() != 1 || values[kTagKind].size() != 1)
    return damaged("the version or the kind is missing", offset);
  if (values[kTagVersion][0] != kVersion) {
    item.kind = KlvKind::other_version;
    return item;
  }
  const std::uint8_t kind = values[kTagKind][0];
  if (kind != kPointSample && kind != kFieldSample && kind != kReliefSample) {
    item.kind = KlvKind::other_sample;
    return item;
  }
  for (const auto &field : kMotionValues) {
    const bool there = values[field.tag].data() != nullptr;
    if (!there && field.needed && kind == kPointSample)
      return damaged("a value is missing", offset);
    if (there && values[field.tag].size() != field.size)
      return damaged("a value has the wrong size", offset + set.offsets[field.tag]);
  }
  if (values[kTagTime].data())
    item.sample.time = read_unsigned(values[kTagTime]);
  if (values[kTagDuration].data())
    item.sample.duration = read_unsigned(values[kTagDuration]);
  if (kind != kPointSample) {
    item.field_kind = kind == kReliefSample ? FieldKind::relief : FieldKind::motion;
    item.field = values[tag_of(item.field_kind)];
    if (item.field.empty())
      return damaged("a value is missing", offset);
    if (item.field_kind == FieldKind::motion)
      item.things = values[kTagThings];
    if (!are_field_things(item.things))
      return damaged("a value is out of its range", offset + set.offsets[kTagThings]);
    item.kind = KlvKind::field;
    return item;
  }
  MotionSample &s = item.sample.motion;
  s.flags = static_cast<std::uint16_t>(read_unsigned(values[kTagFlags]));
  s.interval = read_unsigned(values[kTagInterval]);
  s.velocity_x = read_float(values[kTagVelocity]);
  s.velocity_y = read_float(values[kTagVelocity].subspan(4));
  s.spin = read_float(values[kTagSpin]);
  s.divergence = read_float(values[kTagDivergence]);
  s.pointer_x = read_float(values[kTagPointer]);
  s.pointer_y = read_float(values[kTagPointer].subspan(4));
  s.region_width = read_float(values[kTagRegion]);
  s.region_height = read_float(values[kTagRegion].subspan(4));
  s.confidence = read_float(values[kTagConfidence]);
  s.frame_width = static_cast<std::uint32_t>(read_unsigned(values[kTagFrame].first(4)));
  s.frame_height = static_cast<std::uint32_t>(read_unsigned(values[kTagFrame].subspan(4)));
  s.pixel_aspect_n = static_cast<std::uint32_t>(read_unsigned(values[kTagPixelAspect].first(4)));
  s.pixel_aspect_d = static_cast<std::uint32_t>(read_unsigned(values[kTagPixelAspect].subspan(4)));
  s.points = static_cast<std::uint16_t>(read_unsigned(values[kTagPoints]));
  s.model = static_cast<MotionModel>(values[kTagModel][0]);
  if (values[kTagHeld].data()) {
    if (!std::ranges::all_of(kOfAHeldThing, [&](auto tag) { return values[tag].data(); }))
      return damaged("a value is missing", offset);
    s.held.state = static_cast<HoldState>(values[kTagHeld][0]);
    s.held.x = read_float(values[kTagHeldPlace]);
    s.held.y = read_float(values[kTagHeldPlace].subspan(4));
    s.held.radius = read_float(values[kTagHeldRadius]);
    s.held.time = read_unsigned(values[kTagHeldTime]);
  }
  if (!is_valid(s))
    return damaged("a value is out of its range", offset);
  item.kind = KlvKind::motion;
  return item;
}

bool is_universal_label(Bytes bytes) {
  return bytes.size() >= kMotionKey.size() &&
         std::equal(kKlvDesignator.begin(), kKlvDesignator.end(), bytes.begin());
}

bool has_key(Bytes bytes, const KlvKey &key) {
  return bytes.size() >= key.size() && std::equal(key.begin(), key.end(), bytes.begin());
}

struct Triplet {
  Bytes key;
  Bytes value;
  std::size_t value_at;
};

// Reads a triplet at `at` and moves `at` behind it. Returns nothing if it is damaged.
std::optional<Triplet> read_triplet(Bytes bytes, std::size_t &at) {
  if (!is_universal_label(bytes.subspan(at)))
    return std::nullopt;
  std::size_t behind = at + kMotionKey.size();
  const auto length = read_length(bytes, behind);
  if (!length)
    return std::nullopt;
  const Triplet triplet{bytes.subspan(at, kMotionKey.size()), bytes.subspan(behind, *length),
                        behind};
  at = behind + *length;
  return triplet;
}

} // namespace

std::vector<std::uint8_t> write_klv(const TrackSample &sample) {
  const MotionSample &s = sample.motion;
  SetWriter out(kMotionKey);
  out.unsigned_values(kTagVersion, 1, {kVersion});
  out.unsigned_values(kTagKind, 1, {kPointSample});
  if (sample.time != kNoTime)
    out.unsigned_values(kTagTime, 8, {sample.time});
  if (sample.duration != kNoTime)
    out.unsigned_values(kTagDuration, 8, {sample.duration});
  out.unsigned_values(kTagFlags, 2, {s.flags});
  out.unsigned_values(kTagInterval, 8, {s.interval});
  out.floats(kTagVelocity, {s.velocity_x, s.velocity_y});
  out.floats(kTagSpin, {s.spin});
  out.floats(kTagDivergence, {s.divergence});
  out.floats(kTagPointer, {s.pointer_x, s.pointer_y});
  out.floats(kTagRegion, {s.region_width, s.region_height});
  out.floats(kTagConfidence, {s.confidence});
  out.unsigned_values(kTagFrame, 4, {s.frame_width, s.frame_height});
  out.unsigned_values(kTagPixelAspect, 4, {s.pixel_aspect_n, s.pixel_aspect_d});
  out.unsigned_values(kTagPoints, 2, {s.points});
  out.unsigned_values(kTagModel, 1, {static_cast<std::uint64_t>(s.model)});
  if (s.held.state != HoldState::none) {
    out.unsigned_values(kTagHeld, 1, {static_cast<std::uint64_t>(s.held.state)});
    out.floats(kTagHeldPlace, {s.held.x, s.held.y});
    out.floats(kTagHeldRadius, {s.held.radius});
    out.unsigned_values(kTagHeldTime, 8, {s.held.time});
  }
  return out.finish();
}

std::vector<std::uint8_t> write_klv(const CodedField &field) {
  SetWriter out(kMotionKey);
  out.unsigned_values(kTagVersion, 1, {kVersion});
  out.unsigned_values(kTagKind, 1,
                      {field.kind == FieldKind::relief ? kReliefSample : kFieldSample});
  if (field.time != kNoTime)
    out.unsigned_values(kTagTime, 8, {field.time});
  if (field.duration != kNoTime)
    out.unsigned_values(kTagDuration, 8, {field.duration});
  out.bytes(tag_of(field.kind), field.bytes);
  if (!field.things.empty())
    out.bytes(kTagThings, field.things);
  return out.finish();
}

CodedField coded_field_of(const KlvItem &item) {
  return {{item.field.begin(), item.field.end()},
          item.sample.time,
          item.sample.duration,
          item.field_kind,
          {item.things.begin(), item.things.end()}};
}

std::optional<KlvItem> KlvReader::next() noexcept {
  if (at_ >= bytes_.size())
    return std::nullopt;
  const std::size_t begin = at_;
  const auto triplet = read_triplet(bytes_, at_);
  if (!triplet) {
    const auto found = std::search(bytes_.begin() + static_cast<std::ptrdiff_t>(begin) + 1,
                                   bytes_.end(), kMotionKey.begin(), kMotionKey.end());
    at_ = static_cast<std::size_t>(found - bytes_.begin());
    return damaged(is_universal_label(bytes_.subspan(begin)) ? "a triplet is cut off"
                                                             : "this is not KLV",
                   begin);
  }
  if (has_key(triplet->key, kMotionKey))
    return read_motion(triplet->value, triplet->value_at);
  KlvItem item;
  item.kind = KlvKind::foreign;
  item.offset = begin;
  return item;
}

std::vector<std::uint8_t> write_klv(const TrackPointer &pointer) {
  SetWriter out(kPointerKey);
  out.unsigned_values(kTagPointerVersion, 1, {kVersion});
  out.unsigned_values(kTagSequence, 4, {pointer.sequence});
  out.doubles(kTagPosition, {pointer.x, pointer.y});
  out.doubles(kTagDepth, {pointer.z});
  out.unsigned_values(kTagPressed, 1, {pointer.pressed ? 1U : 0U});
  out.bytes(kTagDevice, std::string_view(pointer.device).substr(0, kLongestDeviceName));
  return out.finish();
}

std::optional<TrackPointer> read_klv_pointer(Bytes bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const auto triplet = read_triplet(bytes, at);
    if (!triplet)
      return std::nullopt;
    if (!has_key(triplet->key, kPointerKey))
      continue;
    const auto set = read_set<kPointerTags>(triplet->value);
    const auto &values = set.values;
    if (set.error || values[kTagPointerVersion].size() != 1 ||
        values[kTagPointerVersion][0] != kVersion || values[kTagSequence].size() != 4 ||
        values[kTagPosition].size() != 16 || values[kTagDepth].size() != 8 ||
        values[kTagPressed].size() != 1 || values[kTagDevice].size() > kLongestDeviceName)
      return std::nullopt;
    TrackPointer pointer;
    pointer.sequence = static_cast<std::uint32_t>(read_unsigned(values[kTagSequence]));
    pointer.x = read_double(values[kTagPosition]);
    pointer.y = read_double(values[kTagPosition].subspan(8));
    pointer.z = read_double(values[kTagDepth]);
    pointer.pressed = values[kTagPressed][0] != 0;
    pointer.device.assign(values[kTagDevice].begin(), values[kTagDevice].end());
    // Written so that NaN fails.
    if (!(pointer.x >= 0 && pointer.x <= 1 && pointer.y >= 0 && pointer.y <= 1 && pointer.z >= -1 &&
          pointer.z <= 1))
      return std::nullopt;
    return pointer;
  }
  return std::nullopt;
}

} // namespace haptic
