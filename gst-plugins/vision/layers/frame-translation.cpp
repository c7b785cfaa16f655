// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/frame-translation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

// Patches are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "layers/frame-translation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kAcross = FrameTranslation::kWide;
constexpr int kDown = FrameTranslation::kHigh;
constexpr float kPart = 1.0F / (kAcross * kDown);

using Tag = hn::CappedTag<float, kAcross>;
using Vec = hn::Vec<Tag>;
using Integers = hn::Vec<hn::Rebind<std::int32_t, Tag>>;
constexpr Tag kTag;

HWY_INLINE Integers load(const std::uint8_t *from) {
  const hn::Rebind<std::uint8_t, Tag> bytes;
  return hn::PromoteTo(hn::Rebind<std::int32_t, Tag>(), hn::LoadU(bytes, from));
}

HWY_INLINE float mean(Vec sum) {
  return kPart * hn::GetLane(hn::SumOfLanes(kTag, sum));
}

// `view`: the patch with a border of 1 px.
void TakeSample(const LumaView &view, FrameTranslation::Sample &sample) {
  const Vec half = hn::Set(kTag, 0.5F);
  sample.structure = {};
  for (int x = 0; x < kAcross; x += static_cast<int>(hn::Lanes(kTag))) {
    Vec xx = hn::Zero(kTag);
    Vec xy = hn::Zero(kTag);
    Vec yy = hn::Zero(kTag);
    const std::uint8_t *here = view.pixels + view.stride + x + 1;
    Integers up = load(here - view.stride);
    Integers middle = load(here);
    for (int y = 0; y < kDown; ++y, here += view.stride) {
      const Integers down = load(here + view.stride);
      const Vec gx = half * hn::ConvertTo(kTag, load(here + 1) - load(here - 1));
      const Vec gy = half * hn::ConvertTo(kTag, down - up);
      const int at = y * kAcross + x;
      hn::StoreU(hn::ConvertTo(kTag, middle), kTag, sample.luma.data() + at);
      hn::StoreU(gx, kTag, sample.gx.data() + at);
      hn::StoreU(gy, kTag, sample.gy.data() + at);
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
      up = middle;
      middle = down;
    }
    sample.structure += {mean(xx), mean(xy), mean(yy)};
  }
}

// `view`: a pixel more than the patch on its right and below.
void CompareSample(const LumaView &view, float part_x, float part_y,
                   const FrameTranslation::Sample &sample,
                   FrameTranslation::Difference &difference) {
  difference = {};
  for (int x = 0; x < kAcross; x += static_cast<int>(hn::Lanes(kTag))) {
    const auto across = [&](int y) HWY_ATTR {
      const std::uint8_t *from = view.pixels + y * view.stride + x;
      const Integers first = load(from);
      return hn::MulAdd(hn::Set(kTag, part_x), hn::ConvertTo(kTag, load(from + 1) - first),
                        hn::ConvertTo(kTag, first));
    };
    Vec squares = hn::Zero(kTag);
    Vec moment_x = hn::Zero(kTag);
    Vec moment_y = hn::Zero(kTag);
    Vec above = across(0);
    for (int y = 0; y < kDown; ++y) {
      const Vec below = across(y + 1);
      const int at = y * kAcross + x;
      const Vec e = hn::MulAdd(hn::Set(kTag, part_y), below - above, above) -
                    hn::LoadU(kTag, sample.luma.data() + at);
      squares += e * e;
      moment_x += hn::LoadU(kTag, sample.gx.data() + at) * e;
      moment_y += hn::LoadU(kTag, sample.gy.data() + at) * e;
      above = below;
    }
    difference.energy += mean(squares);
    difference.moment += {mean(moment_x), mean(moment_y)};
  }
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(TakeSample);
HWY_EXPORT(CompareSample);

constexpr float kFarthestFrame = 64; // px a frame
constexpr float kLeastMotion = 0.1F; // px a frame: less is the drift of clouds
constexpr float kLeastTrace = 2;     // of a patch that can show anything
constexpr float kPatchRidge = 2;     // (grey levels / px)^2: what a patch shows by its noise

// How well a displacement explains a patch, 0..1. A difference of two pixels has twice the variance
// of the noise; a texture has a part that no interpolation gives back.
float explained(float energy, float trace, float noise) {
  const float usual = 4 + 2.4F * noise + 0.1F * trace;
  const float part = usual / (usual + energy);
  return part * part;
}

// -1: the patch rests, 1: it moves. What a residual means in itself, a coder decides; which one is
// smaller, the motion does.
float preference(float at_rest, float moved, float noise) {
  constexpr float kRounding = 1; // grey levels squared
  return (at_rest - moved) / (at_rest + moved + kRounding + 1.2F * noise);
}

Displacement step_of(const Tensor &structure, Displacement moment) {
  constexpr float kMostStep = 1.5F; // px
  return at_most(kMostStep, solve(structure, moment, kPatchRidge));
}

void prefetch(const LumaView &view) {
  if (!view.pixels)
    return;
  for (int y = 0; y < view.height; ++y) {
    __builtin_prefetch(view.pixels + y * view.stride);
    __builtin_prefetch(view.pixels + y * view.stride + view.width - 1);
  }
}

} // namespace

LumaView FrameTranslation::read(const LumaSource &source, const Rectangle &area) {
  if (const LumaView plane = source.plane(area); plane.pixels)
    return plane;
  scratch_.resize(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
  source.convert(area, scratch_.data(), area.width);
  return {scratch_.data(), area.width, area.height, area.width};
}

void FrameTranslation::sample(const FramePair &frames) {
  count_ = 0;
  motion_.is_unchanged = true;
  const auto corner = [](int i, int parts, int length, int side) {
    return (2 * i + 1) * length / (2 * parts) - side / 2;
  };
  // The patches lie far from each other in memory: waiting for one after the other takes longer
  // than all that is computed.
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const int x = corner(column, kColumns, frames.width, kWide);
      const int y = corner(row, kRows, frames.height, kHigh);
      if (x >= 1 && y >= 1 && x + kWide < frames.width && y + kHigh < frames.height)
        for (const LumaSource *source : {&frames.later, &frames.earlier})
          prefetch(source->plane({x - 1, y - 1, kWide + 2, kHigh + 2}));
    }
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      Sample &sample = samples_[count_];
      sample.x = corner(column, kColumns, frames.width, kWide);
      sample.y = corner(row, kRows, frames.height, kHigh);
      if (sample.x < 1 || sample.y < 1 || sample.x + kWide >= frames.width ||
          sample.y + kHigh >= frames.height)
        continue;
      const LumaView view = read(frames.later, {sample.x - 1, sample.y - 1, kWide + 2, kHigh + 2});
      HWY_DYNAMIC_DISPATCH(TakeSample)(view, sample);
      Difference rest;
      compare(frames, sample, {}, rest);
      motion_.is_unchanged = motion_.is_unchanged && rest.energy == 0;
      sample.at_rest = rest.energy;
      if (trace(sample.structure) < kLeastTrace)
        continue;
      ++count_;
    }
}

bool FrameTranslation::compare(const FramePair &frames, const Sample &sample, Displacement by,
                               Difference &difference) {
  const float left = std::floor(-by.x);
  const float up = std::floor(-by.y);
  const Rectangle area{sample.x + static_cast<int>(left), sample.y + static_cast<int>(up),
                       kWide + 1, kHigh + 1};
  if (area.x < 0 || area.y < 0 || area.x + area.width > frames.width ||
      area.y + area.height > frames.height)
    return false;
  HWY_DYNAMIC_DISPATCH(CompareSample)
  (read(frames.earlier, area), -by.x - left, -by.y - up, sample, difference);
  return true;
}

// A patch that neither rest nor the displacement explains shows a thing of its own.
FrameTranslation::Fit FrameTranslation::share_of(const FramePair &frames, Displacement at,
                                                 float noise) {
  constexpr float kHalf = 30; // trace that counts by half
  if (norm2(at) < kLeastMotion * kLeastMotion)
    return {.at = at};
  Fit fit{.at = at};
  Displacement places;
  float squares = 0; // of their distances from the corner
  for (std::size_t i = 0; i < count_; ++i) {
    const Sample &sample = samples_[i];
    Difference moved;
    if (!compare(frames, sample, at, moved))
      continue;
    const float shows = trace(sample.structure);
    const float prefers = preference(sample.at_rest, moved.energy, noise);
    const float texture = shows / (shows + kHalf);
    const float known = texture * explained(std::min(sample.at_rest, moved.energy), shows, noise);
    const float weight = std::abs(prefers) * known;
    fit.textured += texture;
    fit.explained += known;
    fit.all += weight;
    if (prefers <= 0)
      continue;
    const Displacement place{static_cast<float>(sample.x) / static_cast<float>(frames.width),
                             static_cast<float>(sample.y) / static_cast<float>(frames.height)};
    fit.moving += weight;
    places += weight * place;
    squares += weight * norm2(place);
  }
  if (fit.moving > 0)
    fit.extent2 = squares / fit.moving - norm2(1 / fit.moving * places);
  return fit;
}

// Patches that rest, or that a coder left standing, would pull the translation towards rest.
FrameTranslation::Fit FrameTranslation::refine(const FramePair &frames, Displacement start,
                                               float noise) {
  constexpr int kSteps = 2;
  constexpr float kArrived2 = 0.01F * 0.01F;
  constexpr float kLeastWeight = 0.02F; // one patch in fifty: else nothing is left at a wrong start
  Displacement at = start;
  for (int i = 0; i < kSteps; ++i) {
    Tensor structure;
    Displacement moment;
    for (std::size_t k = 0; k < count_; ++k) {
      const Sample &sample = samples_[k];
      Difference moved;
      if (!compare(frames, sample, at, moved))
        continue;
      const float shows = trace(sample.structure);
      const float prefers = preference(sample.at_rest, moved.energy, noise);
      const float weight = explained(moved.energy, shows, noise) / (1 + 0.02F * shows) *
                           std::max(kLeastWeight, 0.5F + 0.5F * prefers);
      structure += weight * sample.structure;
      moment += weight * moved.moment;
    }
    const Displacement step = step_of(structure, moment);
    at += step;
    at = {std::clamp(at.x, -kFarthestFrame, kFarthestFrame),
          std::clamp(at.y, -kFarthestFrame, kFarthestFrame)};
    if (norm2(step) < kArrived2)
      break;
  }
  return share_of(frames, at, noise);
}

// The motion of one patch, another one with each pair: things that move alike can keep the
// translation from that of the background, which no small step finds.
Displacement FrameTranslation::motion_of_one(const FramePair &frames) {
  constexpr int kSteps = 4;           // 6 px at most
  constexpr std::size_t kApart = 101; // a prime beyond the number of patches: all come in turn
  if (count_ == 0)
    return {};
  asked_ = (asked_ + kApart) % count_;
  const Sample &sample = samples_[asked_];
  Displacement at;
  Difference moved;
  for (int i = 0; i < kSteps && compare(frames, sample, at, moved); ++i)
    at += step_of(sample.structure, moved.moment);
  return at;
}

// How surely the frame moves so. In a picture that was coded, parts stand for a frame or two; in a
// soft one no patch tells much, but nearly all tell the same for a time. A camera that stops and a
// cut are soon forgotten. A thing before a blank sky is told by its own patches alone. The limits
// were chosen on the tuning films of tests/measure/felt.
float FrameTranslation::believe(const Fit &fit, float seconds) {
  constexpr float kMemory = 0.5F;           // s
  constexpr float kContradicted = 0.7F;     // of the memory, kept in a pair
  constexpr float kContradicts = 0.25F;     // of what the patches tell
  constexpr float kHardly = 0.1F;           // of the texture
  constexpr float kLongest = 1.0F / 30;     // s: a pair after a pause is still one pair
  constexpr float kLeast = 0.1F;            // s, times patches
  constexpr float kWidely2 = 0.15F * 0.15F; // sides of the frame, squared
  constexpr float kNotYet = 0.45F;          // of what the patches tell: waves in grass reach it
  constexpr float kRamp = 0.1F;
  const bool agrees = fit.all > 0 && fit.moving >= kContradicts * fit.all &&
                      fit.explained >= kHardly * fit.textured;
  const float kept = agrees ? std::exp(-seconds / kMemory) : kContradicted;
  const float weight = std::min(seconds, kLongest);
  moving_ = kept * moving_ + (fit.extent2 < kWidely2 ? 0 : weight * fit.moving);
  all_ = kept * all_ + weight * fit.all;
  const float x = std::clamp((moving_ / (all_ + kLeast) - kNotYet) / kRamp, 0.0F, 1.0F);
  return x * x * (3 - 2 * x);
}

FrameMotion FrameTranslation::follow(const FramePair &frames, float seconds, float noise,
                                     Displacement other) {
  constexpr float kMost = 0.6F;          // of the texture: a pan that was not coded explains 0.75
  constexpr float kMore = 0.5F;          // patches, that agree by chance
  constexpr float kOther2 = 0.4F * 0.4F; // px squared: nearer, the first start leads there too
  sample(frames);
  Fit fit = refine(frames, motion_.displacement, noise);
  const auto try_from = [&](Displacement start) {
    if (norm2(start - fit.at) <= kOther2 ||
        share_of(frames, start, noise).moving <= fit.moving + kMore)
      return;
    if (const Fit there = refine(frames, start, noise); there.moving > fit.moving)
      fit = there;
  };
  if (fit.moving <= kMost * fit.textured) {
    try_from(other);
    try_from(motion_of_one(frames));
  }
  motion_.certainty = believe(fit, seconds);
  const bool is_nowhere = motion_.certainty == 0 && 2 * fit.moving < fit.all;
  motion_.displacement = is_nowhere ? Displacement{} : fit.at;
  return motion_;
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
