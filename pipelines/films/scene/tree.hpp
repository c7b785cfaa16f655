// SPDX-License-Identifier: LGPL-2.1-or-later
// A tree whose trunk, limbs, branches, twigs and leaves each sway about the one that carries them.
#pragma once

#include "scene/drawing.hpp"
#include "scene/wind.hpp"

#include <vector>

namespace film {

/// The point where the stem holds the leaf, as shares of width and height; the tip is on the right.
inline constexpr Point kLeafBase{0.06F, 0.5F};

/// Leaves with veins, in every light from deep shadow to the sun shining through them.
class LeafTextures {
public:
  /// `length` of a leaf in px.
  explicit LeafTextures(float length);

  /// `light` 0..1; `kind` 0 … kKinds − 1.
  const Texture &leaf(int kind, float light) const;
  /// A dark mass of leaves seen deep in the crown, as wide as ten leaves.
  const Texture &mass(int kind) const { return masses_[static_cast<std::size_t>(kind)]; }

  static constexpr int kKinds = 5;

private:
  static constexpr int kLights = 28;

  std::vector<Texture> leaves_;
  std::vector<Texture> masses_;
};

/// Sizes are in px of a frame 960 px wide and 540 px high; `to_frame` maps them to those drawn.
class Tree {
public:
  Tree(const Affine &to_frame, std::uint64_t seed);

  void draw(Canvas &canvas, const Winds &winds) const;

  static constexpr Point kFoot{392, 474};
  static constexpr Point kCrown{396, 201}; ///< its middle
  static constexpr Point kReach{254, 162}; ///< half width, half height

private:
  /// What turns about a joint.
  struct Node {
    int parent;
    Point joint; // at rest
    Sway sway;
  };
  struct Leaf {
    int node;
    Point at; // of its stem, at rest
    float depth;
    float angle;
    float size;
    float light;
    int kind;
    Sway turn;
    Sway roll;
    float rest_roll;
  };
  /// A branch is a band of triangles with the texture of bark.
  struct Triangle {
    int node;
    Affine to_rest;
    Point corners[3]; // texels
    int gain;
  };
  struct Clump {
    int node;
    Point centre;
    float depth; // −1 (back) … 1
    float radius;
    int kind;
    int first_leaf;
    int last_leaf;
    int first_triangle;
    int last_triangle;
  };
  struct Limb {
    int node;
    Point from;
    Point to;
  };

  int add_node(int parent, const Point &joint, const Sway &sway);
  void add_branch(int node, const Point &from, const Point &to, float from_radius, float to_radius,
                  int gain);
  void grow_trunk();
  void grow_limbs();
  std::vector<Clump> place_clumps();
  void grow_clump(Clump &clump);
  void grow_leaf(const Clump &clump, int twig, const Point &tip, float facing);
  std::vector<Pose> poses(const Winds &winds) const;
  void draw_leaf(Canvas &canvas, const Leaf &leaf, const Pose &pose, const Winds &winds) const;
  void draw_triangles(Canvas &canvas, const std::vector<Pose> &poses, int first, int last) const;

  Affine to_frame_;
  Random random_;
  LeafTextures textures_;
  Texture bark_;
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::vector<Triangle> triangles_;
  int wood_ = 0; // triangles of trunk and limbs
  std::vector<Limb> limbs_;
  std::vector<Clump> clumps_; // from the front to the back
};

} // namespace film
