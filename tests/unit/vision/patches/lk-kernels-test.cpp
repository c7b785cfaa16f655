// SPDX-License-Identifier: LGPL-2.1-or-later
// Each instruction set against plain loops in double precision, written from the formulas above the
// kernels.
#include "field-frames.hpp"
#include "instruction-sets.hpp"
#include "patches/lk-kernels.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace lk_kernels_test {

using haptic::Alignment;
using haptic::Displacement;
using haptic::Fit;
using haptic::Plane;
using haptic::Strain;
using haptic::Template;
using test::Texture;

constexpr int kSides[] = {8, 16};
constexpr int kFrame = 64;

Plane plane_of(unsigned seed, test::Shift shift) {
  Plane plane;
  haptic::smooth(test::view_of(Texture(seed).frame(kFrame, kFrame, shift)), plane);
  return plane;
}

// Bilinear interpolation.
double sample(const Plane &plane, double x, double y) {
  const int column = std::min(static_cast<int>(x), plane.width() - 2);
  const int row = std::min(static_cast<int>(y), plane.height() - 2);
  const double u = x - column;
  const double v = y - row;
  const float *upper = plane.row(row) + column;
  const float *lower = plane.row(row + 1) + column;
  return (1 - v) * ((1 - u) * upper[0] + u * upper[1]) + v * ((1 - u) * lower[0] + u * lower[1]);
}

struct Vector {
  double x = 0;
  double y = 0;
};

// A template in double precision.
struct Reference {
  int side;
  std::vector<double> t; // zero-mean grey levels
  std::vector<Vector> g; // projected gradients
  double energy = 0;     // sum t^2
  double slope = 0;      // -sum t laplacian
  double curvature = 0;  // sum laplacian^2
  double xx = 0, xy = 0, yy = 0;

  // `grey(i, j)`: pixel in column i and row j, from -1 to side.
  Reference(int length, const auto &grey) : side(length) {
    const double n = side * side;
    double mean = 0;
    Vector mean_gradient;
    std::vector<double> laplacian;
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        t.push_back(grey(i, j));
        g.push_back({(grey(i + 1, j) - grey(i - 1, j)) / 2, (grey(i, j + 1) - grey(i, j - 1)) / 2});
        laplacian.push_back(grey(i - 1, j) + grey(i + 1, j) + grey(i, j - 1) + grey(i, j + 1) -
                            4 * grey(i, j));
        mean += t.back() / n;
        mean_gradient.x += g.back().x / n;
        mean_gradient.y += g.back().y / n;
      }
    Vector b;
    for (std::size_t i = 0; i < t.size(); ++i) {
      t[i] -= mean;
      energy += t[i] * t[i];
      slope -= t[i] * laplacian[i];
      curvature += laplacian[i] * laplacian[i];
      b.x += t[i] * g[i].x;
      b.y += t[i] * g[i].y;
    }
    const double ridge = 0.8 * n;
    for (std::size_t i = 0; i < t.size(); ++i) {
      g[i].x -= mean_gradient.x + b.x / (energy + ridge) * t[i];
      g[i].y -= mean_gradient.y + b.y / (energy + ridge) * t[i];
      xx += g[i].x * g[i].x;
      xy += g[i].x * g[i].y;
      yy += g[i].y * g[i].y;
    }
  }

  static Reference at(const Plane &plane, double x, double y, int side) {
    return {side, [&](int i, int j) { return sample(plane, x + i, y + j); }};
  }

  struct Fitted {
    Vector gradient;
    double correlation;
    double residual;
  };
  // `x`, `y`: place of the first pixel in the later frame.
  Fitted fit(const Plane &later, double x, double y) const {
    const double n = side * side;
    Fitted fitted{};
    double mean = 0;
    double cross = 0;
    std::vector<double> grey;
    for (std::size_t i = 0; i < t.size(); ++i) {
      const auto column = static_cast<int>(i) % side;
      const auto row = static_cast<int>(i) / side;
      grey.push_back(sample(later, x + column, y + row));
      fitted.gradient.x += g[i].x * (grey.back() - t[i]);
      fitted.gradient.y += g[i].y * (grey.back() - t[i]);
      cross += t[i] * grey.back();
      mean += grey.back() / n;
    }
    double later_energy = 0;
    for (const double value : grey)
      later_energy += (value - mean) * (value - mean);
    fitted.correlation = cross / std::sqrt(energy * later_energy);
    const double explained = cross > 0 ? cross * cross / energy : 0;
    fitted.residual = std::sqrt((later_energy - explained) / n);
    return fitted;
  }
};

void expect_equal(const Template &found, const Reference &expected) {
  const double trace = expected.xx + expected.yy;
  EXPECT_NEAR(found.energy, expected.energy, 1e-4 * expected.energy);
  EXPECT_NEAR(found.slope, expected.slope, 1e-4 * expected.energy);
  EXPECT_NEAR(found.curvature, expected.curvature, 1e-3 * expected.curvature);
  EXPECT_NEAR(found.structure.xx, expected.xx, 1e-4 * trace);
  EXPECT_NEAR(found.structure.xy, expected.xy, 1e-4 * trace);
  EXPECT_NEAR(found.structure.yy, expected.yy, 1e-4 * trace);
  for (std::size_t i = 0; i < expected.t.size(); ++i) {
    EXPECT_NEAR(found.grey[i], expected.t[i], 2e-3);
    EXPECT_NEAR(found.gradient_x[i], expected.g[i].x, 2e-3);
    EXPECT_NEAR(found.gradient_y[i], expected.g[i].y, 2e-3);
  }
}

Template prepared(const Plane &plane, float x, float y, int side) {
  Template patch;
  patch.x = x;
  patch.y = y;
  patch.side = side;
  haptic::prepare_templates(plane, {&patch, 1});
  return patch;
}

class LkKernels : public ::testing::Test {
protected:
  // Calls body() for each instruction set and each side of a patch.
  static void for_all(const auto &body) {
    test::for_instruction_sets([&](const char *name) {
      for (const int side : kSides) {
        SCOPED_TRACE(testing::Message() << name << ", side " << side);
        body(side);
      }
    });
  }
};

TEST_F(LkKernels, TemplatesHaveGradientsFreeOfGainAndOffset) {
  const Plane plane = plane_of(1, {});
  for_all([&](int side) {
    for (const auto &[x, y] : {std::pair(20.0F, 17.0F), {12.25F, 30.25F}, {1.75F, 9.75F}, {1, 1}})
      expect_equal(prepared(plane, x, y, side), Reference::at(plane, x, y, side));
  });
}

TEST_F(LkKernels, FitsAreGradientCorrelationAndResidual) {
  const Plane earlier = plane_of(3, {});
  const Plane later = plane_of(3, {1.3, -0.6});
  for_all([&](int side) {
    const Template patch = prepared(earlier, 20.25F, 22.25F, side);
    const Reference reference = Reference::at(earlier, patch.x, patch.y, side);
    for (const Displacement d : {Displacement{0, 0}, {1.3F, -0.6F}, {-4.5F, 7.25F}, {9, 2}}) {
      Fit fit;
      haptic::fit_templates(later, {&patch, 1}, d, {&fit, 1});
      const auto expected = reference.fit(later, patch.x + d.x, patch.y + d.y);
      const double scale = 255.0 * side * std::sqrt(reference.xx + reference.yy);
      EXPECT_TRUE(fit.inside);
      EXPECT_NEAR(fit.gradient.x, expected.gradient.x, 1e-6 * scale);
      EXPECT_NEAR(fit.gradient.y, expected.gradient.y, 1e-6 * scale);
      EXPECT_NEAR(fit.correlation, expected.correlation, 1e-4);
      EXPECT_NEAR(fit.residual * fit.residual, expected.residual * expected.residual, 0.02);
    }
  });
}

// The ridge of the energy leaves a part of the grey levels in the gradients.
TEST_F(LkKernels, ATemplateOfLittleContrastIsNotDrawnTowardsRest) {
  constexpr float kContrast = 0.02F;
  const test::Shift truth{0.4, -0.3};
  Plane earlier = plane_of(5, {});
  Plane later = plane_of(5, truth);
  for (Plane *plane : {&earlier, &later})
    for (int y = 0; y < plane->height(); ++y)
      for (int x = 0; x < plane->width(); ++x)
        plane->row(y)[x] *= kContrast;
  for_all([&](int side) {
    const Template patch = prepared(earlier, 24.25F, 22.25F, side);
    Fit fit;
    haptic::fit_templates(earlier, {&patch, 1}, {}, {&fit, 1});
    const float scale = std::sqrt(patch.energy * (patch.structure.xx + patch.structure.yy));
    EXPECT_NEAR(fit.gradient.x, 0, 1e-4F * scale);
    EXPECT_NEAR(fit.gradient.y, 0, 1e-4F * scale);
  });
}

TEST_F(LkKernels, StrainedPatchesFindTheDisplacementOfTheirMiddle) {
  const Plane earlier = plane_of(2, {});
  const Strain strain{0.05F, -0.11F, 0.08F, -0.03F};
  const Displacement moved{1.3F, -0.6F};
  const double determinant = (1 + strain.xx) * (1 + strain.yy) - strain.xy * strain.yx;
  for_all([&](int side) {
    const Template patch = prepared(earlier, 21.25F, 22.75F, side);
    const double middle = 0.5 * (side - 1);
    Plane later = earlier;
    for (int y = 0; y < later.height(); ++y)
      for (int x = 0; x < later.width(); ++x) {
        const double right = (x - middle - static_cast<double>(patch.x + moved.x)) / determinant;
        const double down = (y - middle - static_cast<double>(patch.y + moved.y)) / determinant;
        const auto within = [](double at, int length) { return std::clamp(at, 0.0, length - 1.0); };
        later.row(y)[x] = static_cast<float>(sample(
            earlier,
            within(patch.x + middle + (1 + strain.yy) * right - strain.xy * down, later.width()),
            within(patch.y + middle - strain.yx * right + (1 + strain.xx) * down, later.height())));
      }
    const Displacement start{1, -1};
    const Alignment found = haptic::align_strained(later, patch, strain, start, 8);
    EXPECT_NEAR(found.displacement.x, moved.x, 0.03);
    EXPECT_NEAR(found.displacement.y, moved.y, 0.03);
    EXPECT_LT(found.fit.residual,
              0.5F * haptic::align_template(later, patch, {&start, 1}, 8).fit.residual);
  });
}

TEST_F(LkKernels, NothingIsKnownOfATemplateThatLeavesThePlane) {
  const Plane plane = plane_of(4, {});
  for_all([&](int side) {
    const Template patch = prepared(plane, 20, 20, side);
    for (const Displacement d : {Displacement{-21, 0}, {0, -21}, {43, 0}, {0, 43}}) {
      Fit fit{.correlation = 1, .residual = 0, .inside = true};
      haptic::fit_templates(plane, {&patch, 1}, d, {&fit, 1});
      EXPECT_FALSE(fit.inside);
      EXPECT_EQ(fit.correlation, -1);
      EXPECT_TRUE(std::isinf(fit.residual));
    }
  });
}

// Gauss-Newton without the limits of the kernel, until it stands still.
Vector descend(const Reference &reference, const Template &patch, const Plane &later) {
  const double ridge = haptic::regulariser(patch.structure, static_cast<float>(patch.side) *
                                                                static_cast<float>(patch.side));
  const double xx = reference.xx + ridge;
  const double yy = reference.yy + ridge;
  const double determinant = xx * yy - reference.xy * reference.xy;
  Vector d;
  for (int i = 0; i < 100; ++i) {
    const Vector g = reference.fit(later, patch.x + d.x, patch.y + d.y).gradient;
    d.x -= (yy * g.x - reference.xy * g.y) / determinant;
    d.y -= (xx * g.y - reference.xy * g.x) / determinant;
  }
  return d;
}

TEST_F(LkKernels, AlignmentEndsWhereGaussNewtonStandsStill) {
  const test::Shift truth{0.8, -0.55};
  const Plane earlier = plane_of(5, {});
  const Plane later = plane_of(5, truth);
  for_all([&](int side) {
    for (const float x : {10.25F, 24.75F, 37.25F}) {
      const Template patch = prepared(earlier, x, 22.25F, side);
      const Reference reference = Reference::at(earlier, patch.x, patch.y, side);
      const Vector expected = descend(reference, patch, later);
      const Displacement start;
      const auto aligned = haptic::align_template(later, patch, {&start, 1}, 20);
      // The last step is shorter than 0.017 px, and each is a fraction of the one before.
      EXPECT_NEAR(aligned.displacement.x, expected.x, 0.01);
      EXPECT_NEAR(aligned.displacement.y, expected.y, 0.01);
      EXPECT_NEAR(aligned.displacement.x, truth.x, 0.1);
      EXPECT_NEAR(aligned.displacement.y, truth.y, 0.1);
      EXPECT_GT(aligned.fit.correlation, 0.99F);
    }
  });
}

TEST_F(LkKernels, AlignmentBeginsAtTheStartThatFitsBest) {
  const Plane earlier = plane_of(6, {});
  const Plane later = plane_of(6, {7, -5});
  for_all([&](int side) {
    const Template patch = prepared(earlier, 24.25F, 24.25F, side);
    const Displacement starts[] = {{0, 0}, {-6, 4}, {6.7F, -4.8F}, {2, -9}};
    const auto aligned = haptic::align_template(later, patch, starts, 10);
    EXPECT_NEAR(aligned.displacement.x, 7, 0.1);
    EXPECT_NEAR(aligned.displacement.y, -5, 0.1);
  });
}

TEST_F(LkKernels, GainAndOffsetDoNotMoveTheAlignment) {
  const Plane earlier = plane_of(7, {});
  Plane later = plane_of(7, {0.4, 0.3});
  const Plane same = later;
  for (int y = 0; y < later.height(); ++y)
    for (int x = 0; x < later.width(); ++x)
      later.row(y)[x] = 0.7F * later.row(y)[x] + 40;
  for_all([&](int side) {
    const Template patch = prepared(earlier, 20.25F, 25.25F, side);
    const Displacement start;
    const auto plain = haptic::align_template(same, patch, {&start, 1}, 20);
    const auto changed = haptic::align_template(later, patch, {&start, 1}, 20);
    EXPECT_NEAR(changed.displacement.x, plain.displacement.x, 0.01);
    EXPECT_NEAR(changed.displacement.y, plain.displacement.y, 0.01);
    EXPECT_NEAR(changed.fit.correlation, plain.fit.correlation, 1e-3);
  });
}

TEST_F(LkKernels, SearchFindsTheLargestCorrelationWithinItsRadius) {
  const Plane earlier = plane_of(8, {});
  const Plane later = plane_of(8, {6, -4});
  for_all([&](int side) {
    const Template patch = prepared(earlier, 20, 24, side);
    const Reference reference = Reference::at(earlier, patch.x, patch.y, side);
    for (const int radius : {3, 8, 12, 40}) {
      const auto found = haptic::search_template(later, patch, {1, -1}, radius);
      const int reach = std::min(radius, 12);
      double best = -1;
      Vector at;
      for (double y = -1 - reach; y <= -1 + reach; ++y)
        for (double x = 1 - reach; x <= 1 + reach; ++x)
          if (const double c = reference.fit(later, patch.x + x, patch.y + y).correlation;
              c > best) {
            best = c;
            at = {x, y};
          }
      EXPECT_EQ(found.best.x, at.x) << radius;
      EXPECT_EQ(found.best.y, at.y) << radius;
      EXPECT_NEAR(found.correlation, best, 1e-4) << radius;
    }
  });
}

TEST(Regulariser, IsTheNoiseOfThePixelsAndAShareOfTheTrace) {
  EXPECT_FLOAT_EQ(haptic::regulariser({}, 64), 0.16F * 64);
  EXPECT_FLOAT_EQ(haptic::regulariser({100, 7, 300}, 64), 0.16F * 64 + 0.03F * 400);
}

} // namespace lk_kernels_test
