// SPDX-License-Identifier: LGPL-2.1-or-later
// The RTP payload of haptics/hmpg: payload header (RFC 9993, section 5.2), single units (5.3.1),
// fragments (5.3.2) and aggregation packets (5.3.3) whose units have one time stamp. The text and
// the figure of those with several time stamps disagree on the size of the offset: not supported.
#pragma once

#include "mpeg-haptics/hmpg.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// A payload: bytes of its own, and a part of a unit that need not be copied.
struct HmpgPayload {
  std::vector<std::uint8_t> head;
  std::span<const std::uint8_t> part;

  std::size_t size() const noexcept { return head.size() + part.size(); }
};

/// Returns the payloads that carry one unit, each of at most `largest` bytes (8 or more).
std::vector<HmpgPayload> packetize_unit(std::span<const std::uint8_t> unit, std::size_t largest);

/// Returns the payload of an aggregation packet that carries these units, which have the same time
/// stamp, or nothing if it would have more than `largest` bytes. The part is the last unit.
std::optional<HmpgPayload> aggregate_units(std::span<const std::span<const std::uint8_t>> units,
                                           std::size_t largest);

/// Puts received units together.
class UnitAssembler {
public:
  struct Result {
    std::vector<std::vector<std::uint8_t>> units; ///< complete
    const char *problem = nullptr;                ///< what was dropped, and why
    bool after_loss = false;                      ///< units before these are missing
    bool waits = false;                           ///< for an initialization or independent unit
  };

  /// Payloads come in the order of their sequence numbers, as a jitter buffer gives them. Units are
  /// dropped until an initialization unit has come, and after a loss until an independent unit
  /// comes.
  Result push(std::uint16_t sequence, std::span<const std::uint8_t> payload);
  /// Another stream begins.
  void reset();

private:
  Result assemble(std::uint16_t sequence, std::span<const std::uint8_t> payload);
  Result assemble_fragment(std::span<const std::uint8_t> payload);
  Result separate(std::span<const std::uint8_t> aggregate);
  Result deliver(std::vector<std::uint8_t> unit);

  std::optional<std::uint16_t> last_;
  std::vector<std::uint8_t> partial_;
  bool in_fragment_ = false;
  bool initialized_ = false;
  bool lost_ = false;
};

} // namespace haptic
