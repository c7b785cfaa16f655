// Where to look: from the pointer and a side length to the region and the crop around it.
#pragma once

namespace haptic {

/// Pixels of a picture, origin at its top left corner.
struct Rectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const Rectangle &) const = default;
};

/// Less of a region than this on either side is too little to say how it moves, px.
inline constexpr int kSmallestRegion = 12;

/// Side of the region at a picture width, both px: 30 px in a picture 352 px wide (paper, 3.2.1).
int default_region_side(int picture_width);

/// The hand's third dimension: how far it is pulled towards the user chooses how much of the
/// picture it feels, the fruit or the tree. Not thread-safe.
class RegionSize {
public:
  /// Side in px, even. `z` is that of the pointer event, -1..1 of the half workspace: `base` at 0,
  /// doubled for each quarter of the workspace towards the user, halved away from him. Bounded by
  /// what can be measured and by half of the picture. Follows only a change of more than a tenth,
  /// so that a hand that trembles leaves the size alone.
  int side(double z, int base, int picture_width, int picture_height);

private:
  int side_ = 0;
};

/// The square of `side` px about the pointer, clipped at the picture. `pointer_x` and `pointer_y`
/// are fractions of the picture, 0..1, origin at its top left (paper, equation 1). The centre stays
/// under the pointer: at a border the region gets smaller, it does not move inwards. At least 1x1.
Rectangle region_at(double pointer_x, double pointer_y, int side, int picture_width,
                    int picture_height);

/// The rectangle grown by `margin` px on each side and clipped at the picture.
Rectangle crop_around(const Rectangle &region, int margin, int picture_width, int picture_height);

bool is_measurable(const Rectangle &region);

} // namespace haptic
