// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/calm-cells.hpp"

#include "layers/layer-kernels.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

// A leaf sways to and fro within a second: over this time, what is behind it changes less.
constexpr float kBase = 0.133F;        // s
constexpr float kCalmMemory = 0.25F;   // s
constexpr float kTextureMemory = 2;    // s: a cell that had texture is believed to be flat later
constexpr float kFollowMemory = 0.55F; // s
constexpr float kStart = 0.8F;         // calm, but not by much
constexpr float kRestless = 1.5F;      // where there is texture
constexpr float kMostChange = 4;       // of a cell in one frame, in units of what is expected
constexpr float kMostEnergy = 100;     // grey levels squared: a leaf that passes is no evidence

// As far as the rounding of a byte matters, beside the noise.
float rounding_and(float noise) {
  return 1 + 1.2F * noise;
}

// The part of the way to a new value after a time.
float step_of(float seconds, float memory) {
  return 1 - std::exp(-seconds / memory);
}

} // namespace

void CalmCells::forget() {
  count_ = 0;
  calm_.values.fill(kStart);
  for (CellMap *map :
       {&at_rest_energy_, &displaced_energy_, &background_, &rests_, &follows_, &shows_})
    map->values.fill(0);
  at_rest_sum_ = displaced_sum_ = 0;
}

void CalmCells::keep(const LayerFrame &frame, const LayerSize &size, Past &past) {
  for (int y = 0; y < size.height; ++y) // and the pixel that repeats the last one of a row
    std::copy_n(frame.smooth.row(y), size.width + 1, past.smooth.row(y));
  past.flat = frame.flat;
  past.since = {.before = size, .after = size};
}

void CalmCells::carry(const CropMove &move, const LayerFrame &earlier) {
  haptic::carry(move, kStart, calm_);
  haptic::carry(move, 0, at_rest_energy_);
  haptic::carry(move, 0, displaced_energy_);
  for (Past &past : ring_) {
    past.since.right += move.right;
    past.since.down += move.down;
    past.since.after = move.after;
  }
  if (count_ > 0)
    keep(earlier, move.after, ring_[static_cast<std::size_t>((count_ - 1) % kRing)]);
}

// Cells that it did not show are those of the frame before. Only the frame that is compared is
// moved: all of them would take longer than the rest of an update.
const CalmCells::Past &CalmCells::as_seen_now(int frames) {
  const Past &old = past(frames);
  const CropMove &since = old.since;
  if (since.right == 0 && since.down == 0 && since.before == since.after)
    return old;
  const Past &last = past(1);
  moved_.smooth = last.smooth;
  moved_.flat = last.flat;
  moved_.since = since;
  copy_shared<kCellSide>(old.smooth, since, moved_.smooth);
  copy_shared<1>(old.flat, since, moved_.flat);
  return moved_;
}

// Compares the frame with the earlier one, displaced by what was found in between. False: it is not
// known, or too little to see.
bool CalmCells::displace(const Past &old, const LayerFrame &frame, const LayerSize &size,
                         const CalmStep &step, int base) {
  constexpr float kLeast2 = 1;         // px squared
  constexpr float kMostOfWidth = 0.6F; // else too little of the crop is left to compare
  Displacement shift = step.shift;
  bool is_known = step.has_shift && count_ >= base;
  for (int i = 1; i < base && is_known; ++i) {
    shift += past(i).shift;
    is_known = past(i).has_shift;
  }
  const float most = kMostOfWidth * static_cast<float>(size.width);
  if (!is_known || norm2(shift) <= kLeast2 || norm2(shift) >= most * most)
    return false;
  compare_displaced(old.smooth, frame.smooth, shift, size, displaced_change_);
  const CropMove &since = old.since;
  const Rectangle shown{-kCellSide * since.right, -kCellSide * since.down, since.before.width,
                        since.before.height};
  for_cells(size, [&](int x, int y) {
    if (!comes_from_inside(x, y, shift, size) || !comes_from_inside(x, y, shift, shown)) {
      displaced_change_.at(x, y) = change_.at(x, y);
    } else if (frame.flat.at(x, y) > 0) {
      const float rest = std::min(change_.at(x, y), kMostEnergy);
      const float displaced = std::min(displaced_change_.at(x, y), kMostEnergy);
      at_rest_energy_.at(x, y) += rest;
      displaced_energy_.at(x, y) += displaced;
      at_rest_sum_ += rest;
      displaced_sum_ += displaced;
    }
  });
  return true;
}

// y says how much can be seen, z which of the two explanations is better. Where nothing can be
// seen, the rest of the crop decides, and beyond it the frame.
void CalmCells::decide_followers(const LayerSize &size, const CalmStep &step) {
  constexpr float kNothing = 30; // grey levels squared, sum over the memory
  constexpr float kOfCrop = 20;  // times as much, for the whole crop
  constexpr float kLittle = 0.2F;
  constexpr float kMuch = 0.5F;
  static const auto kNear = gaussian<3>(1.25F);
  const float nothing = kNothing * rounding_and(step.noise);
  const float crop = std::clamp((at_rest_sum_ - displaced_sum_) /
                                    (at_rest_sum_ + displaced_sum_ + kOfCrop * nothing),
                                0.0F, 1.0F);
  CellMap rest;
  CellMap displaced;
  blur(kNear, size, at_rest_energy_, rest);
  blur(kNear, size, displaced_energy_, displaced);
  for_cells(size, [&](int x, int y) {
    const float sum = rest.at(x, y) + displaced.at(x, y);
    const float z = (rest.at(x, y) - displaced.at(x, y)) / (sum + nothing);
    const float seen = sum / (sum + nothing);
    const float follows = std::clamp(z + 0.5F * seen + crop * (1 - seen), 0.0F, 1.0F);
    follows_.at(x, y) = follows + step.frame_moves * (1 - follows);
    shows_.at(x, y) = std::clamp((z - kLittle) / (kMuch - kLittle), 0.0F, 1.0F);
  });
}

void CalmCells::update(const LayerFrame &frame, const LayerSize &size, const CalmStep &step) {
  const int wanted = static_cast<int>(std::lround(kBase / std::max(step.seconds, 1e-3F)));
  const int base = std::clamp(wanted, 1, kRing);
  const int available = std::min(base, count_);
  Past &now = ring_[static_cast<std::size_t>(count_ % kRing)];
  if (available > 0) {
    const Past &old = as_seen_now(available);
    compare(old.smooth, frame.smooth, size, change_);
    const float kept = std::exp(-step.seconds / kFollowMemory);
    for_cells(size, [&](int x, int y) {
      at_rest_energy_.at(x, y) *= kept;
      displaced_energy_.at(x, y) *= kept;
    });
    at_rest_sum_ *= kept;
    displaced_sum_ *= kept;
    const bool is_displaced = displace(old, frame, size, step, base);
    decide_followers(size, step);
    if (is_displaced)
      for_cells(size, [&](int x, int y) {
        change_.at(x, y) += follows_.at(x, y) * (displaced_change_.at(x, y) - change_.at(x, y));
      });
    constexpr float kTexture = 10;   // squared gradient
    constexpr float kMoved2 = 0.15F; // px squared, over the base
    for_cells(size, [&](int x, int y) {
      const float steep = frame.steepness.at(x, y);
      const bool is_changed = change_.at(x, y) > 2 * rounding_and(step.noise) + kMoved2 * steep;
      rests_.at(x, y) = steep < kTexture ? 0 : is_changed ? -1 : 1;
    });
    const float to_change = step_of(step.seconds, kCalmMemory);
    const float to_restless = step_of(step.seconds, kTextureMemory);
    for_cells(size, [&](int x, int y) {
      float &calm = calm_.at(x, y);
      if (!(frame.flat.at(x, y) > 0)) {
        calm += to_restless * (kRestless - calm);
      } else if (old.flat.at(x, y) > 0) {
        // A slope that drifts by a pixel changes by its steepness.
        const float expected = rounding_and(step.noise) +
                               1.5F * std::max(0.0F, frame.steepness.at(x, y) - step.noise / 4);
        calm += to_change * (std::min(kMostChange, change_.at(x, y) / expected) - calm);
      }
    });
  }
  CellMap near;
  blur(kBinomial, size, calm_, near);
  for_cells(size, [&](int x, int y) {
    background_.at(x, y) = near.at(x, y) > 1 ? 0 : frame.flat.at(x, y);
  });
  keep(frame, size, now);
  now.shift = step.shift;
  now.has_shift = step.has_shift;
  ++count_;
}

} // namespace haptic
