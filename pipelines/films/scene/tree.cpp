// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scene/tree.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace film {

namespace {

constexpr float kLeafLength = 12; // px
constexpr int kClumps = 84;
constexpr int kTwigs = 8;        // of a clump
constexpr int kFrontLeaves = 16; // of a twig
constexpr int kBackLeaves = 8;
constexpr float kWoodDepth = -0.15F; // clumps behind it are behind trunk and limbs
constexpr int kBarkWidth = 24;
constexpr int kBarkHeight = 128;

Point between(const Point &a, const Point &b, float share) {
  return a + (b - a) * share;
}

Affine scaled(float x, float y, const Point &to) {
  return {x, 0, 0, y, to.x, to.y};
}

// Lit from the left; transparent on both sides, so that its edges are smooth.
Texture make_bark() {
  Texture bark{kBarkWidth, kBarkHeight, {}};
  for (int y = 0; y < kBarkHeight; ++y)
    for (int x = 0; x < kBarkWidth; ++x) {
      const float across = (static_cast<float>(x) - 1.5F) / (kBarkWidth - 4);
      const float round = std::sqrt(std::max(0.0F, 1 - (2 * across - 1) * (2 * across - 1)));
      const float lit = 0.35F + 0.75F * std::max(0.0F, round * 0.6F - (2 * across - 1) * 0.6F);
      const float ridge =
          rough_noise(static_cast<float>(x) * 0.45F, static_cast<float>(y) * 0.11F, 3, 5);
      const Colour colour =
          mix({0.16F, 0.13F, 0.105F}, {0.55F, 0.48F, 0.40F}, smooth_step(0.2F, 0.8F, ridge)) * lit;
      const bool inside = x > 0 && x < kBarkWidth - 2;
      bark.pixels.push_back(inside ? unpack(opaque(colour)) : 0);
    }
  return bark;
}

} // namespace

Tree::Tree(const Affine &to_frame, std::uint64_t seed)
    : to_frame_(to_frame), random_(seed ^ 0x74726565), textures_(kLeafLength * to_frame.xx),
      bark_(make_bark()) {
  grow_trunk();
  clumps_ = place_clumps();
  grow_limbs();
  wood_ = static_cast<int>(triangles_.size());
  for (Clump &clump : clumps_)
    grow_clump(clump);
}

int Tree::add_node(int parent, const Point &joint, const Sway &sway) {
  nodes_.push_back({parent, joint, sway});
  return static_cast<int>(nodes_.size()) - 1;
}

// A curve from `from` to `to` that begins upwards.
void Tree::add_branch(int node, const Point &from, const Point &to, float from_radius,
                      float to_radius, int gain) {
  const Point middle = between(from, to, 0.5F) + Point{0, -0.12F * length(to - from)};
  const int parts = std::max(2, static_cast<int>(length(to - from) / 14));
  const auto at = [&](float s) {
    return between(between(from, middle, s), between(middle, to, s), s);
  };
  const auto across = [&](float s) {
    const Point along = at(s + 0.01F) - at(s - 0.01F);
    const float radius = mix(from_radius, to_radius, s) * 1.2F / length(along);
    return Point{-along.y * radius, along.x * radius};
  };
  constexpr float kRight = kBarkWidth - 1.1F;
  for (int i = 0; i < parts; ++i) {
    const float s0 = static_cast<float>(i) / static_cast<float>(parts);
    const float s1 = static_cast<float>(i + 1) / static_cast<float>(parts);
    const float low = 1 + static_cast<float>(i % 8) * 15;
    const float high = low + 15;
    // Across a branch that goes up is to the right.
    const Point a = at(s0) - across(s0);
    const Point b = at(s0) + across(s0);
    const Point c = at(s1) - across(s1);
    const Point d = at(s1) + across(s1);
    const auto map = [&](const Point &origin, const Point &right, const Point &down, float u,
                         float v) {
      const Affine shape{right.x / kRight, down.x / 15, right.y / kRight, down.y / 15, 0, 0};
      const Point moved = origin - shape({u, v});
      return Affine{shape.xx, shape.xy, shape.yx, shape.yy, moved.x, moved.y};
    };
    triangles_.push_back(
        {node, map(a, b - a, c - a, 0, low), {{0, low}, {kRight, low}, {0, high}}, gain});
    triangles_.push_back({node,
                          map(d, d - c, d - b, kRight, high),
                          {{kRight, low}, {kRight, high}, {0, high}},
                          gain});
  }
}

void Tree::grow_trunk() {
  const int foot = add_node(-1, kFoot, {0.012F, 0.010F, 0.33F, 0, kFoot.x});
  const Point waist{kFoot.x + 3, 400};
  const int upper = add_node(foot, waist, {0.022F, 0.030F, 0.41F, 1, kFoot.x});
  add_branch(foot, kFoot + Point{0, 12}, waist + Point{0, -4}, 19, 13, 225);
  add_branch(upper, waist, {kCrown.x + 4, 296}, 13, 8, 225);
}

// Clumps fill the crown evenly: of several random places each takes the one farthest from the
// others.
std::vector<Tree::Clump> Tree::place_clumps() {
  std::vector<Clump> clumps;
  const auto candidate = [&] {
    for (;;) {
      const float x = random_.between(-1, 1);
      const float y = random_.between(-1, 0.80F);
      const float z = random_.between(-1, 1);
      const float bulge = 1 + 0.16F * std::sin(5 * std::atan2(y, x) + 1);
      if (x * x + y * y + 0.5F * z * z < 0.86F * bulge)
        return Clump{0,
                     kCrown + Point{x * kReach.x, y * kReach.y + 0.10F * x * x * kReach.y},
                     z,
                     random_.between(28, 50),
                     random_.below(LeafTextures::kKinds),
                     0,
                     0,
                     0,
                     0};
    }
  };
  for (int i = 0; i < kClumps; ++i) {
    Clump best = candidate();
    float farthest = 0;
    for (int tries = 0; tries < 12; ++tries) {
      const Clump next = candidate();
      float nearest = 1e9F;
      for (const Clump &other : clumps)
        nearest = std::min(nearest, std::hypot(next.centre.x - other.centre.x,
                                               1.2F * (next.centre.y - other.centre.y),
                                               110 * (next.depth - other.depth)));
      if (nearest > farthest) {
        farthest = nearest;
        best = next;
      }
    }
    clumps.push_back(best);
  }
  std::ranges::sort(clumps, std::greater{}, &Clump::depth);
  return clumps;
}

void Tree::grow_limbs() {
  constexpr int kLimbs = 10;
  constexpr int kUpper = 1; // the node of the upper trunk
  for (int i = 0; i < kLimbs; ++i) {
    const float angle = mix(-3.05F, -0.09F, (static_cast<float>(i) + 0.5F) / kLimbs);
    const Point from{kCrown.x + 3 + random_.between(-3, 3),
                     mix(316, 378, std::abs(std::cos(angle))) + random_.between(-10, 10)};
    const Point to =
        kCrown + Point{std::cos(angle) * kReach.x * 0.68F, 60 + std::sin(angle) * kReach.y * 0.9F};
    const Sway sway{0.040F * -std::sin(angle), 0.105F, random_.between(0.5F, 0.8F),
                    random_.between(0, 6.28F), to.x};
    const int node = add_node(kUpper, from, sway);
    limbs_.push_back({node, from, to});
    add_branch(node, from, to, 7, 2, 170);
  }
}

void Tree::grow_clump(Clump &clump) {
  const auto distance = [&](const Limb &limb) {
    return length(between(limb.from, limb.to, 0.8F) - clump.centre);
  };
  const Limb &limb = *std::ranges::min_element(limbs_, {}, distance);
  const float along = std::clamp(
      1.1F - length(limb.to - clump.centre) / (1.4F * length(limb.to - limb.from)), 0.35F, 0.97F);
  const Point middle =
      between(limb.from, limb.to, 0.5F) + Point{0, -0.12F * length(limb.to - limb.from)};
  const Point joint =
      between(between(limb.from, middle, along), between(middle, limb.to, along), along);
  const Point out = clump.centre - joint;
  const float reach = std::max(length(out), 20.0F);
  // Neighbours swing nearly together: the waves of a gust cross the crown.
  const float phase =
      random_.between(-0.5F, 0.5F) - 0.012F * clump.centre.x + 0.006F * clump.centre.y;
  clump.node = add_node(limb.node, joint,
                        {0.06F * -out.y / reach, 15.0F / reach, random_.between(0.94F, 1.04F),
                         phase, clump.centre.x});
  clump.first_triangle = static_cast<int>(triangles_.size());
  const int gain = clump.depth < 0 ? 110 : 150;
  add_branch(clump.node, joint, clump.centre, 2.6F, 1.2F, gain);
  clump.first_leaf = static_cast<int>(leaves_.size());
  for (int i = 0; i < kTwigs; ++i) {
    const float angle = 6.2832F * (static_cast<float>(i) + random_.between(0, 1)) / kTwigs;
    const float away = random_.between(0.25F, 0.95F);
    const Point direction{std::cos(angle), std::sin(angle)};
    const Point tip =
        clump.centre + Point{direction.x * clump.radius, direction.y * clump.radius * 0.8F} * away;
    const Point base = between(joint, clump.centre, 0.75F);
    const int twig = add_node(clump.node, base,
                              {0.07F * -direction.y, 0.13F, random_.between(1.3F, 2.3F),
                               random_.between(0, 6.28F), tip.x});
    add_branch(twig, base, tip, 1.3F, 0.7F, gain);
    for (int j = 0; j < (clump.depth < -0.1F ? kBackLeaves : kFrontLeaves); ++j)
      grow_leaf(clump, twig, tip, random_.between(0, 1));
  }
  clump.last_leaf = static_cast<int>(leaves_.size());
  clump.last_triangle = static_cast<int>(triangles_.size());
  std::sort(leaves_.begin() + clump.first_leaf, leaves_.end(),
            [](const Leaf &a, const Leaf &b) { return a.depth > b.depth; });
}

// A clump is lit as a ball, the crown as a larger one; what is deep in either is dark.
void Tree::grow_leaf(const Clump &clump, int twig, const Point &tip, float facing) {
  const auto spread = [&] {
    return 0.36F * clump.radius * std::clamp(random_.normal(), -1.8F, 1.8F);
  };
  const float across = spread();
  const Point at = tip + Point{across, 0.75F * spread()};
  const Point of_clump = (at - clump.centre) * (1 / clump.radius);
  const Point of_crown{(at.x - kCrown.x) / kReach.x, (at.y - kCrown.y) / kReach.y};
  const float near = std::clamp(1 - length(of_clump) * 0.7F, 0.0F, 1.0F) * facing;
  const float ball = of_clump.x * kSunX + of_clump.y * kSunY + near * kSunZ;
  const float crown = of_crown.x * kSunX + of_crown.y * kSunY + 0.5F * clump.depth * kSunZ;
  const float light = 0.22F + 0.38F * ball + 0.19F * crown + 0.16F * (facing - 0.5F) +
                      0.08F * clump.depth + 0.045F * random_.normal();
  // Out and down, as a leaf hangs.
  const float angle = std::atan2(of_clump.y + 0.75F, of_clump.x) + 0.55F * random_.normal();
  const float frequency = random_.between(1.6F, 3.6F);
  const float phase = random_.between(0, 6.28F);
  leaves_.push_back({twig,
                     at,
                     near + 0.4F * facing,
                     angle,
                     random_.between(0.72F, 1.15F) * (1 + 0.1F * clump.depth),
                     light,
                     random_.below(10) < 6 ? clump.kind : random_.below(LeafTextures::kKinds),
                     {-0.35F * std::sin(angle), 0.17F, frequency, phase, at.x},
                     {0.5F, 0.42F, frequency * 1.27F, phase + 2, at.x},
                     random_.between(-0.7F, 0.7F)});
}

std::vector<Pose> Tree::poses(const Winds &winds) const {
  std::vector<Pose> all(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node &node = nodes_[i];
    const Pose own{Affine::rotation(node.joint, node.sway(winds.now)),
                   Affine::rotation(node.joint, node.sway(winds.before))};
    all[i] = (node.parent < 0 ? Pose{to_frame_, to_frame_}
                              : all[static_cast<std::size_t>(node.parent)]) *
             own;
  }
  return all;
}

// A leaf turns about its stem and rolls about its midrib: then it looks narrower and takes the
// light of another angle.
void Tree::draw_leaf(Canvas &canvas, const Leaf &leaf, const Pose &pose, const Winds &winds) const {
  constexpr float kMostRoll = 1.25F; // rad
  const auto roll_in = [&](const Wind &wind) {
    return std::clamp(leaf.rest_roll + leaf.roll(wind), -kMostRoll, kMostRoll);
  };
  const float roll = roll_in(winds.now);
  const float tilt = std::sin(roll - 0.35F);
  const float glint = smooth_step(0.25F, 0.95F, -tilt) * smooth_step(0.25F, 0.6F, leaf.light);
  const Texture &texture =
      textures_.leaf(leaf.kind, leaf.light * (1 - 0.28F * tilt) + 0.22F * glint);
  const Point base{kLeafBase.x * static_cast<float>(texture.width),
                   kLeafBase.y * static_cast<float>(texture.height)};
  const float size = leaf.size / to_frame_.xx;
  const auto own = [&](const Wind &wind, float rolled) {
    const float angle = leaf.angle + leaf.turn(wind);
    const float c = std::cos(angle) * size;
    const float s = std::sin(angle) * size;
    const float narrow = std::cos(rolled);
    return Affine{c,
                  -s * narrow,
                  s,
                  c * narrow,
                  leaf.at.x - c * base.x + s * narrow * base.y,
                  leaf.at.y - s * base.x - c * narrow * base.y};
  };
  canvas.draw(texture, pose * Pose{own(winds.now, roll), own(winds.before, roll_in(winds.before))},
              {Kind::crown_leaf, static_cast<std::uint32_t>(&leaf - leaves_.data()), 0});
}

void Tree::draw_triangles(Canvas &canvas, const std::vector<Pose> &poses, int first,
                          int last) const {
  for (int i = first; i < last; ++i) {
    const Triangle &t = triangles_[static_cast<std::size_t>(i)];
    canvas.draw_triangle(
        bark_, poses[static_cast<std::size_t>(t.node)] * Pose{t.to_rest, t.to_rest}, t.corners[0],
        t.corners[1], t.corners[2], t.gain,
        {Kind::branch, static_cast<std::uint32_t>(t.node), static_cast<std::uint32_t>(i)});
  }
}

void Tree::draw(Canvas &canvas, const Winds &winds) const {
  const std::vector<Pose> all = poses(winds);
  bool wood_is_drawn = false;
  for (const Clump &clump : clumps_) {
    if (clump.depth < kWoodDepth && !wood_is_drawn) {
      draw_triangles(canvas, all, 0, wood_);
      wood_is_drawn = true;
    }
    for (int i = clump.first_leaf; i < clump.last_leaf; ++i) {
      const Leaf &leaf = leaves_[static_cast<std::size_t>(i)];
      draw_leaf(canvas, leaf, all[static_cast<std::size_t>(leaf.node)], winds);
    }
    draw_triangles(canvas, all, clump.first_triangle, clump.last_triangle);
    const Texture &mass = textures_.mass(clump.kind);
    const float size = 2.0F * clump.radius / static_cast<float>(mass.width);
    const Affine own =
        scaled(size, size * 0.85F, clump.centre - Point{clump.radius, clump.radius * 0.85F - 4});
    const Pose &pose = all[static_cast<std::size_t>(clump.node)];
    canvas.draw(mass, pose * Pose{own, own});
  }
}

} // namespace film
