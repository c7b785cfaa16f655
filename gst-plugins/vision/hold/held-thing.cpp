// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/held-thing.hpp"

#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace haptic {
namespace {

// Lengths are reduced pixels, times seconds. Rates were found for frames of 1/30 s. All thresholds
// were chosen with the films `tests/measure/felt/hold.sh --set tuning`.
constexpr float kFramesPerSecond = 30;
constexpr int kLayerRadius = 2 * kPatchRadius; // a patch, and as much again for it to move

// Press
constexpr float kMostDeviation = 0.5F; // px, of the place that the texture allows
constexpr float kTwin = 0.97F;         // correlation of a neighbour that could be the thing
constexpr int kNeighbours = 20;        // px about the place

// Seen. Correlations are with the frame before, likenesses with what was learned.
constexpr float kStillSeen = 0.3F;     // correlation
constexpr float kBrokenChain = 0.6F;   // correlation: something else came
constexpr float kSameAsBefore = 0.95F; // correlation
constexpr float kLeastShare = 0.62F;   // of the middle, that looks as usual
constexpr float kLeastLikeness = 0.55F;
constexpr float kDrop = 0.25F;  // of the likeness, below the usual one
constexpr float kClean = 0.12F; // the same, of a frame from which it learns
constexpr float kAppearanceRate = 0.08F;
constexpr float kFitRate = 0.06F;
constexpr float kRestlessLikeness = 0.9F; // usual
constexpr float kRestlessChange = 0.06F;  // of the likeness, usual
// A thing that is where its velocity led it is not looked for in the coarse layers in each frame.
constexpr double kCoarseInterval = 0.1; // s
constexpr float kSteady = 0.5F;         // px from the expected place
constexpr float kSteadyCorrelation = 0.9F;
constexpr float kStepNoise2 = 0.03F * 0.03F; // px^2, of the place, a frame

// About
constexpr int kLearned = 5;            // frames, after which the mask is of the thing alone
constexpr float kOpenDeviation = 0.2F; // px, of the place along an edge
constexpr float kOpenRatio = 5;        // of the structure across the edge to that along it
constexpr float kStaysOpen = 0.8F;     // of both, so that it does not go to and fro
constexpr float kGoesAlong = 0.4F;     // correlation of a coarse layer

// Hidden
constexpr double kLostAfter = 3;      // s; the force ended long before
constexpr double kFades = 0.25;       // s, of the velocity
constexpr float kLeastReach = 40;     // px
constexpr float kFarthestReach = 110; // px
constexpr float kAroundFound = 64;    // px, of the patches of what is found
constexpr float kFoundShare = 0.85F;  // of the middle
constexpr float kFoundLikeness = 0.85F;
constexpr float kFoundCorrelation = 0.55F; // of the search
constexpr float kGap = 0.05F;              // of the search, to the next best place
constexpr float kSure = 0.9F;              // of share and likeness
constexpr float kAgreement = 16;           // px, of two frames

// s of full velocity that a time of fading velocity is worth.
float ahead_of(double time) {
  return static_cast<float>(kFades * (1 - std::exp(-time / kFades)));
}

Displacement between(const PatchPose &from, const PatchPose &to) {
  return {to.x - from.x, to.y - from.y};
}
float length(Displacement d) {
  return std::hypot(d.x, d.y);
}
PatchPose moved(PatchPose pose, Displacement d) {
  pose.x += d.x;
  pose.y += d.y;
  return pose;
}

// Of the texture that the weights select.
Eigenvalues structure_of(const PatchTemplate &patch, const PatchSamples &weights) {
  const auto sums = sum_normal_equations(patch, {}, weights, 1, false).matrix;
  return eigenvalues({sums[0], sums[1], sums[2]});
}

// Standard deviation of a place by this texture: of grey levels with a noise of 2, shared by four.
float deviation(const Eigenvalues &structure) {
  constexpr float kNoise2 = 16;
  return std::sqrt(kNoise2 / std::max(structure.least, 1e-3F));
}

// 1 for each sample of a patch about (x, y) that lies in the object, with so many pixels from one
// to the next; without an object for all.
PatchSamples samples_within(const std::optional<Rectangle> &object, float x, float y,
                            float spacing) {
  PatchSamples within;
  const auto lies = [](float place, int begin, int length) {
    return place >= static_cast<float>(begin) && place < static_cast<float>(begin + length);
  };
  for (int at = 0; at < kPatchSamples; ++at) {
    const int column = at % kPatchSide - kPatchRadius;
    const int row = at / kPatchSide - kPatchRadius;
    const float u = x + spacing * static_cast<float>(column);
    const float v = y + spacing * static_cast<float>(row);
    within[at] =
        !object || (lies(u, object->x, object->width) && lies(v, object->y, object->height)) ? 1.0F
                                                                                             : 0.0F;
  }
  return within;
}

// Of two frames of nearly the same time, the step is an error of the place.
Displacement velocity_of(Displacement step, float seconds) {
  constexpr float kLeastInterval = 1e-3F; // s
  return 1 / std::max(seconds, kLeastInterval) * step;
}

} // namespace

// Reading

// A layer from which a patch can be sampled, even if it moves on by some samples or has grown.
const LumaLayer &HeldThing::patch_layer(int index, const PatchPose &pose) {
  constexpr int kEnough = kPatchRadius + 3;
  return luma_.layer(index, pose.x, pose.y, kLayerRadius, kEnough);
}

void HeldThing::read(const LumaSource &frame, const PatchPose &about, float reach) {
  luma_.read(frame, frame_width_, frame_height_, halvings_, about.x, about.y,
             static_cast<int>(reach));
}

// The coarsest layer, and what the thing may move in a frame.
float HeldThing::reach_of_patches(float seconds) const {
  constexpr float kCoarsest = 4 * (kLayerRadius + 2);
  constexpr float kFarthest = 48; // px
  return kCoarsest + std::min(seconds * length(velocity_) / 2, kFarthest);
}

void HeldThing::say(HoldState state, const PatchPose &place) {
  constexpr float kAboutRadius = 4 * kPatchRadius; // the coarsest layer
  const auto scale = static_cast<float>(1 << halvings_);
  state_ = state;
  const HoldState said = state == HoldState::held && is_open_ ? HoldState::about : state;
  report_ = {.state = said,
             .x = place.x * scale,
             .y = place.y * scale,
             .radius = scale * (said == HoldState::about
                                    ? kAboutRadius
                                    : kPatchRadius * std::sqrt(std::abs(place.area())))};
}

// Press

const HeldReport &HeldThing::take(const LumaSource &frame, int frame_width, int frame_height,
                                  float x, float y, const std::optional<Rectangle> &object) {
  frame_width_ = frame_width;
  frame_height_ = frame_height;
  halvings_ = NearbyLuma::halvings(frame_width, frame_height);
  const float scale = 1 / static_cast<float>(1 << halvings_);
  pose_ = {.x = x * scale, .y = y * scale};
  velocity_ = {};
  variance_ = first_variance_ = 0;
  time_ = clean_time_ = 0;
  seen_ = 0;
  usual_correlation_ = 0.95F;
  unsteadiness_ = 0.03F;
  usual_difference_ = 3;
  path_.clear();
  hidden_since_ = 0;
  hidden_from_ = pose_;
  hidden_velocity_ = {};
  candidate_.reset();
  is_open_ = false;
  read(frame, pose_, reach_of_patches(0));
  if (!keep_patches(kHoldLayers)) {
    say(HoldState::refused, pose_);
    return report_;
  }
  for (std::size_t i = 0; i < kHoldLayers; ++i)
    appearances_[i].begin(before_[i].grey,
                          samples_within(object, x, y, static_cast<float>(1U << i) / scale));
  first_ = before_[0];
  if (deviation(structure_of(first_, appearances_[0].mask())) > kMostDeviation) {
    say(HoldState::refused, pose_);
    return report_;
  }
  is_unique_ = is_unlike_neighbours();
  say(is_unique_ ? HoldState::held : HoldState::about, pose_);
  path_.add(time_, pose_);
  return report_;
}

// Whether no place about looks the same.
bool HeldThing::is_unlike_neighbours() {
  constexpr int kReach = kNeighbours + kPatchRadius;
  const LumaLayer &layer = luma_.layer(0, pose_.x, pose_.y, kReach, kReach);
  const auto found = search_.find(layer, appearances_[0].mask(), appearances_[0].grey(), pose_.x,
                                  pose_.y, kNeighbours);
  return !found || found->next_best < kTwin;
}

// The patches of the frame at the pose, of the finest layers. False: the thing leaves the frame.
bool HeldThing::keep_patches(int layers) {
  if (layers == kHoldLayers)
    coarse_time_ = time_;
  for (int i = 0; i < layers; ++i) {
    PatchTemplate &patch = before_[static_cast<std::size_t>(i)];
    if (!patch_layer(i, pose_).sample(pose_, patch.grey))
      return false;
    differentiate(patch);
  }
  return true;
}

// Seen

// The masked difference from the frame before.
float HeldThing::difference(const LumaLayer &layer, const PatchPose &pose, int index) {
  const auto i = static_cast<std::size_t>(index);
  if (!layer.sample(pose, scratch_))
    return std::numeric_limits<float>::infinity();
  return subtract_patches(appearances_[i].mask(), scratch_, before_[i].grey, 1, 0, errors_);
}

// From the coarsest layer to the second one. A result counts if the next finer layer differs less
// there.
PatchPose HeldThing::find_coarsely(float seconds) {
  const Displacement ahead = seconds * velocity_;
  // Both the place before and the one that the velocity leads to.
  const int radius = kLayerRadius + static_cast<int>(std::min(length(ahead) / 8, 12.0F));
  const PatchPose middle = moved(pose_, 0.5F * ahead);
  const LumaLayer *layer = &luma_.layer(2, middle.x, middle.y, radius, radius);
  PatchPose place = pose_;
  if (difference(*layer, moved(place, ahead), 2) < difference(*layer, place, 2))
    place = moved(place, ahead);
  for (int i = 2; i > 0; --i) {
    const auto index = static_cast<std::size_t>(i);
    const auto found = aligner_.align(*layer, before_[index], appearances_[index].mask(), place,
                                      {.iterations = 5, .enough = 0.05F});
    layer = &patch_layer(i - 1, place);
    if (found && difference(*layer, found->pose, i - 1) < difference(*layer, place, i - 1))
      place = found->pose;
  }
  return place;
}

// The chain drifts; the first patch does not.
void HeldThing::align_to_first(Match &match, float step_variance) {
  constexpr float kLeast = 0.6F;           // correlation
  constexpr float kSettled = 0.3F;         // samples: an alignment that has ended
  constexpr float kNoise2 = 0.02F * 0.02F; // px^2
  const auto found = aligner_.align(patch_layer(0, match.pose), first_, appearances_[0].mask(),
                                    match.pose, {.iterations = 3, .similarity = 0.5F});
  if (!found || found->correlation < kLeast || found->step > kSettled)
    return;
  const float doubt = 1 + 4 * std::max(0.0F, 0.9F - found->correlation);
  const float variance = doubt * (first_variance_ + found->variance + kNoise2);
  const float gate = 1 + 3 * std::sqrt(match.variance + step_variance);
  if (variance >= match.variance || length(between(match.pose, found->pose)) > gate)
    return;
  match.pose = found->pose;
  match.variance = variance;
}

std::optional<PatchAlignment> HeldThing::align_finely(const PatchPose &start) {
  return aligner_.align(patch_layer(0, start), before_[0], appearances_[0].mask(), start,
                        {.iterations = 4});
}

// All that the patches and a search need.
void HeldThing::read_widely(const LumaSource &frame, float seconds) {
  read(frame, moved(pose_, seconds / 2 * velocity_), reach_of_patches(seconds));
}

// Where the velocity leads, if it is there. Only what the finest patch needs is read.
std::optional<PatchAlignment> HeldThing::find_where_expected(const LumaSource &frame,
                                                             float seconds) {
  if (time_ - coarse_time_ > kCoarseInterval)
    return std::nullopt;
  const PatchPose expected = moved(pose_, seconds * velocity_);
  read(frame, expected, kLayerRadius + 2);
  const auto found = align_finely(expected);
  if (!found || found->correlation < kSteadyCorrelation ||
      length(between(expected, found->pose)) > kSteady)
    return std::nullopt;
  return found;
}

std::optional<HeldThing::Match> HeldThing::match(const LumaSource &frame, float seconds) {
  std::optional<PatchAlignment> found = find_where_expected(frame, seconds);
  const bool was_expected = found.has_value();
  if (!found) {
    read_widely(frame, seconds);
    found = align_finely(find_coarsely(seconds));
  }
  if (!found || found->correlation < kStillSeen)
    return std::nullopt;
  Match match{.pose = found->pose,
              .variance = variance_ + found->variance + kStepNoise2,
              .correlation = found->correlation,
              .error_scale = found->error_scale,
              .layers = was_expected ? 1 : kHoldLayers};
  align_to_first(match, found->variance);
  if (!patch_layer(0, match.pose).sample(match.pose, match.grey))
    return std::nullopt;
  match.likeness = appearances_[0].compare(match.grey, usual_difference_);
  return match;
}

// What covers a thing comes within a few frames. Where neither the likeness nor the frame before
// says so, the light changed.
bool HeldThing::looks_hidden(const Match &match) const {
  const float likeness = match.likeness.correlation;
  if (match.likeness.share < kLeastShare && !(likeness > kSure && match.correlation > kSure))
    return true;
  if (likeness >= usual_correlation_ - kDrop)
    return false;
  return match.correlation < kBrokenChain ||
         (likeness < kLeastLikeness && match.correlation < kSameAsBefore);
}

void HeldThing::learn(const Match &match, float frames, float coarse_frames) {
  const bool is_clean = match.likeness.correlation > usual_correlation_ - kClean || seen_ < 5;
  const float fit_rate = is_clean ? std::max(kFitRate, 1 / static_cast<float>(seen_ + 3)) : 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(match.layers); ++i) {
    const float since = i == 0 ? frames : coarse_frames;
    appearances_[i].learn(before_[i].grey, match.error_scale, std::min(fit_rate * since, 1.0F),
                          std::min(kAppearanceRate * since, 1.0F));
  }
  const float rise = match.likeness.correlation - usual_correlation_;
  unsteadiness_ +=
      std::min(0.08F * frames, 1.0F) * (std::min(std::abs(rise), 0.3F) - unsteadiness_);
  usual_correlation_ += std::min((rise > 0 ? 0.1F : 0.04F) * frames, 1.0F) * rise;
  if (!is_clean)
    return;
  clean_time_ = time_;
  const float difference = std::min(match.likeness.difference, 3 * usual_difference_);
  usual_difference_ += std::min(0.1F * frames, 1.0F) * (difference - usual_difference_);
  usual_difference_ = std::clamp(usual_difference_, 2.0F, 12.0F);
}

// A blade of grass shows where it is across it. Along it, it looks the same everywhere.
void HeldThing::judge_look() {
  const Eigenvalues structure = structure_of(appearances_[0].patch(), appearances_[0].mask());
  const float least = is_open_ ? kStaysOpen : 1;
  is_open_ = deviation(structure) > least * kOpenDeviation &&
             structure.most > least * kOpenRatio * structure.least;
}

void HeldThing::accept(const Match &match, float seconds) {
  const Displacement step = between(pose_, match.pose);
  const float variance = std::max(match.variance - variance_, kStepNoise2);
  velocity_ = velocity_of(step, seconds);
  pose_ = match.pose;
  variance_ = match.variance;
  const auto coarse_seconds = static_cast<float>(time_ - coarse_time_);
  if (!keep_patches(match.layers)) {
    hide();
    return;
  }
  learn(match, seconds * kFramesPerSecond, coarse_seconds * kFramesPerSecond);
  ++seen_;
  if (match.layers == kHoldLayers && seen_ > kLearned)
    judge_look();
  path_.add(time_, pose_);
  say(state_, pose_);
  const auto scale = static_cast<float>(1 << halvings_);
  report_.dx = scale * step.x;
  report_.dy = scale * step.y;
  report_.variance = scale * scale * variance;
}

void HeldThing::follow_seen(const LumaSource &frame, float seconds) {
  const std::optional<Match> found = match(frame, seconds);
  if (!found || looks_hidden(*found)) {
    read_widely(frame, seconds);
    hide();
    if (state_ == HoldState::about)
      follow_about(seconds);
    else
      look_for(seconds);
    return;
  }
  accept(*found, seconds);
}

// The place goes with what surrounds it, and the thing is looked for there.
void HeldThing::follow_about(float seconds) {
  PatchPose place = pose_;
  for (int i = 2; i > 0; --i) {
    const auto index = static_cast<std::size_t>(i);
    const LumaLayer &layer = patch_layer(i, place);
    const auto found = aligner_.align(layer, before_[index], Appearance::nearness(), place,
                                      {.iterations = 5, .enough = 0.03F});
    if (found && found->correlation > kGoesAlong)
      place = found->pose;
  }
  const Displacement step = between(pose_, place);
  velocity_ = velocity_of(step, seconds);
  pose_ = place;
  if (!keep_patches(kHoldLayers)) {
    say(HoldState::lost, pose_);
    return;
  }
  if (is_unique_ && goes_astray())
    return hide_at(middle_of_swing(), {}, HoldState::hidden);
  say(HoldState::about, pose_);
  const auto scale = static_cast<float>(1 << halvings_);
  report_.dx = scale * step.x;
  report_.dy = scale * step.y;
  if (is_unique_)
    look_for(seconds);
}

// A thing whose look changes all the time, as a leaf among leaves, hides by looking like another.
bool HeldThing::is_restless() const {
  return usual_correlation_ < kRestlessLikeness || unsteadiness_ > kRestlessChange;
}

// Hidden

// The frames before it was hidden may already follow what covers it.
void HeldThing::hide() {
  constexpr double kEarlier = 0.17; // s: what hides it was near
  constexpr double kOver = 0.1;     // s, for a velocity
  constexpr float kFollowed = 12;   // px: the latest pose is as expected
  const RecentPath::Place clean = path_.before(clean_time_ - kEarlier);
  const RecentPath::Place earlier = path_.before(clean.time - kOver);
  Displacement velocity;
  if (clean.time > earlier.time)
    velocity =
        static_cast<float>(1 / (clean.time - earlier.time)) * between(earlier.pose, clean.pose);
  const RecentPath::Place late = path_.before(time_ - kOver);
  const auto expected = [&](double time) {
    return moved(clean.pose, ahead_of(time - clean.time) * velocity);
  };
  const bool as_expected =
      late.time > clean.time && length(between(expected(late.time), late.pose)) < kFollowed;
  hide_at(as_expected ? late.pose : expected(time_), velocity,
          is_restless() ? HoldState::about : HoldState::hidden);
}

void HeldThing::hide_at(const PatchPose &pose, Displacement velocity, HoldState state) {
  hidden_from_ = pose;
  hidden_velocity_ = velocity;
  hidden_since_ = time_;
  looks_back_ = false;
  candidate_.reset();
  say(state, pose);
}

PatchPose HeldThing::expected_pose() const {
  return moved(hidden_from_, ahead_of(time_ - hidden_since_) * hidden_velocity_);
}

RecentPath::Swing HeldThing::recent_swing() const {
  constexpr double kRecent = 2; // s
  return path_.swing(hidden_since_ - kRecent);
}

// Where its velocity leads, and in every second frame in the middle of its swing: it may have
// turned back while it was hidden.
PatchPose HeldThing::guessed_pose() const {
  return candidate_ ? *candidate_ : looks_back_ ? middle_of_swing() : expected_pose();
}

PatchPose HeldThing::middle_of_swing() const {
  const RecentPath::Swing swing = recent_swing();
  PatchPose pose = hidden_from_;
  pose.x = swing.x;
  pose.y = swing.y;
  return pose;
}

// Whether it went with what covers it: farther from its swing than a search reaches.
bool HeldThing::goes_astray() const {
  return length(between(middle_of_swing(), pose_)) > reach_of_search();
}

// It may swing further than ever, and be faster than it was.
float HeldThing::reach_of_search() const {
  const auto hidden = static_cast<float>(time_ - hidden_since_);
  const float swing = 1.6F * recent_swing().size;
  const float speed = 3 * kFramesPerSecond + 0.7F * length(hidden_velocity_);
  return std::min({std::max(kLeastReach, swing), 12 + speed * hidden, kFarthestReach});
}

// The thing near a place, as it looks or as it looked first.
std::optional<HeldThing::Match> HeldThing::recognise(const PatchPose &near, float farthest) {
  constexpr float kSettled = 0.5F; // samples
  constexpr float kLeast = 0.5F;   // of both
  const float least_likeness = std::clamp(usual_correlation_ - 0.2F, kLeast, kFoundLikeness);
  const LumaLayer &layer = luma_.layer(0, near.x, near.y, 3 * kPatchRadius, kLayerRadius);
  const std::array<const PatchTemplate *, 2> looks{&appearances_[0].patch(), &first_};
  for (const PatchTemplate *look : looks) {
    const auto found = aligner_.align(layer, *look, appearances_[0].mask(), near,
                                      {.iterations = 12, .enough = 0.01F, .similarity = 0.15F});
    if (!found || found->step > kSettled || found->correlation < kLeast ||
        length(between(near, found->pose)) > farthest)
      continue;
    Match match{.pose = found->pose,
                .variance = (look == &first_ ? first_variance_ : variance_) + found->variance,
                .correlation = found->correlation,
                .error_scale = found->error_scale};
    if (!layer.sample(match.pose, match.grey))
      continue;
    match.likeness = appearances_[0].compare(match.grey, usual_difference_);
    if (match.likeness.share > kFoundShare && match.likeness.correlation > least_likeness)
      return match;
  }
  return std::nullopt;
}

// Where it is expected, or else where a search finds it: then the next best place must be clearly
// worse.
std::optional<HeldThing::Match> HeldThing::find(const PatchPose &guess, float reach) {
  constexpr float kNear = 6;      // px, that an alignment overcomes
  constexpr float kMostFine = 44; // px: a search of the second layer is affordable
  if (std::optional<Match> match = recognise(guess, kNear))
    return match;
  const int index = reach > kMostFine ? 2 : 1;
  const auto unit = static_cast<float>(1 << index);
  const int radius = static_cast<int>(std::ceil(reach / unit));
  const int wide = radius + kPatchRadius;
  const Appearance &appearance = appearances_[static_cast<std::size_t>(index)];
  const auto found = search_.find(luma_.layer(index, guess.x, guess.y, wide, wide),
                                  appearance.mask(), appearance.grey(), guess.x, guess.y, radius);
  if (!found || found->correlation < kFoundCorrelation)
    return std::nullopt;
  const float gap = found->correlation - found->next_best;
  if (gap < kGap)
    return std::nullopt;
  std::optional<Match> match =
      recognise(moved(guess, {found->x - guess.x, found->y - guess.y}), 2 * unit + 2);
  if (match && gap < 2 * kGap && match->likeness.correlation < kSure)
    return std::nullopt;
  return match;
}

void HeldThing::look_for(float seconds) {
  const bool is_about = state_ == HoldState::about;
  if (!is_about && time_ - hidden_since_ > kLostAfter) {
    say(HoldState::lost, hidden_from_);
    return;
  }
  const PatchPose guess = is_about && !candidate_ ? pose_ : guessed_pose();
  if (!is_about)
    say(HoldState::hidden, candidate_ ? guess : expected_pose());
  const std::optional<Match> found = find(guess, candidate_ ? kAgreement : reach_of_search());
  if (!found) {
    candidate_.reset();
    return;
  }
  const std::optional<PatchPose> before = std::exchange(candidate_, found->pose);
  const bool is_sure = found->likeness.correlation > kSure && found->likeness.share > kSure;
  if (before || is_sure)
    hold_again(*found,
               before ? velocity_of(between(*before, found->pose), seconds) : Displacement{});
}

void HeldThing::hold_again(const Match &match, Displacement velocity) {
  pose_ = match.pose;
  velocity_ = velocity;
  variance_ = match.variance;
  if (!keep_patches(kHoldLayers))
    return; // at the border of what was read: the next frame is read about it
  candidate_.reset();
  clean_time_ = time_;
  path_.add(time_, pose_);
  say(HoldState::held, pose_);
}

// A frame

const HeldReport &HeldThing::follow(const LumaSource &frame, float seconds) {
  time_ += seconds;
  switch (state_) {
  case HoldState::held:
    follow_seen(frame, seconds);
    break;
  case HoldState::about:
    read(frame, pose_,
         is_unique_ ? std::max(reach_of_patches(seconds), reach_of_search() + kAroundFound)
                    : reach_of_patches(seconds));
    follow_about(seconds);
    break;
  case HoldState::hidden:
    looks_back_ = !looks_back_;
    read(frame, guessed_pose(), reach_of_search() + kAroundFound);
    look_for(seconds);
    break;
  case HoldState::none:
  case HoldState::lost:
  case HoldState::refused:
    break;
  }
  return report_;
}

const HeldReport &HeldThing::rest(const LumaSource &frame, float seconds) {
  if (state_ == HoldState::hidden)
    return follow(frame, seconds);
  time_ += seconds;
  coarse_time_ += seconds; // the same pixels teach nothing
  velocity_ = {};
  report_.dx = report_.dy = 0;
  if (state_ == HoldState::about && is_unique_) {
    read(frame, pose_, reach_of_search() + kAroundFound);
    look_for(seconds);
  }
  return report_;
}

void HeldThing::lose() {
  if (state_ != HoldState::none && state_ != HoldState::refused)
    state_ = report_.state = HoldState::lost;
}

} // namespace haptic
