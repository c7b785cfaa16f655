// SPDX-License-Identifier: LGPL-2.1-or-later
// What touching adds to a tick of the loop: the surface at this time, and the force of contact.
#pragma once

#include "safety/safety-chain.hpp"
#include "touch/contact-law.hpp"
#include "touch/relief-timeline.hpp"

#include <cstdint>
#include <utility>

namespace haptic {

/// What is felt (property `touch`).
enum class TouchMode {
  off,               ///< the motion
  surface,           ///< the relief
  surface_and_motion ///< both: the sum of their forces
};

/// One thread; real-time safe. Times in ns of the running time.
class Touch {
public:
  void add(TimedRelief relief, std::int64_t now) noexcept { timeline_.add(std::move(relief), now); }
  void clear() noexcept {
    timeline_.clear();
    at_ = {};
    law_.restart();
  }
  /// Without a hand, or not used.
  void leave() noexcept { law_.restart(); }
  void hold() noexcept { law_.hold(); } ///< the force is held
  void calibrate() noexcept { law_.sink(); }
  /// While the time stands still it is not called, and the surface stays.
  void update(std::int64_t now) noexcept { at_ = timeline_.at(now); }
  /// The force on this hand; zero where there is no surface that is known and not stale.
  void step(const spidar::Vector3 &hand, const spidar::Vector3 &half, const FrameShift &shift,
            const ContactLimits &limits, double dt) noexcept;
  /// Makes the chain's input that of the surface, or of surface and motion.
  void apply(TouchMode mode, SafetyChain::Input &input) const noexcept;

  const Contact &contact() const noexcept { return law_.contact(); }
  double damping() const noexcept { return law_.damping(); } ///< N·s/m
  bool cut() const noexcept { return at_.cut; }

private:
  bool is_known() const noexcept { return at_.to && at_.age <= stale_after(at_.interval); }

  ReliefTimeline timeline_;
  ReliefAt at_; // its reliefs are those of the timeline
  ContactLaw law_;
};

} // namespace haptic
