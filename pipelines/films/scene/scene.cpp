// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/scene.hpp"

#include <cmath>

namespace film {

namespace {

// The whole height is used; a wider frame shows more of the sky and the meadow.
Affine centred(int width, int height) {
  const float scale = static_cast<float>(height) / 540;
  return {scale, 0, 0, scale, (static_cast<float>(width) - 960 * scale) / 2, 0};
}

} // namespace

Scene::Scene(int width, int height, std::uint64_t seed)
    : to_frame_(centred(width, height)), seed_(seed), sky_(width, height, to_frame_.xx, seed),
      meadow_(width, to_frame_, seed), tree_(to_frame_, seed), flag_(to_frame_) {}

void Scene::draw(Canvas &canvas, double time, double interval) const {
  const Winds winds{Wind(seed_, time), Wind(seed_, time - interval)};
  canvas.clear();
  meadow_.draw(canvas, winds, false);
  tree_.draw(canvas, winds);
  flag_.draw(canvas, winds);
  meadow_.draw(canvas, winds, true);
  sky_.draw(canvas, time, interval);
}

bool Scene::is_crown(float x, float y) const {
  const Point place = to_frame_.inverse()({x, y});
  return std::hypot((place.x - Tree::kCrown.x) / Tree::kReach.x,
                    (place.y - Tree::kCrown.y) / Tree::kReach.y) < 0.85F;
}

} // namespace film
