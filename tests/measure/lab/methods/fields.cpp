// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/fields.hpp"

#include "field-frames.hpp"

#include <chrono>
#include <cmath>
#include <functional>
#include <opencv2/video/tracking.hpp>
#include <optional>

namespace lab {
namespace {

constexpr int kColumns = 32;
constexpr int kPasses = 5; // the fastest counts

haptic::LumaView view(const cv::Mat &frame) {
  return {frame.data, frame.cols, frame.rows, static_cast<std::ptrdiff_t>(frame.step)};
}

// Mean of the known flow over each cell, if at least half of the cell is known.
std::vector<std::optional<cv::Vec2d>> means(const cv::Mat2f &flow,
                                            const haptic::FieldShape &shape) {
  std::vector<std::optional<cv::Vec2d>> cells;
  for (int row = 0; row < shape.rows; ++row)
    for (int column = 0; column < shape.columns; ++column) {
      const int left = column * flow.cols / shape.columns;
      const int right = (column + 1) * flow.cols / shape.columns;
      const int top = row * flow.rows / shape.rows;
      const int bottom = (row + 1) * flow.rows / shape.rows;
      cv::Vec2d sum;
      int known = 0;
      for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
          if (const cv::Vec2f &v = flow(y, x); !std::isnan(v[0])) {
            sum += cv::Vec2d(v);
            ++known;
          }
      auto &cell = cells.emplace_back();
      if (2 * known >= (right - left) * (bottom - top))
        cell = sum / known;
    }
  return cells;
}

// Time of the fastest pass in ms.
double time_of(const std::function<void()> &work) {
  double least = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
    least = std::min(least, time.count());
  }
  return least;
}

struct Peer {
  const char *name;
  std::function<void(const cv::Mat &, const cv::Mat &, cv::Mat2f &)> calculate;
};

std::vector<Peer> peers() {
  std::vector<Peer> list;
  for (const auto &[name, preset] :
       {std::pair("DIS ultrafast", cv::DISOpticalFlow::PRESET_ULTRAFAST),
        std::pair("DIS fast", cv::DISOpticalFlow::PRESET_FAST),
        std::pair("DIS medium", cv::DISOpticalFlow::PRESET_MEDIUM)})
    list.push_back({name, [dis = cv::DISOpticalFlow::create(preset)](
                              const cv::Mat &previous, const cv::Mat &current, cv::Mat2f &flow) {
                      flow.release(); // else it begins with the flow of the pass before
                      dis->calc(previous, current, flow);
                    }});
  list.push_back(
      {"Farneback", [](const cv::Mat &previous, const cv::Mat &current, cv::Mat2f &flow) {
         cv::calcOpticalFlowFarneback(previous, current, flow, 0.5, 5, 13, 3, 5, 1.1, 0);
       }});
  return list;
}

FieldRow row_of(const std::string &pair, const std::string &method,
                const std::vector<std::optional<cv::Vec2d>> &truth,
                const std::vector<cv::Vec2d> &cells, const std::vector<haptic::FieldCell> &field,
                double time) {
  FieldRow row{.pair = pair, .method = method, .time = time};
  std::vector<double> answered;
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i])
      continue;
    ++row.cells;
    const double error = cv::norm(cells[i] - *truth[i]);
    sum += error;
    if (field[i].confidence >= 0.5F)
      answered.push_back(error);
  }
  row.error = sum / static_cast<double>(row.cells);
  row.answered = static_cast<double>(answered.size()) / static_cast<double>(row.cells);
  row.error_answered = mean(answered);
  row.p95_answered = percentile(answered, 0.95);
  return row;
}

void add(const TruePair &pair, std::vector<FieldRow> &rows) {
  test::Field field(pair.previous.cols, pair.previous.rows, kColumns);
  const auto truth = means(pair.flow, field.shape);
  const auto forget = [&] {
    field.tracker.forget();
    field.follow(view(pair.previous));
  };
  double least = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < kPasses; ++pass) {
    forget();
    const auto begin = std::chrono::steady_clock::now();
    field.follow(view(pair.current));
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
    least = std::min(least, time.count());
  }
  std::vector<cv::Vec2d> cells;
  for (const haptic::FieldCell &cell : field.cells)
    cells.emplace_back(cell.velocity_x, cell.velocity_y);
  rows.push_back(row_of(pair.name, "field", truth, cells, field.cells, least));

  for (const Peer &peer : peers()) {
    cv::Mat2f flow;
    const double time = time_of([&] { peer.calculate(pair.previous, pair.current, flow); });
    std::vector<cv::Vec2d> averaged;
    for (const auto &mean : means(flow, field.shape))
      averaged.push_back(mean.value_or(cv::Vec2d()));
    rows.push_back(row_of(pair.name, peer.name, truth, averaged, field.cells, time));
  }
}

} // namespace

std::vector<FieldRow> measure_fields(const std::vector<TruePair> &pairs) {
  std::vector<FieldRow> rows;
  for (const TruePair &pair : pairs)
    add(pair, rows);
  return rows;
}

} // namespace lab
