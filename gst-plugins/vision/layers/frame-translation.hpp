// SPDX-License-Identifier: LGPL-2.1-or-later
// The translation of the whole frame, from small patches spread over it: nothing inside a crop
// tells a coded sky that moves from one at rest. The cost does not depend on the size of the frame.
#pragma once

#include "pixels/kept-luma.hpp"
#include "pixels/tensor.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace haptic {

/// Two frames of one size, whole.
struct FramePair {
  const LumaSource &earlier;
  const LumaSource &later;
  int width = 0;  ///< px
  int height = 0; ///< px
};

struct FrameMotion {
  Displacement displacement; ///< px
  /// How surely the whole frame moved by it, 0..1: at once where many patches tell, else by what
  /// they told in the last 0.5 s.
  float certainty = 0;
  bool is_unchanged = false; ///< no pixel of any patch changed
};

/// One instance serves one stream. Call it for each pair of consecutive frames.
class FrameTranslation {
public:
  void forget() {
    motion_ = {};
    moving_ = all_ = 0;
    asked_ = 0;
  }

  /// Starts from the translation before. `other`: a second start, px. It and the motion of one
  /// patch are tried where the first explains little, and used if they explain clearly more.
  /// `noise`: variance of a pixel. `seconds`: between the frames.
  FrameMotion follow(const FramePair &frames, float seconds, float noise, Displacement other);

  /// A patch of the later frame with its gradients.
  static constexpr int kWide = 8; // px; whole vectors
  static constexpr int kHigh = 8;
  static constexpr int kColumns = 12;
  static constexpr int kRows = 8;
  struct alignas(64) Sample { // whole vectors
    std::array<float, std::size_t{kWide} * kHigh> luma, gx, gy;
    int x, y;         // its corner in the frame, px
    Tensor structure; // mean of g g'
    float at_rest;    // mean squared difference without displacement
  };
  /// Compared with the earlier frame.
  struct Difference {
    float energy; // mean square
    Displacement moment;
  };

private:
  struct Fit {
    Displacement at;
    float moving = 0;    // sum over the patches that prefer it to rest, by how much they can tell
    float all = 0;       // the same over all patches
    float textured = 0;  // the same as if each could tell
    float explained = 0; // the part of it that rest or the displacement explains
    float extent2 = 0;   // square of how far apart those lie that prefer it (rms), in sides
  };
  void sample(const FramePair &frames);
  /// The differences at a displacement; false: the patch would lie outside the frame.
  bool compare(const FramePair &frames, const Sample &sample, Displacement by,
               Difference &difference);
  Fit share_of(const FramePair &frames, Displacement at, float noise);
  Fit refine(const FramePair &frames, Displacement start, float noise);
  Displacement motion_of_one(const FramePair &frames);
  float believe(const Fit &fit, float seconds);
  LumaView read(const LumaSource &source, const Rectangle &area);

  FrameMotion motion_;
  float moving_ = 0; // s, sums of Fit over a memory
  float all_ = 0;
  std::size_t count_ = 0;
  std::size_t asked_ = 0; // the patch whose own motion was a start
  std::array<Sample, static_cast<std::size_t>(kColumns) * kRows> samples_;
  std::vector<std::uint8_t> scratch_;
};

} // namespace haptic
