// SPDX-License-Identifier: LGPL-2.1-or-later
// The true motion at chosen places of a film, as tracks of text lines (docs/formats/text-line.md),
// and the true way of chosen points of its things, as a table (docs/formats/film-points.md).
#pragma once

#include "scene/scene.hpp"

#include <string>
#include <vector>

namespace film {

/// What the hand at a place should feel.
enum class TruthOf {
  square,  ///< the mean over roitracker's default region
  pointed, ///< the mean over the pixels of this region that move with the one at the place
};

class Truth {
public:
  /// `places`: "X,Y X,Y …", each 0..1 of the frame from the top left. Throws FilmError.
  Truth(const std::string &places, TruthOf of, int width, int height, int rate);

  /// The motion at each place, px/s. Threads may call it at the same time.
  std::vector<Point> measure(const Canvas &canvas) const;

  /// Adds what was measured of the next frame.
  void add(const std::vector<Point> &motions);

  /// Writes FOLDER/X-Y.txt for each place. Makes the folder. Throws FilmError.
  void write(const std::string &folder) const;

private:
  struct Place {
    std::string name;
    double x, y;
    int left, top, right, bottom; // px, the region
    std::string lines;
  };

  std::vector<Place> places_;
  TruthOf of_;
  int width_;
  int height_;
  int rate_;
  long count_ = 0;
};

/// Points of leaves, branches, grass, blades and the flag, chosen among those that a person sees in
/// the first frame.
class MaterialPoints {
public:
  struct Seen {
    Point place; // px from the top left corner of the frame
    bool visible = false;
  };

  static constexpr int kOfEachKind = 40;

  MaterialPoints(const Scene &scene, int width, int height, std::uint64_t seed);

  const std::vector<MaterialPoint> &points() const { return points_; }

  /// Where each point is in a canvas that follows them. Threads may call it at the same time.
  std::vector<Seen> measure(const Canvas &canvas) const;

  /// Adds what was measured of the next frame.
  void add(const std::vector<Seen> &seen);

  /// Throws FilmError.
  void write(const std::string &path) const;

private:
  std::vector<MaterialPoint> points_;
  std::string lines_;
  long count_ = 0;
};

} // namespace film
