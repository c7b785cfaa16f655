// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/session-state.hpp"

#include "safety/safety-chain.hpp"

#include <algorithm>
#include <utility>

namespace haptic {
namespace {

bool is_transition(SessionState from, SessionState to) {
  return std::ranges::find(kSessionTransitions, SessionTransition{from, to}) !=
         kSessionTransitions.end();
}

// The next state on the way. Where the table has no direct transition, the way leads through the
// states in their order: closed, open, homed, armed, held.
SessionState next_state(SessionState from, SessionState to) {
  if (is_transition(from, to))
    return to;
  if (from == SessionState::faulted)
    return SessionState::homed;
  if (to < from)
    return SessionState::closed;
  return static_cast<SessionState>(static_cast<int>(from) + 1);
}

} // namespace

SessionState session_state(std::uint32_t holds, bool homed) noexcept {
  if (holds & kFaults)
    return SessionState::faulted; // also when the device was lost
  if (holds & kHoldClosed)
    return SessionState::closed;
  if (!homed)
    return SessionState::open;
  if (holds & kHoldReleased)
    return SessionState::homed;
  return holds ? SessionState::held : SessionState::armed;
}

std::string session_reason(std::uint32_t holds, SessionState state) {
  std::uint32_t shown = 0;
  if (state == SessionState::held)
    shown = holds;
  else if (state == SessionState::homed || state == SessionState::faulted)
    shown = holds & kLatches;
  return names_of_holds(shown);
}

std::uint32_t SessionStateMachine::settled(const SessionCause &cause) {
  constexpr std::uint32_t kOfFilm = kHoldGap | kHoldStale | kHoldCut | kHoldLate;
  constexpr std::int64_t kLasting = 200'000'000; // ns
  if (const std::uint32_t now = cause.holds & kOfFilm; now == of_film_) {
    as_told_ = cause.time;
  } else if (cause.time - as_told_ >= kLasting) {
    of_film_ = now;
    as_told_ = cause.time;
  }
  return (cause.holds & ~kOfFilm) | of_film_;
}

void SessionStateMachine::update(const std::function<SessionCause()> &read,
                                 const std::function<void(const SessionStatus &)> &on_change) {
  const std::lock_guard lock(mutex_);
  const SessionCause cause = read();
  const std::uint32_t holds = settled(cause);
  const bool homed = cause.homed;
  const SessionState wanted = session_state(holds, homed);
  SessionState state = status_.state;
  do {
    if (state != wanted)
      state = next_state(state, wanted);
    SessionStatus status{state, session_reason(holds, state),
                         state == SessionState::closed ? "" : device_};
    if (status == status_)
      continue;
    status_ = std::move(status);
    on_change(status_);
  } while (state != wanted);
}

void SessionStateMachine::set_device(std::string description) {
  const std::lock_guard lock(mutex_);
  device_ = std::move(description);
}

SessionState SessionStateMachine::state() const {
  const std::lock_guard lock(mutex_);
  return status_.state;
}

} // namespace haptic
