// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scenes/scenes.hpp"

#include "scenes/h264.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace lab {
namespace {

constexpr int kFiner = 8;
constexpr int kApron = 36; // px of texture around the window, for what moves in
constexpr double kMiddle = kWindow / 2.0;
constexpr double kDegree = std::numbers::pi / 180;

cv::Mat1f computed(const cv::MatExpr &expression) {
  return cv::Mat(expression);
}

std::shared_ptr<const DeadLeaves> leaves(Random &random) {
  return std::make_shared<const DeadLeaves>(random);
}

// Grey levels of each pixel as a function of its centre, px from the middle.
template <typename Function>
cv::Mat1f paint(const Function &grey) {
  cv::Mat1f frame(kWindow, kWindow);
  for (int y = 0; y < kWindow; ++y)
    for (int x = 0; x < kWindow; ++x)
      frame(y, x) = static_cast<float>(grey(x + 0.5 - kMiddle, y + 0.5 - kMiddle));
  return frame;
}

// 0 left of an edge, 1 right of it, with a soft passage `width` px wide.
double soft_step(double distance, double width) {
  return std::clamp(distance / width + 0.5, 0.0, 1.0);
}

// What each pixel shows of a layer in front, 0..1.
template <typename Coverage>
cv::Mat1f compose(const cv::Mat1f &behind, const cv::Mat1f &front, const Coverage &coverage) {
  const cv::Mat1f share = paint(coverage);
  return computed(behind + (front - behind).mul(share));
}

Movie moved(std::shared_ptr<const DeadLeaves> texture, Vector velocity,
            const std::function<cv::Mat1f(cv::Mat1f, double)> &light = {}) {
  return {.light =
              [=](double time) {
                cv::Mat1f frame = texture->render({velocity * time});
                return light ? light(frame, time) : frame;
              },
          .velocity = velocity};
}

Vector random_velocity(Random &random, double reach = 3) {
  const double x = random.uniform(-reach, reach);
  return {x, random.uniform(-reach, reach)};
}

// Displacement linear in the place: x' = x + time * (m x).
Movie linear(Random &random, cv::Matx22d m, Vector velocity = {}) {
  auto texture = leaves(random);
  return {.light =
              [=](double time) {
                const cv::Matx22d inverse = (cv::Matx22d::eye() + m * time).inv();
                return texture->render(
                    {velocity * time, [=](Vector p) { return Vector(inverse * cv::Vec2d(p)); }});
              },
          .velocity = velocity};
}

Movie rotation(Random &random, double degrees) {
  auto texture = leaves(random);
  const double angle = degrees * kDegree;
  return {.light = [=](double time) {
    const double c = std::cos(angle * time);
    const double s = std::sin(angle * time);
    return texture->render(
        {{}, [=](Vector p) { return Vector(c * p.x + s * p.y, c * p.y - s * p.x); }});
  }};
}

// A leaf that bends: the displacement grows with the square of the distance from the stem.
Movie curl(Random &random, int side) {
  auto texture = leaves(random);
  const double most = random.uniform(0.5, 1.5); // px at the border of the region
  const double half = side / 2.0;
  return {.light =
              [=](double time) {
                return texture->render({{}, [=](Vector p) {
                                          const double u = p.x / half;
                                          return Vector(p.x, p.y - time * most * u * u);
                                        }});
              },
          .velocity = {0, most / 3}};
}

// Bars of random width, turned; only the motion across them can be seen.
Movie grating(Random &random) {
  struct Wave {
    double number, phase, amplitude;
  };
  std::array<Wave, 12> waves;
  double power = 0;
  for (Wave &wave : waves) {
    const double length = 5 * std::exp2(random.uniform(0, 3));
    wave = {2 * std::numbers::pi / length, random.uniform(0, 2 * std::numbers::pi),
            std::sqrt(length)};
    power += wave.amplitude * wave.amplitude / 2;
  }
  const double scale = 40 / std::sqrt(power);
  const Vector across = on_circle(random, 1);
  const double speed = random.uniform(-1.5, 1.5);
  return {.light =
              [=](double time) {
                return paint([&](double x, double y) {
                  const double along = across.x * x + across.y * y - speed * time;
                  double grey = 128;
                  for (const Wave &wave : waves)
                    grey += scale * wave.amplitude * std::sin(wave.number * along + wave.phase);
                  return grey;
                });
              },
          .velocity = across * speed};
}

Movie periodic(Random &random, double shift) {
  const double phase = random.uniform(0, 2 * std::numbers::pi);
  return {.light =
              [=](double time) {
                return paint([&](double x, double y) {
                  constexpr double kNumber = 2 * std::numbers::pi / 8;
                  return 128 + 40 * (std::sin(kNumber * (x - shift * time) + phase) +
                                     std::sin(kNumber * y + phase));
                });
              },
          .velocity = {shift, 0}};
}

Movie two_layers(Random &random, Vector behind, Vector front, double share,
                 const std::function<double(double x, double y)> &coverage) {
  auto a = leaves(random);
  auto b = leaves(random);
  return {.light =
              [=](double time) {
                return compose(a->render({behind * time}), b->render({front * time}), coverage);
              },
          .velocity = behind * (1 - share) + front * share};
}

Movie two_motions(Random &random) {
  const Vector velocity = on_circle(random, 2);
  const Vector normal = on_circle(random, 1);
  return two_layers(random, velocity, -velocity, 0.5,
                    [=](double x, double y) { return soft_step(normal.x * x + normal.y * y, 1); });
}

// A quarter of the region moves, cover and all.
Movie mover(Random &random, int side) {
  auto ground = leaves(random);
  auto thing = leaves(random);
  const Vector velocity = on_circle(random, 3);
  const double half = side / 4.0;
  return {.light =
              [=](double time) {
                return compose(ground->render({}), thing->render({velocity * time}),
                               [=](double x, double y) {
                                 const Vector at = velocity * (time - 0.5);
                                 return soft_step(half - std::abs(x - at.x), 1) *
                                        soft_step(half - std::abs(y - at.y), 1);
                               });
              },
          .velocity = velocity * 0.25};
}

Movie overlay(Random &random) {
  auto a = leaves(random);
  auto b = leaves(random);
  const Vector of_a = random_velocity(random);
  const Vector of_b = random_velocity(random);
  return {.light =
              [=](double time) {
                return computed(0.7 * a->render({of_a * time}) + 0.3 * b->render({of_b * time}));
              },
          .velocity = of_a};
}

// Full contrast in the brighter of the two frames, so that nothing is clipped.
Movie changed_gain(Random &random, double gain) {
  const double before = std::min(1.0, 1 / gain);
  return moved(leaves(random), random_velocity(random), [=](const cv::Mat1f &frame, double time) {
    return computed(before * std::pow(gain, time) * frame);
  });
}

Movie changed_offset(Random &random, double offset) {
  return moved(leaves(random), random_velocity(random), [=](const cv::Mat1f &frame, double time) {
    return computed(0.6 * frame + 51 + offset * time);
  });
}

// A soft edge that darkens one side to a half.
cv::Mat1f shaded(const cv::Mat1f &frame, Vector normal, double place) {
  constexpr double kPenumbra = 8; // px
  return computed(frame.mul(paint([=](double x, double y) {
    return 0.5 + 0.5 * soft_step(normal.x * x + normal.y * y - place, kPenumbra);
  })));
}

Movie standing_shadow(Random &random) {
  auto texture = leaves(random);
  const Vector velocity = random_velocity(random);
  const Vector normal = on_circle(random, 1);
  const double place = random.uniform(-5, 5);
  return moved(texture, velocity,
               [=](const cv::Mat1f &frame, double) { return shaded(frame, normal, place); });
}

Movie moving_shadow(Random &random) {
  auto texture = leaves(random);
  const Vector normal = on_circle(random, 1);
  const double place = random.uniform(-5, 5);
  const double speed = random.uniform(1, 3);
  return moved(texture, {}, [=](const cv::Mat1f &frame, double time) {
    return shaded(frame, normal, place + speed * time);
  });
}

// Leaves in front of an overexposed sky that covers 70 % of the region.
Movie sky(Random &random, int side) {
  auto texture = leaves(random);
  const Vector velocity = random_velocity(random);
  const double border = (0.5 - 0.7) * side;
  return {.light =
              [=](double time) {
                const cv::Mat1f bright(kWindow, kWindow, 300.0F);
                return compose(texture->render({velocity * time}), bright, [=](double, double y) {
                  return soft_step(y - border - velocity.y * time, 1);
                });
              },
          .velocity = velocity};
}

Movie motion_blur(Random &random) {
  constexpr int kSubFrames = 9;
  constexpr double kShutter = 0.5; // 180 degrees
  auto texture = leaves(random);
  const Vector velocity = on_circle(random, 6);
  return {.light =
              [=](double time) {
                cv::Mat1f sum(kWindow, kWindow, 0.0F);
                for (int i = 0; i < kSubFrames; ++i)
                  sum += texture->render({velocity * (time + kShutter * i / kSubFrames)});
                return computed(sum / kSubFrames);
              },
          .velocity = velocity};
}

// The odd lines are half a frame later.
Movie interlaced(Random &random) {
  auto texture = leaves(random);
  const Vector velocity = random_velocity(random);
  return moved(texture, velocity, [=](const cv::Mat1f &frame, double time) {
    const cv::Mat1f later = texture->render({velocity * (time + 0.5)});
    cv::Mat1f woven = frame.clone();
    for (int y = 1; y < kWindow; y += 2)
      later.row(y).copyTo(woven.row(y));
    return woven;
  });
}

// Each line is exposed a little later than the one above; a frame of 288 lines takes one
// interval.
Movie rolling_shutter(Random &random) {
  constexpr double kLines = 288;
  auto texture = leaves(random);
  const Vector velocity = random_velocity(random, 6);
  // Seen through such a shutter all that moves down is stretched.
  const double scale = 1 / (1 - velocity.y / kLines);
  return {.light =
              [=](double time) {
                return texture->render(
                    {{}, [=](Vector p) { return p - velocity * (time + p.y / kLines); }});
              },
          .velocity = velocity * scale};
}

Movie saved_as_jpeg(Movie movie) {
  movie.jpeg_quality = 30;
  return movie;
}

Movie saved_as_h264(Movie movie) {
  movie.h264_crf = 40;
  return movie;
}

// The frame shifts and turns as a whole; the leaves in and around the region are in the wind too.
Movie camera_shake(Random &random, int side) {
  auto ground = leaves(random);
  auto front = leaves(random);
  const Vector shake = random_velocity(random, 2);
  const double angle = random.uniform(-0.3, 0.3) * kDegree;
  const Vector wind = on_circle(random, random.uniform(0.5, 2));
  const double half = 0.75 * side;
  const auto place = [=](Vector p, double time) { // where it was before the shake
    const double c = std::cos(angle * time);
    const double s = std::sin(angle * time);
    return Vector(c * p.x + s * p.y, c * p.y - s * p.x);
  };
  return {.light =
              [=](double time) {
                const auto at = [=](Vector p) { return place(p, time); };
                const auto blown = [=](Vector p) { return place(p, time) - wind * time; };
                return compose(ground->render({shake * time, at}),
                               front->render({shake * time, blown}), [=](double x, double y) {
                                 const Vector p = blown(Vector(x, y) - shake * time);
                                 return soft_step(half - std::abs(p.x), 1) *
                                        soft_step(half - std::abs(p.y), 1);
                               });
              },
          .velocity = shake + Vector(std::cos(angle) * wind.x - std::sin(angle) * wind.y,
                                     std::sin(angle) * wind.x + std::cos(angle) * wind.y)};
}

Movie textureless(Random &) {
  return {.light = [](double) { return cv::Mat1f(kWindow, kWindow, 120.0F); }, .is_unseen = true};
}

Movie low_contrast(Random &random) {
  return moved(leaves(random), random_velocity(random),
               [](const cv::Mat1f &frame, double) { return computed(0.05 * frame + 120); });
}

Movie zoom(Random &random) {
  return linear(random, {0.05, 0, 0, 0.05});
}

Movie affine(Random &random) {
  cv::Matx22d m;
  for (double &value : m.val)
    value = random.uniform(0.03, 0.09) * (random.uniform(-1, 1) < 0 ? -1 : 1);
  return linear(random, m, random_velocity(random, 1));
}

Movie scene_cut(Random &random) {
  auto before = leaves(random);
  auto after = leaves(random);
  return {.light = [=](double time) { return (time < 1 ? before : after)->render({}); },
          .is_unseen = true};
}

} // namespace

DeadLeaves::DeadLeaves(Random &random, int window) : window_(window) {
  constexpr double kSmallest = 1.5; // px, radius
  constexpr double kLargest = 20;   // px
  // Painted from the back until one in three thousand places is still bare.
  constexpr double kCovered = 8;
  const double extent = window + 2 * kApron;
  const int side = static_cast<int>(extent) * kFiner;
  fine_ = cv::Mat1b(side, side, std::uint8_t{128});
  const double least = 1 / (kSmallest * kSmallest);
  const double most = 1 / (kLargest * kLargest);
  const double area = (extent + 2 * kLargest) * (extent + 2 * kLargest);
  for (double painted = 0; painted < kCovered * area;) {
    const double radius = 1 / std::sqrt(random.uniform(most, least));
    painted += std::numbers::pi * radius * radius;
    const double centre_x = random.uniform(-kLargest, extent + kLargest) * kFiner;
    const double centre_y = random.uniform(-kLargest, extent + kLargest) * kFiner;
    const auto grey = static_cast<std::uint8_t>(10 + random.index(236));
    const double r = radius * kFiner;
    const int top = std::max(0, static_cast<int>(std::ceil(centre_y - r)));
    const int bottom = std::min(side - 1, static_cast<int>(std::floor(centre_y + r)));
    for (int y = top; y <= bottom; ++y) {
      const double half = std::sqrt(std::max(0.0, r * r - (y - centre_y) * (y - centre_y)));
      // Rounded by cutting off, which is several times faster: most of the time goes here.
      const double from = std::max(0.0, centre_x - half);
      const double to = std::min(side - 1.0, centre_x + half);
      const int left = static_cast<int>(from) + (from > static_cast<int>(from));
      const int right = to < 0 ? -1 : static_cast<int>(to);
      if (left <= right)
        std::fill_n(fine_.ptr(y) + left, right - left + 1, grey);
    }
  }
}

cv::Mat1f DeadLeaves::render(const Warp &warp) const {
  return warp.bend ? render_bent(warp) : render_shifted(warp.shift);
}

cv::Mat1f DeadLeaves::render_shifted(Vector shift) const {
  const double left = (kApron - shift.x) * kFiner;
  const double top = (kApron - shift.y) * kFiner;
  const auto whole = [](double place) { return static_cast<int>(std::floor(place)); };
  const cv::Rect needed(whole(left), whole(top), window_ * kFiner + 1, window_ * kFiner + 1);
  CV_Assert((needed & cv::Rect({}, fine_.size())) == needed);
  const cv::Mat1b source = fine_(needed);
  // The area of a pixel covers eight whole fine samples, or seven and two parts.
  const auto weights = [](double place) {
    const auto part = static_cast<float>(place - std::floor(place));
    std::array<float, kFiner + 1> w;
    w.fill(1.0F / kFiner);
    w.front() = (1 - part) / kFiner;
    w.back() = part / kFiner;
    return w;
  };
  const auto across = weights(left);
  const auto down = weights(top);
  cv::Mat1f frame(window_, window_);
  std::vector<float> row(static_cast<std::size_t>(source.cols));
  for (int y = 0; y < window_; ++y) {
    std::fill(row.begin(), row.end(), 0.0F);
    for (int i = 0; i <= kFiner; ++i) {
      const std::uint8_t *line = source.ptr(y * kFiner + i);
      const float weight = down[static_cast<std::size_t>(i)];
      for (std::size_t x = 0; x < row.size(); ++x)
        row[x] += weight * line[x];
    }
    for (int x = 0; x < window_; ++x) {
      float sum = 0;
      for (int i = 0; i <= kFiner; ++i)
        sum += across[static_cast<std::size_t>(i)] * row[static_cast<std::size_t>(x * kFiner + i)];
      frame(y, x) = sum;
    }
  }
  return frame;
}

cv::Mat1f DeadLeaves::render_bent(const Warp &warp) const {
  // A sample between two fine ones holds both: every other is enough.
  constexpr int kSamples = kFiner / 2;
  const float middle = static_cast<float>(window_) / 2;
  const float last = static_cast<float>(fine_.cols) - 1.001F;
  const auto sample = [&](float fx, float fy) {
    fx = std::clamp(fx, 0.0F, last);
    fy = std::clamp(fy, 0.0F, last);
    const int x = static_cast<int>(fx);
    const int y = static_cast<int>(fy);
    const float u = fx - static_cast<float>(x);
    const float v = fy - static_cast<float>(y);
    const std::uint8_t *upper = fine_.ptr(y) + x;
    const std::uint8_t *lower = fine_.ptr(y + 1) + x;
    return (1 - v) * ((1 - u) * upper[0] + u * upper[1]) + v * ((1 - u) * lower[0] + u * lower[1]);
  };
  const auto bent = [&](double x, double y) {
    return cv::Point2f(warp.bend(Vector(x - middle, y - middle) - warp.shift)) * kFiner +
           cv::Point2f(1, 1) * ((kApron + middle) * kFiner - 0.5F);
  };
  cv::Mat1f frame(window_, window_);
  for (int y = 0; y < window_; ++y)
    for (int x = 0; x < window_; ++x) {
      // Linear within the pixel: what it bends there is some ten-thousandths of a pixel.
      const cv::Point2f across = (bent(x + 1, y + 0.5) - bent(x, y + 0.5)) / kSamples;
      const cv::Point2f down = (bent(x + 0.5, y + 1) - bent(x + 0.5, y)) / kSamples;
      const cv::Point2f first = bent(x + 0.5, y + 0.5) - (across + down) * (0.5F * (kSamples - 1));
      float sum = 0;
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i)
          sum +=
              sample(first.x + across.x * static_cast<float>(i) + down.x * static_cast<float>(j),
                     first.y + across.y * static_cast<float>(i) + down.y * static_cast<float>(j));
      frame(y, x) = sum / (kSamples * kSamples);
    }
  return frame;
}

Vector on_circle(Random &random, double radius) {
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

Movie uniform_translation(Random &random, double reach, double noise) {
  Movie movie = translation(random, random_velocity(random, reach));
  movie.noise = noise;
  return movie;
}

Movie translation(Random &random, Vector velocity, double contrast, int window) {
  return moved(
      std::make_shared<const DeadLeaves>(random, window), velocity,
      [=](const cv::Mat1f &frame, double) { return computed(contrast * (frame - 128) + 128); });
}

std::vector<Scene> hard_scenes(int side) {
  const auto still = [](double noise) {
    return [=](Random &r) {
      Movie movie = translation(r, {});
      movie.noise = noise;
      return movie;
    };
  };
  const auto displaced = [](double distance) {
    return [=](Random &r) {
      const Vector velocity = on_circle(r, distance);
      return translation(r, velocity);
    };
  };
  std::vector<Scene> scenes = {
      {"still noise 1.5", still(1.5)},
      {"still noise 5", still(5)},
      {"still noise 10", still(10)},
      {"textureless", textureless},
      {"low contrast", low_contrast},
      {"aperture", grating},
      {"periodic", [](Random &r) { return periodic(r, 5); }},
      {"noise 10", [](Random &r) { return uniform_translation(r, 3, 10); }},
      {"gain 0.7", [](Random &r) { return changed_gain(r, 0.7); }},
      {"gain 1.2", [](Random &r) { return changed_gain(r, 1.2); }},
      {"gain 1.4", [](Random &r) { return changed_gain(r, 1.4); }},
      {"offset -40", [](Random &r) { return changed_offset(r, -40); }},
      {"offset +40", [](Random &r) { return changed_offset(r, 40); }},
      {"standing shadow", standing_shadow},
      {"moving shadow", moving_shadow},
      {"saturated sky", [=](Random &r) { return sky(r, side); }},
      {"motion blur", motion_blur},
      {"displacement 8", displaced(8)},
      {"displacement 12", displaced(12)},
      {"displacement 16", displaced(16)},
      {"displacement 24", displaced(24)},
      {"rotation", [](Random &r) { return rotation(r, 5); }},
      {"zoom", zoom},
      {"affine", affine},
      {"curl", [=](Random &r) { return curl(r, side); }},
      {"two motions", two_motions},
      {"mover", [=](Random &r) { return mover(r, side); }},
      {"overlay", overlay},
      {"jpeg moving", [](Random &r) { return saved_as_jpeg(uniform_translation(r, 3)); }},
      {"jpeg still", [](Random &r) { return saved_as_jpeg(translation(r, {})); }},
      {"scene cut", scene_cut},
      {"interlaced", interlaced},
      {"rolling shutter", rolling_shutter},
      {"camera shake", [=](Random &r) { return camera_shake(r, side); }},
  };
  if (has_h264()) {
    scenes.push_back(
        {kRoundedMotion, [](Random &r) { return saved_as_h264(uniform_translation(r, 3)); }});
    scenes.push_back({"h264 still", [](Random &r) { return saved_as_h264(translation(r, {})); }});
  }
  return scenes;
}

const Scene &scene_named(const std::vector<Scene> &scenes, const std::string &name) {
  const auto found = std::ranges::find(scenes, name, &Scene::name);
  if (found == scenes.end())
    throw std::out_of_range("there is no scene '" + name + "'");
  return *found;
}

cv::Mat expose(const Movie &movie, double time, Random &random) {
  cv::Mat1f light = movie.light(time);
  for (float &grey : light)
    grey = static_cast<float>(std::clamp(grey + movie.noise * random.normal(), 0.0, 255.0));
  cv::Mat frame;
  light.convertTo(frame, CV_8U);
  if (movie.jpeg_quality > 0) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", frame, bytes, {cv::IMWRITE_JPEG_QUALITY, movie.jpeg_quality});
    frame = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  }
  return frame;
}

std::array<cv::Mat, 2> expose_pair(const Movie &movie, Random &random) {
  // The key frame is so many frames before the pair.
  const int before = movie.h264_crf > 0 ? 3 : 0;
  std::vector<cv::Mat> clip;
  for (int time = -before; time <= 1; ++time)
    clip.push_back(expose(movie, time, random));
  if (movie.h264_crf > 0)
    clip = through_h264(clip, movie.h264_crf);
  return {clip[clip.size() - 2], clip.back()};
}

cv::Mat embed(const cv::Mat &window, cv::Size size) {
  const int left = (size.width - window.cols) / 2;
  const int top = (size.height - window.rows) / 2;
  cv::Mat frame;
  cv::copyMakeBorder(window, frame, top, size.height - window.rows - top, left,
                     size.width - window.cols - left, cv::BORDER_REFLECT);
  return frame;
}

double cramer_rao_bound(const cv::Mat1f &light, int side, double noise) {
  constexpr double kRounding = 1.0 / 12; // variance of rounding to whole grey levels
  double xx = 0;
  double xy = 0;
  double yy = 0;
  const int first = (light.cols - side) / 2;
  for (int y = first; y < first + side; ++y)
    for (int x = first; x < first + side; ++x) {
      const double gx = (light(y, x + 1) - light(y, x - 1)) / 2;
      const double gy = (light(y + 1, x) - light(y - 1, x)) / 2;
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  const double variance = 2 * (noise * noise + kRounding);
  const double trace = variance * (xx + yy) / (xx * yy - xy * xy);
  // Mean length of a two-dimensional normal vector, taken as round.
  return std::sqrt(std::numbers::pi / 4 * trace);
}

} // namespace lab
