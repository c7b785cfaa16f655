// SPDX-License-Identifier: LGPL-2.1-or-later
// The states of a session: no other transitions than those that docs/elements/hapticsink.md draws.
#include "session/session-state.hpp"

#include "safety/safety-chain.hpp"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <regex>
#include <string>
#include <vector>

namespace session_state_test {

using haptic::SessionState;
using haptic::SessionStateMachine;
using haptic::SessionStatus;
using haptic::SessionTransition;
using Names = std::vector<std::string>;

std::string text_of(const SessionTransition &t) {
  return std::string(name_of(t.from)) + " --> " + name_of(t.to);
}

// The names of the states on the way.
Names way(SessionStateMachine &machine, std::uint32_t holds, bool homed) {
  Names names;
  const auto cause = [&] { return haptic::SessionCause{holds, homed}; };
  machine.update(cause,
                 [&](const SessionStatus &status) { names.push_back(name_of(status.state)); });
  return names;
}

TEST(SessionState, FollowsTheHolds) {
  SessionStateMachine machine;
  EXPECT_EQ(way(machine, haptic::kHoldClosed | haptic::kHoldPaused, false), Names{});
  EXPECT_EQ(way(machine, haptic::kHoldPaused, false), Names{"open"});
  EXPECT_EQ(way(machine, haptic::kHoldPaused, true), (Names{"homed", "armed", "held"}));
  EXPECT_EQ(way(machine, 0, true), Names{"armed"});
  EXPECT_EQ(way(machine, haptic::kHoldReleased, true), Names{"homed"});
  EXPECT_EQ(way(machine, haptic::kHoldFaulted | haptic::kHoldReleased, true), Names{"faulted"});
  EXPECT_EQ(way(machine, haptic::kHoldFaulted | haptic::kHoldClosed, false), Names{"faulted"});
  EXPECT_EQ(way(machine, haptic::kHoldClosed, false), Names{"closed"});
}

TEST(SessionState, ALostDeviceIsAFaultAndNeedsArm) {
  SessionStateMachine machine;
  way(machine, 0, true);
  EXPECT_EQ(way(machine, haptic::kHoldFaulted | haptic::kHoldClosed, false), Names{"faulted"});
  EXPECT_EQ(way(machine, haptic::kHoldFaulted, true), Names{}); // opened again
  EXPECT_EQ(way(machine, 0, true), (Names{"homed", "armed"}));
}

TEST(SessionState, AFilmThatFlickersChangesNothingUntilItLasts) {
  constexpr std::int64_t kMs = 1'000'000; // ns
  SessionStateMachine machine;
  int changes = 0;
  const auto until = [&](std::int64_t from, std::int64_t to, auto &&holds_at) {
    for (std::int64_t ms = from; ms < to; ms += 10)
      machine.update(
          [&] {
            return haptic::SessionCause{holds_at(ms), true, ms * kMs};
          },
          [&](const SessionStatus &) { ++changes; });
  };
  until(0, 1000, [](std::int64_t) { return 0U; });
  changes = 0;
  until(1000, 11'000, [](std::int64_t ms) { return ms / 40 % 2 ? haptic::kHoldGap + 0U : 0U; });
  EXPECT_EQ(changes, 0);
  until(11'000, 11'190, [](std::int64_t) { return haptic::kHoldGap + 0U; });
  EXPECT_EQ(changes, 0);
  until(11'190, 11'500, [](std::int64_t) { return haptic::kHoldGap + 0U; });
  EXPECT_EQ(changes, 1);
  EXPECT_EQ(machine.state(), SessionState::held);
  until(11'500, 11'510, [](std::int64_t) { return haptic::kHoldGap | haptic::kHoldReleased; });
  EXPECT_EQ(machine.state(), SessionState::homed) << "what a person does is told at once";
}

TEST(SessionState, TheReasonNamesTheHolds) {
  using haptic::session_reason;
  constexpr std::uint32_t kHolds = haptic::kHoldPaused | haptic::kHoldDeadMan;
  EXPECT_EQ(session_reason(kHolds, SessionState::held), "paused,dead-man");
  EXPECT_EQ(session_reason(kHolds | haptic::kHoldOverspeed, SessionState::faulted), "overspeed");
  EXPECT_EQ(session_reason(kHolds, SessionState::armed), "");
  for (const auto &hold : haptic::kHoldNames)
    EXPECT_EQ(session_reason(hold.bit, SessionState::held), hold.name);
}

TEST(SessionState, EveryReasonHasAName) {
  std::uint32_t named = 0;
  for (const auto &hold : haptic::kHoldNames)
    named |= hold.bit;
  EXPECT_EQ(named, 2 * haptic::kHoldShaking - 1); // the last one
}

TEST(SessionState, WhateverHappensOnlyTheTransitionsOfTheTableHappen) {
  constexpr std::int64_t kSecond = 1'000'000'000; // ns
  std::mt19937 random(14);
  SessionStateMachine machine;
  SessionState before = machine.state();
  for (int i = 0; i < 20'000; ++i) {
    const std::uint32_t holds = random() & random() & (2 * haptic::kHoldShaking - 1);
    const bool homed = random() % 4 != 0;
    const auto cause = [&] { return haptic::SessionCause{holds, homed, i * kSecond}; };
    machine.update(cause, [&](const SessionStatus &status) {
      const SessionTransition step{before, status.state};
      if (status.state != before) {
        ASSERT_NE(std::ranges::find(haptic::kSessionTransitions, step),
                  haptic::kSessionTransitions.end())
            << text_of(step);
      }
      before = status.state;
    });
    ASSERT_EQ(machine.state(), haptic::session_state(holds, homed));
  }
}

TEST(SessionState, ThePageDrawsTheSameStatesAndTransitions) {
  std::ifstream page(SOURCE_ROOT "/docs/elements/hapticsink.md");
  const std::regex arrow(R"(^\s*(\w+ --> \w+)(:.*)?$)");
  Names drawn;
  for (std::string line; std::getline(page, line);)
    if (std::smatch match; std::regex_match(line, match, arrow))
      drawn.push_back(match[1]);
  Names coded;
  for (const SessionTransition &transition : haptic::kSessionTransitions)
    coded.push_back(text_of(transition));
  std::ranges::sort(drawn);
  std::ranges::sort(coded);
  EXPECT_EQ(drawn, coded);
}

} // namespace session_state_test
