// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/hmpg.hpp"

#include "mpeg-haptics/bits.hpp"
#include "mpeg-haptics/hmpg-packets.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace haptic {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Reads the packets of one unit. The first error ends the reading.
class UnitParser {
public:
  UnitParser(Bytes unit, const HmpgExperience *experience) : unit_(unit), known_(experience) {}

  HmpgUnit parse() {
    HmpgUnit result;
    const auto header = read_unit_header(unit_);
    if (!header) {
      result.error = HmpgError{unit_.size() < kUnitHeaderSize ? "the unit's header is cut off"
                                                              : "the unit's header is impossible",
                               0};
      return result;
    }
    if (header->length != unit_.size() - kUnitHeaderSize) {
      result.error =
          HmpgError{header->length > unit_.size() - kUnitHeaderSize ? "the unit is cut off"
                                                                    : "there is more than one unit",
                    kUnitHeaderSize};
      return result;
    }
    header_ = *header;
    packets();
    if (!error_ && header_.type == UnitType::initialization)
      check_initialization();
    if (error_) {
      result.error = error_;
      return result;
    }
    result.header = header_;
    result.curves = std::move(curves_);
    result.has_composite = has_composite_;
    if (header_.type == UnitType::initialization)
      result.experience = std::move(fresh_);
    return result;
  }

private:
  void fail(const char *what) {
    if (!error_)
      error_ = HmpgError{what, at_ + in_.byte()};
  }
  void require(bool condition, const char *what) {
    if (!condition)
      fail(what);
  }

  void packets() {
    at_ = kUnitHeaderSize;
    in_ = BitReader({});
    if (header_.type == UnitType::silent && at_ < unit_.size())
      fail("a silent unit has content");
    while (!error_ && at_ < unit_.size()) {
      in_ = BitReader(unit_.subspan(at_, std::min(kPacketHeaderSize, unit_.size() - at_)));
      const auto type = in_.get(6);
      const auto length = in_.get(17);
      const auto reserved = in_.get(1);
      if (in_.failed() || length > unit_.size() - at_ - kPacketHeaderSize)
        return fail("a packet is cut off");
      if (type >= kPacketTypes || reserved != 0) {
        in_ = BitReader({});
        return fail("a packet's header is impossible");
      }
      at_ += kPacketHeaderSize;
      in_ = BitReader(unit_.subspan(at_, length));
      exact_ = true;
      packet(static_cast<PacketType>(type));
      if (!error_ && in_.failed())
        fail("a packet is too short for what it says");
      if (!error_ && exact_ && (in_.left() >= 8 || in_.get(static_cast<unsigned>(in_.left())) != 0))
        fail("a packet is longer than what it says");
      at_ += length;
      in_ = BitReader({});
    }
  }

  void packet(PacketType type) {
    const bool initial = header_.type == UnitType::initialization;
    switch (type) {
    case kInitializationTiming:
      return initial ? timing() : fail("a timing packet outside of an initialization unit");
    case kMetadataHaptics:
      return initial ? haptics() : fail("metadata outside of an initialization unit");
    case kMetadataPerception:
      return initial ? perception() : fail("metadata outside of an initialization unit");
    case kMetadataChannel:
      return initial ? channel() : fail("metadata outside of an initialization unit");
    case kMetadataBand:
      return initial ? band() : fail("metadata outside of an initialization unit");
    case kEffectLibrary:
      if (initial)
        library();
      break;
    case kData:
      if (header_.type == UnitType::temporal)
        return data();
      if (initial)
        return fail("data in an initialization unit");
      break;
    default:
      break;
    }
    exact_ = false;
  }

  void timing() {
    require(!has_timing_, "a second timing packet");
    has_timing_ = true;
    fresh_.time = in_.get(32);
    fresh_.timescale = in_.get(32);
    require(in_.failed() || (fresh_.timescale > 0 && fresh_.timescale <= kHighestTimescale),
            "an impossible timescale");
    fresh_.nominal = in_.get(24);
    fresh_.deviation = in_.get(24);
    in_.get(1);
  }

  void haptics() {
    require(!has_haptics_, "a second packet of general metadata");
    has_haptics_ = true;
    fresh_.version = in_.text();
    fresh_.profile = in_.text();
    fresh_.level = static_cast<std::uint8_t>(in_.get(8));
    require(in_.failed() || fresh_.level == 1 || fresh_.level == 2, "an impossible level");
    fresh_.date = in_.text();
    fresh_.description = in_.text();
    perceptions_promised_ = in_.get(8);
    for (auto avatars = in_.get(8); avatars > 0 && !in_.failed(); --avatars) {
      in_.get(8);
      in_.get(8);
      if (in_.get(8) == 0)
        in_.text(); // mesh
    }
  }

  void perception() {
    HmpgPerception p;
    p.id = static_cast<std::uint8_t>(in_.get(8));
    in_.get(8);
    p.description = in_.text();
    p.modality = static_cast<std::uint8_t>(in_.get(8));
    in_.get(8);
    in_.get(16);
    if (in_.get(1))
      in_.text();
    in_.get(8);
    p.exponent = static_cast<std::int8_t>(in_.get(8));
    if (in_.get(8) > 0) // reference devices are passed over by the length of the packet
      exact_ = false;
    else
      in_.get(16);
    require(!find(fresh_.perceptions, p.id), "a perception is there twice");
    fresh_.perceptions.push_back(std::move(p));
  }

  void channel() {
    HmpgChannel c;
    c.id = static_cast<std::uint16_t>(in_.get(16));
    c.perception = static_cast<std::uint8_t>(in_.get(8));
    in_.get(8);
    c.description = in_.text();
    in_.get(8);
    c.gain = in_.get(32) / kCodes32 * 2 * kWidestGain - kWidestGain;
    in_.get(32);
    const auto options = in_.get(8);
    if (options & kOptionBodyMask)
      in_.get(32);
    if (options & kOptionResolution)
      in_.get(24);
    if (in_.get(32) > 0) // sampling frequency
      in_.get(32);
    if (options & kOptionDirection) {
      c.direction.emplace();
      for (auto &part : *c.direction)
        part = static_cast<std::int8_t>(in_.get(8));
    }
    for (auto vertices = in_.get(16); vertices > 0 && !in_.failed(); --vertices)
      in_.get(32);
    in_.get(8);
    if (in_.failed())
      return;
    require(find(fresh_.perceptions, c.perception), "a channel of no perception");
    require(!find(fresh_.channels, c.id), "a channel is there twice");
    fresh_.channels.push_back(std::move(c));
  }

  void band() {
    HmpgBand b;
    b.id = static_cast<std::uint8_t>(in_.get(8));
    b.perception = static_cast<std::uint8_t>(in_.get(8));
    b.channel = static_cast<std::uint16_t>(in_.get(16));
    in_.get(8);
    const auto type = in_.get(3);
    require(type <= static_cast<std::uint32_t>(BandType::wavelet), "an impossible type of band");
    b.type = static_cast<BandType>(type);
    if (b.type == BandType::curve) {
      const auto curve = in_.get(4);
      require(curve <= static_cast<std::uint32_t>(CurveType::bspline),
              "an impossible type of curve");
      b.curve = static_cast<CurveType>(curve);
    } else if (b.type == BandType::wavelet) {
      in_.get(8);
    }
    const auto lowest = in_.get(16);
    const auto highest = in_.get(16);
    in_.get(16);
    if (in_.failed())
      return;
    require(lowest <= highest && highest <= kHighestFrequency, "impossible frequency limits");
    require(find(fresh_.channels, b.channel), "a band of no channel");
    require(!find(fresh_.bands, b.id), "a band is there twice");
    fresh_.bands.push_back(b);
  }

  // A library that cannot be read is left out: the rest does not need it.
  void library() {
    const auto perception = static_cast<std::uint8_t>(in_.get(8));
    std::vector<HmpgLibraryEffect> effects;
    bool is_whole = true;
    for (auto count = in_.get(16); count > 0 && is_whole; --count) {
      HmpgLibraryEffect effect;
      effect.perception = perception;
      is_whole = library_effect(effect, 0);
      if (!effect.keyframes.empty())
        effects.push_back(std::move(effect));
    }
    if (is_whole)
      std::ranges::move(effects, std::back_inserter(fresh_.library));
    in_ = BitReader({});
  }

  // Returns false if it cannot be read. One that is no curve gets no keyframes.
  bool library_effect(HmpgLibraryEffect &effect, int depth) {
    effect.id = static_cast<std::uint16_t>(in_.get(16));
    in_.get(25); // position: that of the reference counts
    in_.get(16); // phase
    in_.get(4);  // base signal
    bool is_curve = in_.get(2) == kBasisEffect;
    for (auto count = in_.get(16); count > 0 && !in_.failed(); --count) {
      const auto mask = in_.get(3);
      HmpgKeyframe keyframe;
      if (mask & kMaskPosition)
        keyframe.position = static_cast<std::int32_t>(in_.get(16));
      if (mask & kMaskAmplitude)
        keyframe.amplitude = static_cast<std::uint8_t>(in_.get(8));
      if (mask & kMaskFrequency)
        in_.get(16);
      is_curve =
          is_curve && mask == (kMaskPosition | kMaskAmplitude) &&
          (effect.keyframes.empty() || keyframe.position >= effect.keyframes.back().position);
      if (is_curve)
        effect.keyframes.push_back(keyframe);
    }
    if (!is_curve)
      effect.keyframes.clear();
    for (auto parts = in_.get(16); parts > 0 && !in_.failed(); --parts)
      if (HmpgLibraryEffect part; depth == kDeepestEffect || !library_effect(part, depth + 1))
        return false;
    return !in_.failed();
  }

  void data() {
    in_.get(1);
    HmpgCurve curve;
    curve.perception = static_cast<std::uint8_t>(in_.get(8));
    curve.channel = static_cast<std::uint16_t>(in_.get(16));
    curve.band = static_cast<std::uint8_t>(in_.get(8));
    if (in_.failed())
      return;
    const HmpgBand *band = known_ ? find(known_->bands, curve.band) : nullptr;
    if (!band || band->channel != curve.channel || band->perception != curve.perception)
      return fail("data of no band");
    if (band->type != BandType::curve) {
      exact_ = false;
      return;
    }
    for (auto effects = in_.get(16); effects > 0 && !in_.failed() && !error_; --effects)
      if (!effect(curve))
        return;
  }

  // Returns false if the rest of the packet cannot be read.
  bool effect(HmpgCurve curve) {
    curve.effect = static_cast<std::uint16_t>(in_.get(16));
    const auto type = in_.get(2);
    const auto raw = in_.get(25);
    require(type < kEffectTypes, "an impossible type of effect");
    const auto begin = static_cast<std::int32_t>(raw << 7) >> 7; // 25 bits with a sign
    if (type == kReferenceEffect && !in_.failed()) {
      curve.reference = begin;
      curves_.push_back(std::move(curve));
      return true;
    }
    if (type != kBasisEffect) {
      has_composite_ = true;
      exact_ = false;
      return false;
    }
    curve.begin = begin;
    if (in_.get(1))
      in_.get(12);
    const auto count = in_.get(16);
    if (in_.failed() || std::size_t{count} * kCurveKeyframeBits > in_.left()) {
      fail("a packet is too short for its keyframes");
      return false;
    }
    curve.keyframes.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      HmpgKeyframe keyframe;
      keyframe.amplitude = static_cast<std::uint8_t>(in_.get(8));
      keyframe.position = begin + static_cast<std::int32_t>(in_.get(16));
      require(i == 0 || keyframe.position >= curve.keyframes.back().position,
              "keyframes run backwards");
      curve.keyframes.push_back(keyframe);
    }
    curves_.push_back(std::move(curve));
    return true;
  }

  void check_initialization() {
    at_ = kUnitHeaderSize;
    require(has_timing_, "an initialization unit without timing");
    require(has_haptics_, "an initialization unit without general metadata");
    require(perceptions_promised_ == fresh_.perceptions.size(),
            "another number of perceptions than promised");
    std::ranges::stable_sort(fresh_.library, {}, id_in_library);
  }

  template <typename Item, typename Id>
  static const Item *find(const std::vector<Item> &items, Id id) {
    const auto found =
        std::find_if(items.begin(), items.end(), [&](const Item &item) { return item.id == id; });
    return found == items.end() ? nullptr : &*found;
  }

  Bytes unit_;
  const HmpgExperience *known_; // may be none
  UnitHeader header_;
  std::size_t at_ = 0; // byte of the unit at which in_ begins
  BitReader in_{{}};
  bool exact_ = true; // the packet must end where its content does
  std::optional<HmpgError> error_;

  HmpgExperience fresh_;
  bool has_timing_ = false;
  bool has_haptics_ = false;
  std::uint32_t perceptions_promised_ = 0;
  std::vector<HmpgCurve> curves_;
  bool has_composite_ = false;
};

} // namespace

std::uint8_t code_of_amplitude(double amplitude) noexcept {
  return static_cast<std::uint8_t>(std::lround((std::clamp(amplitude, -1.0, 1.0) + 1) / 2 * 255));
}

double amplitude_of_code(std::uint8_t code) noexcept {
  if (code == 127 || code == 128)
    return 0;
  return code / 255.0 * 2 - 1;
}

bool set_initialization_time(std::span<std::uint8_t> unit, std::uint32_t time) noexcept {
  for (std::size_t at = kUnitHeaderSize; at + kPacketHeaderSize <= unit.size();) {
    BitReader header(unit.subspan(at, kPacketHeaderSize));
    const auto type = header.get(6);
    const auto length = header.get(17);
    at += kPacketHeaderSize;
    if (length > unit.size() - at)
      return false;
    if (type == kInitializationTiming && length >= 4) {
      for (std::size_t i = 0; i < 4; ++i)
        unit[at + i] = static_cast<std::uint8_t>(time >> (24 - 8 * i));
      return true;
    }
    at += length;
  }
  return false;
}

std::optional<UnitHeader> read_unit_header(Bytes bytes) noexcept {
  if (bytes.size() < kUnitHeaderSize)
    return std::nullopt;
  BitReader in(bytes.first(kUnitHeaderSize));
  const auto type = in.get(6);
  const auto sync = in.get(2);
  UnitHeader header;
  header.layer = static_cast<std::uint8_t>(in.get(4));
  header.duration = in.get(24);
  header.length = in.get(32);
  const auto reserved = in.get(4);
  if (type > static_cast<std::uint32_t>(UnitType::silent) || sync > 1 || reserved != 0 ||
      header.length > kLongestUnit)
    return std::nullopt;
  header.type = static_cast<UnitType>(type);
  header.dependent = sync == 1;
  const bool lasts = header.type == UnitType::temporal || header.type == UnitType::silent;
  if (lasts ? header.duration == 0 : header.dependent)
    return std::nullopt;
  return header;
}

bool looks_like_unit(Bytes bytes) noexcept {
  const auto header = read_unit_header(bytes);
  if (!header || header->type == UnitType::silent || header->length == 0)
    return header && header->length == 0 && header->type != UnitType::initialization;
  if (bytes.size() < kUnitHeadSize)
    return false;
  BitReader in(bytes.subspan(kUnitHeaderSize, kPacketHeaderSize));
  const auto type = in.get(6);
  const auto length = in.get(17);
  const bool fits = in.get(1) == 0 && length + kPacketHeaderSize <= header->length;
  switch (header->type) {
  case UnitType::initialization:
    return fits && (type == kInitializationTiming || type == kMetadataHaptics);
  default:
    return fits && type >= kData && type < kInitializationTiming;
  }
}

HmpgUnit read_unit(Bytes bytes, const HmpgExperience *experience) {
  return UnitParser(bytes, experience).parse();
}

} // namespace haptic
