// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/hmpg-rtp.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace haptic {
namespace {

using Bytes = std::span<const std::uint8_t>;

// RFC 9993, section 5.3: values of the field UT of the payload header. Those of single units are
// the unit's type plus one.
constexpr unsigned kAggregationSameTime = 5;
constexpr unsigned kFragment = 7;
// Section 5.3.2: fields FUS and FUE of the fragment header.
constexpr unsigned kFragmentStart = 0x80;
constexpr unsigned kFragmentEnd = 0x40;

unsigned unit_type_code(UnitType type) {
  return static_cast<unsigned>(type) + 1;
}

// Section 5.2: D (dependent) 1 bit, UT 3, L (layer) 4.
std::uint8_t payload_header(const UnitHeader &header, unsigned type) {
  return static_cast<std::uint8_t>((header.dependent ? 0x80U : 0U) | type << 4 | header.layer);
}

} // namespace

std::vector<HmpgPayload> packetize_unit(Bytes unit, std::size_t largest) {
  const auto header = read_unit_header(unit);
  if (!header)
    return {};
  const unsigned type = unit_type_code(header->type);
  if (unit.size() + 1 <= largest)
    return {{{payload_header(*header, type)}, unit}};
  std::vector<HmpgPayload> payloads;
  const std::size_t size = std::max<std::size_t>(largest, 8) - 2;
  for (std::size_t at = 0; at < unit.size(); at += size) {
    const auto part = unit.subspan(at, std::min(size, unit.size() - at));
    const unsigned fragment = (at == 0 ? kFragmentStart : 0U) |
                              (at + part.size() == unit.size() ? kFragmentEnd : 0U) | type;
    payloads.push_back(
        {{payload_header(*header, kFragment), static_cast<std::uint8_t>(fragment)}, part});
  }
  return payloads;
}

// Of the payload header, D and L of several units are not defined: here of the first one, and the
// highest priority. A receiver reads the units' own.
std::optional<HmpgPayload> aggregate_units(std::span<const Bytes> units, std::size_t largest) {
  HmpgPayload payload = {{0}, {}};
  auto &head = payload.head;
  for (const Bytes unit : units) {
    const auto header = read_unit_header(unit);
    if (!header || unit.size() > 0xFFFF)
      return std::nullopt;
    head.insert(head.end(), payload.part.begin(), payload.part.end());
    if (head.size() == 1)
      head[0] = payload_header(*header, kAggregationSameTime);
    const unsigned layer = std::min<unsigned>(head[0] & 0x0FU, header->layer);
    head[0] = static_cast<std::uint8_t>((head[0] & 0xF0U) | layer);
    head.push_back(static_cast<std::uint8_t>(unit.size() >> 8));
    head.push_back(static_cast<std::uint8_t>(unit.size()));
    payload.part = unit;
  }
  if (payload.size() > largest)
    return std::nullopt;
  return payload;
}

UnitAssembler::Result UnitAssembler::push(std::uint16_t sequence, Bytes payload) {
  Result result = assemble(sequence, payload);
  if (result.problem)
    lost_ = true; // units that depend on it cannot be read either
  return result;
}

UnitAssembler::Result UnitAssembler::assemble(std::uint16_t sequence, Bytes payload) {
  if (last_ && sequence != static_cast<std::uint16_t>(*last_ + 1)) {
    lost_ = true;
    in_fragment_ = false;
  }
  last_ = sequence;
  if (payload.empty())
    return {.problem = "an empty packet"};
  const unsigned type = payload[0] >> 4 & 7U;
  if (type == kFragment)
    return assemble_fragment(payload);
  in_fragment_ = false;
  if (type == kAggregationSameTime)
    return separate(payload.subspan(1));
  if (type == 0 || type > kAggregationSameTime)
    return {.problem = type == 0 ? "a packet of reserved type"
                                 : "an aggregation packet of several time stamps"};
  const auto unit = payload.subspan(1);
  const auto header = read_unit_header(unit);
  if (!header || unit_type_code(header->type) != type)
    return {.problem = "a packet whose unit is not what it says"};
  return deliver({unit.begin(), unit.end()});
}

UnitAssembler::Result UnitAssembler::assemble_fragment(Bytes payload) {
  if (payload.size() < 3)
    return {.problem = "a fragment without content"};
  const unsigned fragment = payload[1];
  if (fragment & kFragmentStart) {
    partial_.clear();
    in_fragment_ = true;
  }
  if (!in_fragment_)
    return {.problem = "a fragment whose beginning is missing"};
  if (partial_.size() + payload.size() - 2 > kLongestUnit + kUnitHeaderSize) {
    in_fragment_ = false;
    return {.problem = "a unit that is too long"};
  }
  partial_.insert(partial_.end(), payload.begin() + 2, payload.end());
  if (!(fragment & kFragmentEnd))
    return {};
  in_fragment_ = false;
  return deliver(std::move(partial_));
}

// Before each unit stands its size in 16 bits.
UnitAssembler::Result UnitAssembler::separate(Bytes aggregate) {
  Result all;
  while (!aggregate.empty()) {
    const std::size_t size =
        aggregate.size() < 2 ? 0 : std::size_t{aggregate[0]} << 8 | aggregate[1];
    if (size == 0 || size > aggregate.size() - 2) {
      all.problem = "the rest of a damaged aggregation packet";
      break;
    }
    const auto unit = aggregate.subspan(2, size);
    aggregate = aggregate.subspan(2 + size);
    Result one = deliver({unit.begin(), unit.end()});
    std::move(one.units.begin(), one.units.end(), std::back_inserter(all.units));
    all.problem = one.problem ? one.problem : all.problem;
    all.after_loss = all.after_loss || one.after_loss;
    all.waits = one.waits;
  }
  return all;
}

UnitAssembler::Result UnitAssembler::deliver(std::vector<std::uint8_t> unit) {
  const auto header = read_unit_header(unit);
  if (!header || header->length != unit.size() - kUnitHeaderSize)
    return {.problem = "a damaged unit"};
  if (header->type == UnitType::initialization)
    initialized_ = true;
  if (!initialized_)
    return {.problem = "a unit before the first initialization unit", .waits = true};
  if (lost_ && header->dependent)
    return {.problem = "a unit that depends on a lost one", .waits = true};
  Result result;
  result.after_loss = lost_;
  result.units.push_back(std::move(unit));
  lost_ = false;
  return result;
}

void UnitAssembler::reset() {
  *this = {};
}

} // namespace haptic
