// SPDX-License-Identifier: LGPL-2.1-or-later
// Follows the thing under a press from frame to frame, and says whether it is seen.
#pragma once

#include "hold/appearance.hpp"
#include "hold/nearby-luma.hpp"
#include "hold/patch-alignment.hpp"
#include "hold/patch-search.hpp"
#include "hold/recent-path.hpp"
#include "pixels/kept-luma.hpp"
#include "samples/held-place.hpp"

#include <array>
#include <optional>

namespace haptic {

/// px of the frame, origin at its top left corner; pixel i covers i..i+1.
struct HeldReport {
  HoldState state = HoldState::none;
  float x = 0; ///< hidden: a guess; lost: where it was last
  float y = 0;
  float radius = 0;   ///< what is followed lies within it
  float dx = 0;       ///< since the frame before; 0 unless the thing was seen in both
  float dy = 0;       ///< down
  float variance = 0; ///< px^2, of dx and of dy
};

/// One instance serves one stream, from one thread at a time. About 60 kB.
class HeldThing {
public:
  /// Takes what is under a place. The report says held, about or refused. What lies outside of
  /// `object` (px of the frame) is not of the thing until it has moved with it for some frames.
  const HeldReport &take(const LumaSource &frame, int frame_width, int frame_height, float x,
                         float y, const std::optional<Rectangle> &object = std::nullopt);

  /// The next frame, of the same size, so many seconds later (> 0).
  const HeldReport &follow(const LumaSource &frame, float seconds);

  /// The next frame, in which the region that is measured has the same pixels. It is that of the
  /// thing, unless the thing is hidden.
  const HeldReport &rest(const LumaSource &frame, float seconds);

  /// Another scene began: it cannot be found.
  void lose();

  void release() {
    state_ = HoldState::none;
    report_ = {};
  }

  const HeldReport &report() const { return report_; }

private:
  using Patches = std::array<PatchTemplate, kHoldLayers>;
  /// What became of the patch in a frame.
  struct Match {
    PatchPose pose;
    float variance = 0;    // px^2, since the press
    float correlation = 0; // with the frame before
    float error_scale = 0;
    PatchSamples grey;
    Likeness likeness;
    int layers = kHoldLayers; // in which it was looked for
  };

  void read(const LumaSource &frame, const PatchPose &about, float reach);
  void read_widely(const LumaSource &frame, float seconds);
  float reach_of_patches(float seconds) const;
  const LumaLayer &patch_layer(int index, const PatchPose &pose);
  float difference(const LumaLayer &layer, const PatchPose &pose, int index);
  PatchPose find_coarsely(float seconds);
  std::optional<PatchAlignment> align_finely(const PatchPose &start);
  std::optional<PatchAlignment> find_where_expected(const LumaSource &frame, float seconds);
  std::optional<Match> match(const LumaSource &frame, float seconds);
  void align_to_first(Match &match, float step_variance);
  bool looks_hidden(const Match &match) const;
  bool is_unlike_neighbours();
  void follow_seen(const LumaSource &frame, float seconds);
  void follow_about(float seconds);
  bool is_restless() const;
  void judge_look();
  void accept(const Match &match, float seconds);
  bool keep_patches(int layers);
  void learn(const Match &match, float frames, float coarse_frames);
  void hide();
  void hide_at(const PatchPose &pose, Displacement velocity, HoldState state);
  void look_for(float seconds);
  std::optional<Match> recognise(const PatchPose &near, float farthest);
  std::optional<Match> find(const PatchPose &guess, float reach);
  void hold_again(const Match &match, Displacement velocity);
  PatchPose expected_pose() const;
  PatchPose guessed_pose() const;
  PatchPose middle_of_swing() const;
  bool goes_astray() const;
  RecentPath::Swing recent_swing() const;
  float reach_of_search() const;
  void say(HoldState state, const PatchPose &place);

  HeldReport report_;
  HoldState state_ = HoldState::none;
  bool is_open_ = false; // held, but its look leaves open where along an edge: `about` is said
  int frame_width_ = 0;
  int frame_height_ = 0;
  int halvings_ = 0;
  NearbyLuma luma_;
  PatchAligner aligner_;
  PatchSearch search_;
  PatchSamples scratch_;
  PatchSamples errors_;

  // Lengths in reduced pixels.
  PatchPose pose_;
  Displacement velocity_; // px/s
  float variance_ = 0;    // of the place since the press
  Patches before_;        // in the frame before
  PatchTemplate first_;   // of the finest layer
  float first_variance_ = 0;
  std::array<Appearance, kHoldLayers> appearances_;
  double time_ = 0;             // s since the press
  double coarse_time_ = 0;      // when it was looked for in all layers
  double clean_time_ = 0;       // when it last looked as usual
  int seen_ = 0;                // frames in which it was seen
  float usual_correlation_ = 0; // with the appearance
  float usual_difference_ = 0;  // grey levels
  float unsteadiness_ = 0;      // of the likeness
  bool is_unique_ = false;      // no neighbour looked the same at the press
  RecentPath path_;             // while it is seen

  // While it is hidden.
  double hidden_since_ = 0;
  bool looks_back_ = false;
  PatchPose hidden_from_;
  Displacement hidden_velocity_;
  std::optional<PatchPose> candidate_; // must be confirmed by the next frame
};

} // namespace haptic
