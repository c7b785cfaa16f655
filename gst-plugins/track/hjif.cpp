// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hjif.hpp"

#include "force-curve.hpp"
#include "json-reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace haptic {
namespace {

constexpr std::int64_t kTimescale = 8000;               // ticks/s
constexpr std::int64_t kLongestEffect = 8 * kTimescale; // ticks; positions in .hmpg have 16 bits
constexpr std::int64_t kLongestHold = kTimescale / 4;
constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kUsualInterval = kSecond / 30;
constexpr std::size_t kMostKeyframes = 1'000'000; // nine hours of 30 a second
constexpr double kLatest = 1e9;                   // ticks

// ---- writing ------------------------------------------------------------------------------------

std::int64_t tick_of(std::uint64_t ns) {
  return static_cast<std::int64_t>(ns / kSecond * kTimescale +
                                   (ns % kSecond * kTimescale + kSecond / 2) / kSecond);
}

std::string number_text(double value) {
  char digits[32];
  // Four decimals are finer than the 8 bits of the binary form.
  const auto end =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, 4);
  return {digits, end.ptr};
}

// Stretches of felt samples without a pause, none longer than an effect may be.
struct Stretch {
  std::int64_t begin = 0;
  std::vector<ForcePoint> points;
};

std::vector<Stretch> stretches_of(std::span<const TrackSample> samples) {
  std::vector<Stretch> stretches;
  bool open = false;
  for (const auto &sample : samples) {
    if (sample.time == kNoTime || !is_felt(sample.motion)) {
      open = false;
      continue;
    }
    const ForcePoint point{tick_of(sample.time), force_of_motion(sample.motion)};
    if (open) {
      auto &points = stretches.back().points;
      const auto since = point.tick - points.back().tick;
      if (since == 0)
        continue;
      open = since > 0 && since <= kLongestHold;
      if (open && point.tick - stretches.back().begin > kLongestEffect) {
        const ForcePoint joint = points.back(); // the line does not break
        stretches.push_back({joint.tick, {joint}});
      }
    }
    if (!open)
      stretches.push_back({point.tick, {}});
    stretches.back().points.push_back(point);
    open = true;
  }
  return stretches;
}

std::string channel_text(std::span<const Stretch> stretches, int id) {
  const bool right = id == 0;
  std::string text = R"({"id":)" + std::to_string(id) + R"(,"description":")" +
                     (right ? "to the right" : "up") +
                     R"(","gain":1.0,"mixing_coefficient":1.0,"body_part_mask":0,)"
                     R"("direction":)" +
                     (right ? R"({"X":127,"Y":0,"Z":0})" : R"({"X":0,"Y":127,"Z":0})") +
                     R"(,"vertices":[],"bands":[{"band_type":"Curve","curve_type":)"
                     R"("Linear","lower_frequency_limit":0,"upper_frequency_limit":1000,)"
                     R"("effects":[)";
  int effect = id;
  for (const auto &stretch : stretches) {
    text += std::string(effect == id ? "" : ",") +
            "\n"
            R"({"id":)" +
            std::to_string(effect) + R"(,"effect_type":"Basis","position":)" +
            std::to_string(stretch.begin) + R"(,"keyframes":[)";
    effect += 2;
    const char *between = "";
    for (const auto &point : stretch.points) {
      text += std::string(between) + R"({"relative_position":)" +
              std::to_string(point.tick - stretch.begin) + R"(,"amplitude_modulation":)" +
              number_text(right ? point.force.x : point.force.y) + "}";
      between = ",";
    }
    text += "]}";
  }
  return text + "]}]}";
}

// ---- reading ------------------------------------------------------------------------------------

class HjifParser {
public:
  explicit HjifParser(std::string_view text) : in_(text) {}

  HjifTrack parse() {
    in_.object([this](const std::string &key) {
      if (key == "version")
        has_version_ = in_.string().starts_with("20");
      else if (key == "timescale")
        timescale_ = in_.number();
      else if (key == "perceptions")
        in_.array([this] { perception(); });
      else
        in_.skip();
    });
    in_.end();
    if (!in_.failed() && !has_version_)
      in_.fail("there is no version: this is not MPEG haptics");
    if (!in_.failed() && !(timescale_ > 0 && timescale_ <= 48000))
      in_.fail("the timescale is missing or impossible");
    if (!in_.failed() && !has_force_)
      in_.fail("there is no perception of force");
    HjifTrack track;
    if (!in_.failed())
      make_samples(track);
    if (in_.failed()) {
      track.error = in_.error();
      track.offset = in_.offset();
    }
    return track;
  }

private:
  void perception() {
    std::vector<ChannelCurve> curves;
    double exponent = 0;
    bool force = false;
    in_.object([&](const std::string &key) {
      if (key == "perception_modality")
        force = in_.string() == "Force";
      else if (key == "perception_unit_exponent")
        exponent = in_.number();
      else if (key == "channels")
        in_.array([&] { channel(curves); });
      else
        in_.skip();
    });
    if (!force)
      return;
    has_force_ = true;
    if (!(std::abs(exponent) <= 30))
      in_.fail("an impossible exponent");
    const double scale = std::pow(10.0, exponent);
    for (auto &curve : curves) {
      for (auto &point : curve.points)
        point.value = std::clamp(point.value * scale, -1.0, 1.0);
      curves_.push_back(std::move(curve));
    }
  }

  void channel(std::vector<ChannelCurve> &perception) {
    std::vector<ChannelCurve> curves;
    double gain = 1;
    std::optional<std::array<double, 2>> direction;
    in_.object([&](const std::string &key) {
      if (key == "gain")
        gain = in_.number();
      else if (key == "direction")
        direction = read_direction();
      else if (key == "bands")
        in_.array([&] { band(curves); });
      else
        in_.skip();
    });
    if (!direction)
      return;
    for (auto &curve : curves) {
      curve.direction = *direction;
      for (auto &point : curve.points)
        point.value *= gain;
      perception.push_back(std::move(curve));
    }
  }

  std::array<double, 2> read_direction() {
    std::array<double, 2> direction{};
    in_.object([&](const std::string &key) {
      const double part = in_.number();
      if (!(std::abs(part) <= 127))
        in_.fail("an impossible direction");
      if (key == "X")
        direction[0] = part / 127;
      else if (key == "Y")
        direction[1] = part / 127;
    });
    return direction;
  }

  void band(std::vector<ChannelCurve> &channel) {
    std::vector<ChannelCurve> curves;
    bool curve = false;
    in_.object([&](const std::string &key) {
      if (key == "band_type")
        curve = in_.string() == "Curve";
      else if (key == "effects")
        in_.array([&] { effect(curves); });
      else
        in_.skip();
    });
    if (curve)
      std::move(curves.begin(), curves.end(), std::back_inserter(channel));
  }

  void effect(std::vector<ChannelCurve> &band) {
    ChannelCurve curve;
    double position = 0;
    bool basis = false;
    in_.object([&](const std::string &key) {
      if (key == "effect_type")
        basis = in_.string() == "Basis";
      else if (key == "position")
        position = tick();
      else if (key == "keyframes")
        in_.array([&] { keyframe(curve); });
      else
        in_.skip();
    });
    for (auto &point : curve.points)
      point.tick += static_cast<std::int64_t>(position);
    if (basis && !curve.points.empty())
      band.push_back(std::move(curve));
  }

  void keyframe(ChannelCurve &curve) {
    ChannelCurve::Point point;
    in_.object([&](const std::string &key) {
      if (key == "relative_position")
        point.tick = static_cast<std::int64_t>(tick());
      else if (key == "amplitude_modulation")
        point.value = in_.number();
      else
        in_.skip();
    });
    if (!(std::abs(point.value) <= 1))
      in_.fail("an amplitude beyond 1");
    if (++keyframes_ > kMostKeyframes)
      in_.fail("too many keyframes");
    if (!curve.points.empty() && point.tick < curve.points.back().tick)
      in_.fail("keyframes run backwards");
    if (!in_.failed())
      curve.points.push_back(point);
  }

  double tick() {
    const double value = in_.number();
    if (!(value >= 0 && value <= kLatest))
      in_.fail("an impossible position");
    return in_.failed() ? 0 : std::round(value);
  }

  std::uint64_t ns_of(std::int64_t ticks) const {
    return static_cast<std::uint64_t>(
        std::llround(static_cast<double>(ticks) / timescale_ * static_cast<double>(kSecond)));
  }

  // In parts, since only so many points are summed at once.
  void make_samples(HjifTrack &track) {
    std::vector<std::pair<std::int64_t, std::int64_t>> spans;
    for (const auto &curve : curves_)
      spans.emplace_back(curve.points.front().tick, curve.points.back().tick + 1);
    std::sort(spans.begin(), spans.end());
    std::vector<std::pair<std::int64_t, std::int64_t>> stretches;
    for (const auto &span : spans) {
      if (stretches.empty() || span.first > stretches.back().second)
        stretches.push_back(span);
      else
        stretches.back().second = std::max(stretches.back().second, span.second);
    }
    std::size_t used = 0;
    std::sort(curves_.begin(), curves_.end(), [](const auto &a, const auto &b) {
      return a.points.front().tick < b.points.front().tick;
    });
    for (const auto &[begin, end] : stretches) {
      const std::size_t first = used;
      while (used < curves_.size() && curves_[used].points.front().tick < end)
        ++used;
      const auto points = sum_curves(std::span(curves_).subspan(first, used - first), begin, end);
      if (points.empty())
        return in_.fail("too many keyframes in one stretch");
      append(track.samples, points);
    }
  }

  void append(std::vector<TrackSample> &samples, const std::vector<ForcePoint> &points) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      TrackSample sample;
      sample.motion = motion_of_force(points[i].force);
      sample.time = ns_of(points[i].tick);
      sample.duration =
          i + 1 < points.size() ? ns_of(points[i + 1].tick) - sample.time : kUsualInterval;
      sample.motion.interval = std::min(sample.duration, kUsualInterval * 3);
      samples.push_back(sample);
    }
    TrackSample silence;
    silence.motion = motion_of_force({});
    silence.motion.confidence = 0;
    silence.motion.points = 0;
    silence.motion.model = MotionModel::none;
    silence.time = samples.back().time + samples.back().duration;
    silence.duration = kUsualInterval;
    samples.push_back(silence);
  }

  JsonReader in_;
  bool has_version_ = false;
  bool has_force_ = false;
  double timescale_ = 0;
  std::size_t keyframes_ = 0;
  std::vector<ChannelCurve> curves_;
};

} // namespace

std::string write_hjif(std::span<const TrackSample> samples, const std::string &date) {
  const auto stretches = stretches_of(samples);
  return R"({"version":"2023","profile":"Main","level":1,"date":")" + date +
         R"(","description":"Motion under a pointer in a picture, as a force","timescale":)" +
         std::to_string(kTimescale) +
         R"(,"avatars":[],"perceptions":[{"id":0,"avatar_id":0,"description":"Force along )"
         R"(the motion","perception_modality":"Force","unit_exponent":-3,)"
         R"("perception_unit_exponent":0,"effect_library":[],"reference_devices":[],)"
         R"("channels":[)"
         "\n" +
         channel_text(stretches, 0) + ",\n" + channel_text(stretches, 1) +
         R"(]}],"syncs":[{"timestamp":0}]})"
         "\n";
}

HjifTrack read_hjif(std::string_view text) {
  return HjifParser(text).parse();
}

} // namespace haptic
