// SPDX-License-Identifier: LGPL-2.1-or-later
// Which cells are background: flat ones that change little, or as the frame's translation makes
// them change.
#pragma once

#include "layers/layer-maps.hpp"

#include <array>
#include <cstddef>

namespace haptic {

/// What one frame brings.
struct CalmStep {
  float seconds = 0;      ///< since the frame before
  float noise = 0;        ///< variance of a pixel, grey levels squared
  Displacement shift;     ///< of the whole frame or region since the frame before, px
  bool has_shift = false; ///< it is known
  float frame_moves = 0;  ///< how surely the whole frame moved by it, 0..1
};

/// One instance serves one place of one stream.
class CalmCells {
public:
  CalmCells() { forget(); }
  void forget();

  /// The crop went on. `earlier`: the frame of the update before, as the crop shows it now.
  void carry(const CropMove &move, const LayerFrame &earlier);

  void update(const LayerFrame &frame, const LayerSize &size, const CalmStep &step);

  /// 1: flat and calm, else 0.
  const CellMap &background() const { return background_; }

  /// How far each cell moves with the frame, 0..1: flat cells do not show it in one pair of frames.
  const CellMap &follows() const { return follows_; }

  /// How surely a flat cell itself was seen to move by the shift, and not to rest, 0..1.
  const CellMap &shows() const { return shows_; }

  /// 1 for cells whose texture is at rest or moves with the frame, -1 for cells whose texture
  /// moves, 0 for cells without texture.
  const CellMap &rests() const { return rests_; }

private:
  static constexpr int kRing = 8; // frames; 0.133 s at 60 a second

  struct Past {
    PixelMap smooth;
    CellMap flat;
    Displacement shift; // from the frame before it
    bool has_shift = false;
    CropMove since; // of the crop
  };
  const Past &past(int frames) const {
    return ring_[static_cast<std::size_t>((count_ - frames) % kRing)];
  }
  static void keep(const LayerFrame &frame, const LayerSize &size, Past &past);
  const Past &as_seen_now(int frames);
  bool displace(const Past &old, const LayerFrame &frame, const LayerSize &size,
                const CalmStep &step, int base);
  void decide_followers(const LayerSize &size, const CalmStep &step);

  int count_ = 0; // frames seen
  std::array<Past, kRing> ring_;
  Past moved_; // one of them, moved with the crop
  CellMap calm_;
  CellMap at_rest_energy_;   // sums of the squared differences to the earlier frame
  CellMap displaced_energy_; // the same to the displaced earlier frame
  float at_rest_sum_ = 0;    // over the crop
  float displaced_sum_ = 0;
  CellMap change_;
  CellMap displaced_change_;
  CellMap background_;
  CellMap rests_;
  CellMap follows_;
  CellMap shows_;
};

} // namespace haptic
