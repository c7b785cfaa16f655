// SPDX-License-Identifier: LGPL-2.1-or-later
// The states of a session and the transitions between them: docs/elements/hapticsink.md draws them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace haptic {

enum class SessionState {
  closed,  ///< no device is open
  open,    ///< the device is open, the pose of its grip is not known
  homed,   ///< the pose is known; no force until `arm`
  armed,   ///< the force follows the motion
  held,    ///< the force is zero, or fades to it, and comes back by itself
  faulted, ///< the force is off after a fault, until `arm`
};

struct SessionStateName {
  SessionState state;
  const char *name;        ///< nick of the property, text in messages
  const char *description; ///< for gst-inspect-1.0
};
inline constexpr std::array kSessionStates = {
    SessionStateName{SessionState::closed, "closed", "No device is open"},
    SessionStateName{SessionState::open, "open", "The pose of the grip is not known"},
    SessionStateName{SessionState::homed, "homed", "Released: no force until arm"},
    SessionStateName{SessionState::armed, "armed", "The force follows the motion"},
    SessionStateName{SessionState::held, "held", "No force; it comes back by itself"},
    SessionStateName{SessionState::faulted, "faulted", "No force after a fault until arm"},
};

/// Returns "closed" and so on.
constexpr const char *name_of(SessionState state) noexcept {
  return kSessionStates[static_cast<std::size_t>(state)].name;
}

struct SessionTransition {
  SessionState from;
  SessionState to;

  bool operator==(const SessionTransition &) const = default;
};

/// Every transition that happens. Others go by way of these.
inline constexpr std::array kSessionTransitions = {
    SessionTransition{SessionState::closed, SessionState::open},
    SessionTransition{SessionState::open, SessionState::homed},
    SessionTransition{SessionState::open, SessionState::faulted},
    SessionTransition{SessionState::open, SessionState::closed},
    SessionTransition{SessionState::homed, SessionState::armed},
    SessionTransition{SessionState::homed, SessionState::faulted},
    SessionTransition{SessionState::homed, SessionState::closed},
    SessionTransition{SessionState::armed, SessionState::held},
    SessionTransition{SessionState::armed, SessionState::homed},
    SessionTransition{SessionState::armed, SessionState::faulted},
    SessionTransition{SessionState::armed, SessionState::closed},
    SessionTransition{SessionState::held, SessionState::armed},
    SessionTransition{SessionState::held, SessionState::homed},
    SessionTransition{SessionState::held, SessionState::faulted},
    SessionTransition{SessionState::held, SessionState::closed},
    SessionTransition{SessionState::faulted, SessionState::homed},
    SessionTransition{SessionState::faulted, SessionState::open},
    SessionTransition{SessionState::faulted, SessionState::closed},
};

/// Returns the state for these holds (HapticLoop::reasons()). `homed`: the pose was known since the
/// device was opened, or there is no hand.
SessionState session_state(std::uint32_t holds, bool homed) noexcept;

/// Returns the names of the holds that explain the state, separated by commas: all of them in
/// `held`, the latches in `homed` and `faulted`, else none.
std::string session_reason(std::uint32_t holds, SessionState state);

/// What the user is told.
struct SessionStatus {
  SessionState state = SessionState::closed;
  std::string reason;
  std::string device; ///< description; empty while none is open

  bool operator==(const SessionStatus &) const = default;
};

/// What the state follows from: session_state().
struct SessionCause {
  std::uint32_t holds = 0;
  bool homed = false;
  std::int64_t time = 0; ///< ns
};

/// Follows the holds by the transitions of the table. Those of the film (nothing measured, no
/// sample, a cut, a late tick) may come and go with every frame: it follows them once they have
/// lasted for 0.2 s. Any thread.
class SessionStateMachine {
public:
  /// Reads the cause and calls `on_change` for each state on the way, with a lock held: in order,
  /// also when several threads call, and no older cause comes after a newer one. Neither must call
  /// back.
  void update(const std::function<SessionCause()> &read,
              const std::function<void(const SessionStatus &)> &on_change);
  SessionState state() const;
  /// For the next update().
  void set_device(std::string description);

private:
  std::uint32_t settled(const SessionCause &cause);

  mutable std::mutex mutex_;
  std::uint32_t of_film_ = 0; // mutex_; as told
  std::int64_t as_told_ = 0;  // mutex_; ns, when the holds of the film were so last
  SessionStatus status_;      // mutex_
  std::string device_;        // mutex_
};

} // namespace haptic
