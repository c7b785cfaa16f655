// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/motion-reader.hpp"

#include "patches/measurement.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>

namespace haptic {
namespace {

// The metadata's header stands alone, so that it names the flags once more.
constexpr bool equal(GstHapticMotionFlags of_metadata, MotionFlags of_sample) {
  return static_cast<int>(of_metadata) == static_cast<int>(of_sample);
}
static_assert(equal(GST_HAPTIC_MOTION_STILL, kMotionStill));
static_assert(equal(GST_HAPTIC_MOTION_DUPLICATE, kMotionDuplicate));
static_assert(equal(GST_HAPTIC_MOTION_CUT, kMotionCut));
static_assert(equal(GST_HAPTIC_MOTION_DISCONTINUITY, kMotionDiscontinuity));

static_assert(static_cast<int>(GST_HAPTIC_MOTION_TILED) == kTiled);

constexpr bool equal(GstHapticHold of_metadata, HoldState of_sample) {
  return static_cast<int>(of_metadata) == static_cast<int>(of_sample);
}
static_assert(equal(GST_HAPTIC_HOLD_NONE, HoldState::none));
static_assert(equal(GST_HAPTIC_HOLD_HELD, HoldState::held));
static_assert(equal(GST_HAPTIC_HOLD_ABOUT, HoldState::about));
static_assert(equal(GST_HAPTIC_HOLD_HIDDEN, HoldState::hidden));
static_assert(equal(GST_HAPTIC_HOLD_LOST, HoldState::lost));
static_assert(equal(GST_HAPTIC_HOLD_REFUSED, HoldState::refused));

std::uint16_t sample_flags(guint meta_flags) {
  return static_cast<std::uint16_t>(meta_flags & kFrameFlags);
}

void set_motion(MotionSample &sample, const VelocityEstimate &estimate) {
  sample.motion() = estimate.motion();
  sample.confidence = estimate.confidence;
  sample.points = static_cast<std::uint16_t>(estimate.points);
  sample.model = estimate.model;
  if (estimate.mixture)
    sample.flags |= kMotionMixture;
  if (estimate.aperture)
    sample.flags |= kMotionAperture;
}

void repeat_motion(MotionSample &sample, const MotionSample &before) {
  sample.motion() = before.motion();
  sample.confidence = before.confidence;
  sample.points = before.points;
  sample.model = before.model;
  constexpr auto kOfTheMotion = kMotionMixture | kMotionAperture;
  sample.flags = static_cast<std::uint16_t>(sample.flags | (before.flags & kOfTheMotion));
}

// The fields that every sample has, also one without a measurement.
MotionSample sample_for(const GstVideoInfo &frame) {
  MotionSample sample;
  sample.frame_width = static_cast<std::uint32_t>(GST_VIDEO_INFO_WIDTH(&frame));
  sample.frame_height = static_cast<std::uint32_t>(GST_VIDEO_INFO_HEIGHT(&frame));
  sample.pixel_aspect_n = static_cast<std::uint32_t>(GST_VIDEO_INFO_PAR_N(&frame));
  sample.pixel_aspect_d = static_cast<std::uint32_t>(GST_VIDEO_INFO_PAR_D(&frame));
  return sample;
}

// Zero for NaN, too.
float fraction(float part, guint whole) {
  return part > 0 && whole > 0 ? std::min(part / static_cast<float>(whole), 1.0F) : 0.0F;
}

HeldPlace held_place(const GstHapticMotionMeta &meta) {
  if (meta.hold == GST_HAPTIC_HOLD_NONE || meta.hold > GST_HAPTIC_HOLD_REFUSED)
    return {};
  return {static_cast<HoldState>(meta.hold), fraction(meta.held_x, meta.frame_width),
          fraction(meta.held_y, meta.frame_height), fraction(meta.held_radius, meta.frame_width),
          meta.held_time};
}

void set_place(MotionSample &sample, const GstHapticMotionMeta &meta) {
  sample.pointer_x = fraction(meta.pointer_x, meta.frame_width);
  sample.pointer_y = fraction(meta.pointer_y, meta.frame_height);
  sample.region_width = fraction(meta.region_width, meta.frame_width);
  sample.region_height = fraction(meta.region_height, meta.frame_height);
  sample.held = held_place(meta);
}

// Whether the motion of the frame is that of a thing which cannot be seen.
bool is_unseen(HoldState state) {
  return state == HoldState::hidden || state == HoldState::lost || state == HoldState::refused;
}

} // namespace

MotionSample MotionReader::read_nothing(const GstVideoInfo &frame) {
  return last_ = sample_for(frame);
}

MotionSample MotionReader::read(const GstHapticMotionMeta &meta, const GstVideoInfo &frame,
                                Average average, ModelChoice choice) {
  MotionSample sample = sample_for(frame);
  set_place(sample, meta);
  sample.interval = meta.interval;
  sample.flags = sample_flags(meta.flags);
  if (meta.flags & (GST_HAPTIC_MOTION_DISCONTINUITY | GST_HAPTIC_MOTION_CUT) ||
      is_unseen(sample.held.state)) {
    history_ = {};
    return last_ = sample;
  }
  if (meta.flags & GST_HAPTIC_MOTION_STILL) {
    sample.confidence = 1;
    sample.model = MotionModel::still;
    history_ = {.current = MotionModel::still};
  } else if (meta.flags & GST_HAPTIC_MOTION_DUPLICATE) {
    repeat_motion(sample, last_);
  } else if (meta.interval > 0) {
    const auto patches = std::span(meta.patches)
                             .first(std::min<std::size_t>(meta.n_patches, std::size(meta.patches)));
    const bool is_held = is_followed(sample.held.state);
    const PatchSet set{
        .patches = patches,
        .candidates = static_cast<int>(meta.n_candidates),
        .pointer_x = is_held ? meta.held_x : meta.pointer_x,
        .pointer_y = is_held ? meta.held_y : meta.pointer_y,
        .interval = static_cast<double>(meta.interval) / GST_SECOND,
        .region_x = meta.region_x,
        .region_y = meta.region_y,
        .region_width = meta.region_width,
        .region_height = meta.region_height,
        .is_tiled = (meta.flags & GST_HAPTIC_MOTION_TILED) != 0,
    };
    const VelocityEstimate estimate = estimate_velocity(set, average, choice, history_);
    history_ = estimate.history;
    set_motion(sample, estimate);
  }
  return last_ = sample;
}

void set_motion(GstStructure *to, const MotionSample &sample) {
  const auto number = [](float value) { return static_cast<double>(value); };
  const std::string model(motion_model_name(sample.model));
  gst_structure_set(
      to, "interval", G_TYPE_UINT64, sample.interval, "vx", G_TYPE_DOUBLE,
      number(sample.velocity_x), "vy", G_TYPE_DOUBLE, number(sample.velocity_y), "spin",
      G_TYPE_DOUBLE, number(sample.spin), "divergence", G_TYPE_DOUBLE, number(sample.divergence),
      "confidence", G_TYPE_DOUBLE, number(sample.confidence), "points", G_TYPE_UINT,
      static_cast<guint>(sample.points), "model", G_TYPE_STRING, model.c_str(), nullptr);
  const HeldPlace &held = sample.held;
  if (held.state == HoldState::none)
    return;
  const std::string state(hold_state_name(held.state));
  gst_structure_set(to, "held", G_TYPE_STRING, state.c_str(), "hold-x", G_TYPE_DOUBLE,
                    number(held.x), "hold-y", G_TYPE_DOUBLE, number(held.y), "hold-radius",
                    G_TYPE_DOUBLE, number(held.radius), "hold-time", G_TYPE_UINT64, held.time,
                    nullptr);
}

} // namespace haptic
