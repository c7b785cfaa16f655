// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion sample: the motion of one frame, as velocityavg puts it into haptics/x-raw buffers.
#pragma once

#include "samples/held-place.hpp"
#include "samples/planar-motion.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// One buffer of these caps holds exactly one motion sample. The caps may also carry width, height,
/// pixel-aspect-ratio and framerate of the frame; the sample repeats what is needed to
/// understand it alone, because caps do not survive a file or a network.
#define HAPTIC_MOTION_CAPS "haptics/x-raw, modality=(string)velocity, layout=(string)point"

namespace haptic {

/// The smallest motion model that explains the frame.
enum class MotionModel : std::uint8_t { none, still, translation, similarity, affine };

/// "none", "static", "translation", "similarity" or "affine".
std::string_view motion_model_name(MotionModel model) noexcept;

/// Bits of MotionSample::flags.
enum MotionFlags : std::uint16_t {
  kMotionStill = 1 << 0,         ///< the pixels did not change
  kMotionDuplicate = 1 << 1,     ///< the frame repeats the one before; the velocity is held
  kMotionCut = 1 << 2,           ///< another scene began
  kMotionDiscontinuity = 1 << 3, ///< there is no earlier frame to compare with
  kMotionMixture = 1 << 4,       ///< two motions in the region; the velocity is their mean by area
  kMotionAperture = 1 << 5, ///< only edges of one direction: the velocity is the part across them
};

/// The flags of a frame as a whole, which metadata and fields have too. The others describe the one
/// velocity of a sample.
inline constexpr std::uint16_t kFrameFlags =
    kMotionStill | kMotionDuplicate | kMotionCut | kMotionDiscontinuity;

/// The motion of one frame, with what is needed to understand it alone. Seconds are those of the
/// time stamps. Positions and sizes are fractions of the frame, origin at its top left corner.
struct MotionSample : PlanarMotion {
  float pointer_x = 0.5F;           ///< 0..1
  float pointer_y = 0.5F;           ///< 0..1
  float region_width = 0;           ///< 0..1
  float region_height = 0;          ///< 0..1
  float confidence = 0;             ///< 0..1; 0 means that nothing was measured
  std::uint64_t interval = 0;       ///< ns between the two frames, 0 when there is none
  std::uint32_t frame_width = 0;    ///< px
  std::uint32_t frame_height = 0;   ///< px
  std::uint32_t pixel_aspect_n = 1; ///< pixel width : height
  std::uint32_t pixel_aspect_d = 1;
  std::uint16_t points = 0; ///< patches that agree with the velocity
  std::uint16_t flags = 0;  ///< MotionFlags
  MotionModel model = MotionModel::none;
  HeldPlace held; ///< none: nothing is pressed

  PlanarMotion &motion() noexcept { return *this; }
  const PlanarMotion &motion() const noexcept { return *this; }

  bool operator==(const MotionSample &) const = default;
};

/// Bytes of a packed sample (docs/formats/motion-sample.md), and of one with a thing that was
/// taken.
inline constexpr std::size_t kMotionSampleSize = 72;
inline constexpr std::size_t kHeldMotionSampleSize = 96;

/// The bytes of one sample, a contiguous range.
class MotionSampleBytes {
public:
  const std::uint8_t *data() const noexcept { return bytes_.data(); }
  std::size_t size() const noexcept { return size_; }
  const std::uint8_t *begin() const noexcept { return data(); }
  const std::uint8_t *end() const noexcept { return data() + size_; }
  std::uint8_t operator[](std::size_t at) const noexcept { return bytes_[at]; }

private:
  friend MotionSampleBytes pack_motion_sample(const MotionSample &sample) noexcept;
  std::array<std::uint8_t, kHeldMotionSampleSize> bytes_{};
  std::size_t size_ = kMotionSampleSize;
};

/// Little-endian on every machine. Cannot fail.
MotionSampleBytes pack_motion_sample(const MotionSample &sample) noexcept;

/// Whether every number is finite and in its range. A reader refuses other samples.
bool is_valid(const MotionSample &sample) noexcept;

/// Returns the sample, or nothing if the bytes are not one of this version or a number is outside
/// its range. Never reads beyond `bytes`. Accepts longer input than kHeldMotionSampleSize: later
/// versions may add fields at the end.
std::optional<MotionSample> unpack_motion_sample(std::span<const std::uint8_t> bytes) noexcept;

} // namespace haptic
