// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field/camera-motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <Eigen/Dense>
#include <optional>
#include <random>
#include <vector>

namespace haptic {

namespace {

constexpr int kMostParameters = 6;

using Parameters = Eigen::Matrix<double, kMostParameters, 1>;
using Equations = Eigen::Matrix<double, kMostParameters, kMostParameters>;

// Rows for vx and vy. Places are in units of half the frame's width, so that all parameters have
// one scale.
//   translation  v = (p0, p1)
//   similarity   v = (p0 + p2 x − p3 y, p1 + p3 x + p2 y)
//   affine       v = (p0 + p2 x + p3 y, p1 + p4 x + p5 y)
struct Design {
  Parameters x = Parameters::Zero();
  Parameters y = Parameters::Zero();
};

int parameters_of(MotionModel model) {
  switch (model) {
  case MotionModel::translation:
    return 2;
  case MotionModel::similarity:
    return 4;
  default:
    return kMostParameters;
  }
}

Design design_of(MotionModel model, const Eigen::Vector2d &place) {
  Design design;
  design.x[0] = 1;
  design.y[1] = 1;
  if (model == MotionModel::similarity) {
    design.x.segment<2>(2) = Eigen::Vector2d(place.x(), -place.y());
    design.y.segment<2>(2) = Eigen::Vector2d(place.y(), place.x());
  } else if (model == MotionModel::affine) {
    design.x.segment<2>(2) = place;
    design.y.segment<2>(4) = place;
  }
  return design;
}

// A cell that was measured with confidence.
struct Sure {
  Eigen::Vector2d place; // from the centre of the frame, in halves of its width
  Eigen::Vector2d moved; // px from frame to frame
};

// Of the cells of one frame.
class Consensus {
public:
  // `tolerance` in px
  Consensus(std::span<const Sure> cells, double tolerance, double aspect)
      : cells_(cells), tolerance_(tolerance), aspect_(aspect) {}

  // Least squares over the cells that `is_in` names. Nothing if they do not determine the model.
  template <typename IsIn>
  std::optional<Parameters> fit(MotionModel model, IsIn &&is_in) const {
    Equations normal = Equations::Zero();
    Parameters right = Parameters::Zero();
    for (const Sure &cell : cells_) {
      if (!is_in(cell))
        continue;
      const Design design = design_of(model, cell.place);
      normal += design.x * design.x.transpose() + design.y * design.y.transpose();
      right += design.x * cell.moved.x() + design.y * cell.moved.y();
    }
    const int count = parameters_of(model);
    const auto solver = normal.topLeftCorner(count, count).ldlt();
    constexpr double kLeast = 1e-6; // of the largest pivot
    if (solver.vectorD().minCoeff() <= kLeast * solver.vectorD().maxCoeff())
      return std::nullopt;
    Parameters found = Parameters::Zero();
    found.head(count) = solver.solve(right.head(count));
    return found;
  }

  bool agrees(const Sure &cell, MotionModel model, const Parameters &parameters) const {
    constexpr double kRelative = 0.03; // errors grow with the displacement
    const Design design = design_of(model, cell.place);
    const Eigen::Vector2d predicted(design.x.dot(parameters), design.y.dot(parameters));
    return (predicted - cell.moved).norm() < tolerance_ + kRelative * predicted.norm();
  }

  // How many cells satisfy a condition, or 0 if they are not spread over the frame.
  template <typename IsIn>
  int spread_count(IsIn &&is_in) const {
    int count = 0;
    Eigen::Array2d sum = Eigen::Array2d::Zero();
    Eigen::Array2d squares = Eigen::Array2d::Zero();
    for (const Sure &cell : cells_)
      if (is_in(cell)) {
        ++count;
        sum += cell.place.array();
        squares += cell.place.array().square();
      }
    // Cells all over the frame have a standard deviation of 0.58 of its half.
    constexpr double kSpread = 0.35;
    const Eigen::Array2d variance = squares / count - (sum / count).square();
    const Eigen::Array2d half(1, aspect_);
    return count > 0 && (variance > (kSpread * half).square()).all() ? count : 0;
  }

  // The cells that most agree on, from parameters through a few cells drawn at random.
  Parameters search(MotionModel model) const {
    // The same numbers at each call: the result is reproducible.
    std::minstd_rand random; // NOLINT(bugprone-random-generator-seed)
    const int drawn = parameters_of(model) / 2;
    const int trials = model == MotionModel::translation ? kTranslationTrials : kTrials;
    Parameters best = Parameters::Zero();
    int most = -1;
    for (int trial = 0; trial < trials; ++trial) {
      std::array<const Sure *, kMostParameters / 2> chosen = {};
      for (int i = 0; i < drawn; ++i)
        chosen[static_cast<std::size_t>(i)] = &cells_[random() % cells_.size()];
      const auto parameters =
          fit_few(model, std::span(chosen).first(static_cast<std::size_t>(drawn)));
      if (!parameters)
        continue;
      const int count = count_agreeing(model, *parameters);
      if (count > most) {
        most = count;
        best = *parameters;
      }
    }
    return best;
  }

  // The parameters after some rounds of least squares over those that agree with them.
  Parameters refine(MotionModel model, Parameters parameters) const {
    constexpr int kRounds = 4;
    for (int round = 0; round < kRounds; ++round) {
      const auto better =
          fit(model, [&](const Sure &cell) { return agrees(cell, model, parameters); });
      if (!better)
        break;
      parameters = *better;
    }
    return parameters;
  }

private:
  static constexpr int kTranslationTrials = 40;
  static constexpr int kTrials = 100;

  static std::optional<Parameters> fit_few(MotionModel model, std::span<const Sure *const> few) {
    Equations normal = Equations::Zero();
    Parameters right = Parameters::Zero();
    int row = 0;
    for (const Sure *cell : few) {
      const Design design = design_of(model, cell->place);
      normal.row(row) = design.x.transpose();
      right[row++] = cell->moved.x();
      normal.row(row) = design.y.transpose();
      right[row++] = cell->moved.y();
    }
    const auto solver = normal.topLeftCorner(row, row).partialPivLu();
    constexpr double kLeast = 0.01; // nearly one place, or one line
    if (std::abs(solver.determinant()) < kLeast)
      return std::nullopt;
    Parameters found = Parameters::Zero();
    found.head(row) = solver.solve(right.head(row));
    return found;
  }

  int count_agreeing(MotionModel model, const Parameters &parameters) const {
    int count = 0;
    for (const Sure &cell : cells_)
      count += agrees(cell, model, parameters);
    return count;
  }

  std::span<const Sure> cells_;
  double tolerance_;
  double aspect_; // height over width
};

// From px a frame and halves of the width to px/s and 1/s.
CameraMotion in_seconds(MotionModel model, const Parameters &p, double interval, double half) {
  CameraMotion camera{model, p[0] / interval, p[1] / interval, {}};
  const double per = 1 / (interval * half);
  if (model == MotionModel::similarity)
    camera.gradient = {p[2] * per, -p[3] * per, p[3] * per, p[2] * per};
  else if (model == MotionModel::affine)
    camera.gradient = {p[2] * per, p[3] * per, p[4] * per, p[5] * per};
  return camera;
}

Eigen::Vector2d centre_of(const FieldShape &shape, int cell, double width, double height) {
  const int column = cell % shape.columns;
  const int row = cell / shape.columns;
  return {((column + 0.5) / shape.columns - 0.5) * width,
          ((row + 0.5) / shape.rows - 0.5) * height};
}

} // namespace

CameraMotion find_camera_motion(std::span<const FieldCell> cells, const FieldShape &shape,
                                double width, double height, double interval) {
  constexpr float kSure = 0.5F;
  constexpr std::size_t kFewest = 16;  // cells that say something about a whole frame
  constexpr double kTolerance = 0.008; // of a cell's width: 0.25 px of 30
  std::vector<Sure> sure;
  const double half = width / 2;
  for (int i = 0; i < shape.cells(); ++i) {
    const FieldCell &cell = cells[static_cast<std::size_t>(i)];
    if (cell.confidence >= kSure)
      sure.push_back({centre_of(shape, i, width, height) / half,
                      Eigen::Vector2d(cell.velocity_x, cell.velocity_y) * interval});
  }
  if (sure.size() < kFewest)
    return {};
  const auto all = static_cast<double>(sure.size());
  const double tolerance = kTolerance * width / shape.columns;
  const Consensus consensus(sure, tolerance, height / width);
  // The more a model can bend, the more must speak for it: wind bends a meadow like an affine
  // model. Shares of the sure cells.
  struct Step {
    MotionModel model;
    double least; // that must agree
    double gain;  // by which it must exceed the best smaller model
  };
  constexpr Step kSteps[] = {{MotionModel::translation, 0.25, 0.1},
                             {MotionModel::similarity, 0.25, 0.1},
                             {MotionModel::affine, 0.5, 0.2}};
  constexpr double kLeastAtRest = 0.25;
  const double kAtRest = tolerance / 3;
  double most =
      consensus.spread_count([&](const Sure &cell) { return cell.moved.norm() < kAtRest; }) / all;
  CameraMotion camera;
  if (most >= kLeastAtRest)
    camera.model = MotionModel::still;
  for (const Step &step : kSteps) {
    const Parameters found = consensus.refine(step.model, consensus.search(step.model));
    const double share = consensus.spread_count([&](const Sure &cell) {
      return consensus.agrees(cell, step.model, found);
    }) / all;
    if (share >= step.least && share >= most + step.gain)
      camera = found.cwiseAbs().sum() < kAtRest ? CameraMotion{.model = MotionModel::still}
                                                : in_seconds(step.model, found, interval, half);
    most = std::max(most, share);
  }
  return camera;
}

void subtract(const CameraMotion &camera, std::span<FieldCell> cells, const FieldShape &shape,
              double width, double height) {
  const auto &[xx, xy, yx, yy] = camera.gradient;
  for (int i = 0; i < shape.cells(); ++i) {
    FieldCell &cell = cells[static_cast<std::size_t>(i)];
    if (!(cell.confidence > 0) || (cell.velocity_x == 0 && cell.velocity_y == 0))
      continue;
    const Eigen::Vector2d place = centre_of(shape, i, width, height);
    cell.velocity_x -= static_cast<float>(camera.x + xx * place.x() + xy * place.y());
    cell.velocity_y -= static_cast<float>(camera.y + yx * place.x() + yy * place.y());
  }
}

} // namespace haptic
