// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/followed-things.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace haptic {
namespace {

constexpr int kChoiceColumns = 16; // of the places that may be chosen
constexpr int kTriedForEach = 4;   // places, so that a choice in a field without things ends

struct Candidate {
  float x = 0; // px
  float y = 0;
  float speed = 0; // px/s, times the confidence
};

// Returns the middles of a coarse grid, fastest first.
std::vector<Candidate> candidates_in(const MotionField &field) {
  const auto width = static_cast<int>(field.frame_width);
  const auto height = static_cast<int>(field.frame_height);
  const FieldShape shape =
      field_shape(width, height, static_cast<double>(field.pixel_aspect_n) / field.pixel_aspect_d,
                  kChoiceColumns);
  std::vector<Candidate> places;
  for (int row = 0; row < shape.rows; ++row)
    for (int column = 0; column < shape.columns; ++column) {
      const float x = (static_cast<float>(column) + 0.5F) / static_cast<float>(shape.columns);
      const float y = (static_cast<float>(row) + 0.5F) / static_cast<float>(shape.rows);
      const FieldCell &cell = field.cells[static_cast<std::size_t>(y * field.rows) * field.columns +
                                          static_cast<std::size_t>(x * field.columns)];
      places.push_back({x * static_cast<float>(width), y * static_cast<float>(height),
                        cell.confidence * std::hypot(cell.velocity_x, cell.velocity_y)});
    }
  std::ranges::stable_sort(places, std::ranges::greater(), &Candidate::speed);
  return places;
}

} // namespace

void FollowedThings::follow(const LumaSource &frame, float seconds) {
  for (Followed &followed : followed_)
    followed.thing.follow(frame, seconds);
  end_lost();
}

void FollowedThings::rest(const LumaSource &frame, float seconds) {
  for (Followed &followed : followed_)
    followed.thing.rest(frame, seconds);
  end_lost();
}

void FollowedThings::end_lost() {
  std::erase_if(followed_, [](const Followed &followed) {
    return followed.thing.report().state == HoldState::lost;
  });
}

void FollowedThings::take(const LumaSource &frame, int width, int height, float x, float y) {
  take(frame, width, height, x, y, false);
}

// What is chosen can be told from its neighbours. What is pointed at may be followed about.
void FollowedThings::take(const LumaSource &frame, int width, int height, float x, float y,
                          bool is_chosen) {
  if (followed_.size() == kMostFieldThings)
    return;
  Followed &taken = followed_.emplace_back();
  const HoldState state =
      taken.thing
          .take(frame, width, height, x * static_cast<float>(width), y * static_cast<float>(height))
          .state;
  if (state == HoldState::held || (state == HoldState::about && !is_chosen)) {
    taken.id = next_id_++;
    taken.is_chosen = is_chosen;
  } else {
    followed_.pop_back();
  }
}

bool FollowedThings::is_near(float x, float y) const noexcept {
  return std::ranges::any_of(followed_, [&](const Followed &followed) {
    const HeldReport &report = followed.thing.report();
    return std::hypot(report.x - x, report.y - y) < report.radius;
  });
}

void FollowedThings::choose(const LumaSource &frame, const MotionField &field, std::size_t most) {
  const auto chosen = [&] {
    return static_cast<std::size_t>(std::ranges::count_if(followed_, &Followed::is_chosen));
  };
  std::size_t tries = kTriedForEach * (most - std::min(chosen(), most));
  const auto width = static_cast<float>(field.frame_width);
  const auto height = static_cast<float>(field.frame_height);
  for (const Candidate &place : candidates_in(field)) {
    if (tries == 0 || chosen() == most)
      return;
    if (is_near(place.x, place.y))
      continue;
    --tries;
    take(frame, static_cast<int>(field.frame_width), static_cast<int>(field.frame_height),
         place.x / width, place.y / height, true);
  }
}

void FollowedThings::write(int width, int height, std::vector<FieldThing> &things) const {
  things.clear();
  const auto share = [](float at, int of) {
    return std::clamp(at / static_cast<float>(of), 0.F, 1.F);
  };
  for (const Followed &followed : followed_) {
    const HeldReport &report = followed.thing.report();
    things.push_back({followed.id, report.state, share(report.x, width), share(report.y, height),
                      share(report.radius, width)});
  }
}

} // namespace haptic
