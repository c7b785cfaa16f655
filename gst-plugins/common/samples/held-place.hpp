// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the thing is that was taken by a press.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace haptic {

/// What became of the thing since it was taken (docs/elements/roitracker.md#hold).
enum class HoldState : std::uint8_t {
  none,    ///< nothing is pressed
  held,    ///< the thing itself is seen
  about,   ///< what moves about the place is followed; which thing it is cannot be told
  hidden,  ///< something is before the thing; the place is a guess
  lost,    ///< it was not found again
  refused, ///< there was nothing to hold
};

/// Whether the place moves with what is seen.
inline bool is_followed(HoldState state) noexcept {
  return state == HoldState::held || state == HoldState::about;
}

/// By the numbers of HoldState.
inline constexpr std::array<std::string_view, 6> kHoldStateNames = {"none",   "held", "about",
                                                                    "hidden", "lost", "refused"};

constexpr std::string_view hold_state_name(HoldState state) noexcept {
  return kHoldStateNames[static_cast<std::size_t>(state)];
}

constexpr std::optional<HoldState> hold_state_named(std::string_view name) noexcept {
  for (std::size_t i = 0; i < kHoldStateNames.size(); ++i)
    if (kHoldStateNames[i] == name)
      return static_cast<HoldState>(i);
  return std::nullopt;
}

/// What a person reads.
constexpr std::string_view hold_words(HoldState state) noexcept {
  return state == HoldState::refused ? "nothing to hold" : hold_state_name(state);
}

/// Positions and sizes are fractions of the frame, origin at its top left corner.
struct HeldPlace {
  HoldState state = HoldState::none;
  float x = 0.5F;         ///< 0..1; where the thing was last, if it is lost
  float y = 0.5F;         ///< 0..1
  float radius = 0;       ///< fraction of the width, 0..1: what is followed lies within it
  std::uint64_t time = 0; ///< ns since the frame in which it was taken
  bool operator==(const HeldPlace &) const = default;
};

} // namespace haptic
