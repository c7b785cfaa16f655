// Force laws: what a seen motion feels like. Everything about limits, smoothing and silence comes
// after them (safety-chain.hpp), so that no law can be unsafe.
#pragma once

#include "motion-scale.hpp"

#include <memory>
#include <span>
#include <spidar/types.hpp>

namespace haptic {

/// The grip, for laws that ask how the hand moves.
struct Hand {
  spidar::Pose pose;
  spidar::Vector3 velocity = spidar::Vector3::Zero(); ///< m/s
};

/// Properties of the element that shape the law.
struct LawSettings {
  double max_force = 1.0; ///< N
  double alpha = 0.01;    ///< s/px, the paper's
};

/// No clock, no device. Used by one thread; real-time safe.
class ForceLaw {
public:
  virtual ~ForceLaw() = default;

  /// Force on the grip, N: x to the right, y up, z towards the user.
  virtual spidar::Vector3 force(const Motion &motion, const Hand &hand,
                                const LawSettings &settings) noexcept = 0;
};

struct ForceLawInfo {
  const char *name;        ///< value of the property `force-law`
  const char *description; ///< for gst-inspect-1.0
  std::unique_ptr<ForceLaw> (*make)();
};

/// All laws there are; the first is the default.
std::span<const ForceLawInfo> force_laws() noexcept;

} // namespace haptic
