// SPDX-License-Identifier: LGPL-2.1-or-later
#include "methods/motion-vectors.hpp"

#include "scenes/h264.hpp"

#ifdef HAVE_LIBAVCODEC
#include "methods/cases.hpp"
#include "methods/measure.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <limits>
#include <stdexcept>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/motion_vector.h>
}
#endif

namespace lab {

#ifndef HAVE_LIBAVCODEC

std::string why_no_motion_vectors() {
  return "built without libavcodec-dev";
}

std::vector<VectorRow> measure_vectors(bool, const std::optional<std::filesystem::path> &) {
  return {};
}

#else

namespace {

constexpr int kSide = 30;

struct Decoded {
  cv::Mat luma;
  std::vector<AVMotionVector> vectors; // none of a key frame
};

void check(int status, const char *what) {
  if (status < 0)
    throw std::runtime_error(std::string("libavcodec: ") + what);
}

// One thread, as all methods of the lab.
class Decoder {
public:
  explicit Decoder(bool with_vectors) {
    const AVCodec *codec = avcodec_find_decoder(AV_CODEC_ID_H264);
    context_.reset(codec ? avcodec_alloc_context3(codec) : nullptr);
    if (!context_)
      throw std::runtime_error("libavcodec: there is no decoder of H.264");
    context_->thread_count = 1;
    if (with_vectors)
      context_->flags2 |= AV_CODEC_FLAG2_EXPORT_MVS;
    check(avcodec_open2(context_.get(), codec, nullptr), "the decoder does not open");
  }

  // Calls body(frame) for every frame, in the order of display.
  template <typename Body>
  void decode(const H264Stream &stream, const Body &body) {
    for (const auto &unit : stream) {
      check(av_new_packet(packet_.get(), static_cast<int>(unit.size())), "no memory");
      std::ranges::copy(unit, packet_->data);
      check(avcodec_send_packet(context_.get(), packet_.get()), "a frame cannot be decoded");
      av_packet_unref(packet_.get());
      receive(body);
    }
    check(avcodec_send_packet(context_.get(), nullptr), "the stream does not end");
    receive(body);
  }

private:
  struct Free {
    void operator()(AVCodecContext *context) const { avcodec_free_context(&context); }
    void operator()(AVPacket *packet) const { av_packet_free(&packet); }
    void operator()(AVFrame *frame) const { av_frame_free(&frame); }
  };

  template <typename Body>
  void receive(const Body &body) {
    while (avcodec_receive_frame(context_.get(), frame_.get()) >= 0)
      body(*frame_);
  }

  std::unique_ptr<AVCodecContext, Free> context_;
  std::unique_ptr<AVPacket, Free> packet_{av_packet_alloc()};
  std::unique_ptr<AVFrame, Free> frame_{av_frame_alloc()};
};

std::vector<Decoded> decode(const H264Stream &stream) {
  std::vector<Decoded> frames;
  Decoder(true).decode(stream, [&](const AVFrame &frame) {
    const cv::Mat luma(frame.height, frame.width, CV_8UC1, frame.data[0],
                       static_cast<std::size_t>(frame.linesize[0]));
    frames.push_back({luma.clone(), {}});
    if (const AVFrameSideData *side =
            av_frame_get_side_data(&frame, AV_FRAME_DATA_MOTION_VECTORS)) {
      const auto *first = reinterpret_cast<const AVMotionVector *>(side->data);
      frames.back().vectors.assign(first, first + side->size / sizeof(AVMotionVector));
    }
  });
  return frames;
}

// µs that this thread, which decodes alone, has run: a small difference between long times must not
// depend on other programs.
double busy_time() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

// What the vectors cost the decoder per frame in µs: with them minus without, in turns.
double export_time(const H264Stream &stream, std::size_t frames, bool quick) {
  const int passes = quick ? 3 : 15;
  std::array<double, 2> least;
  least.fill(std::numeric_limits<double>::infinity());
  for (int pass = 0; pass < passes; ++pass)
    for (const bool with_vectors : {false, true}) {
      Decoder decoder(with_vectors);
      const double begin = busy_time();
      decoder.decode(stream, [](const AVFrame &) {});
      least[with_vectors] = std::min(least[with_vectors], busy_time() - begin);
    }
  return (least[1] - least[0]) / static_cast<double>(frames);
}

// The mean over the area that blocks with a vector cover: sum(area motion) / sum(area). A vector
// points to where the block was (or will be); libavcodec does not export how many frames away that
// is: one is assumed. The confidence is the covered share, which blocks with two vectors have
// twice.
Reading mean_vector(std::span<const AVMotionVector> vectors, const cv::Rect &region) {
  Vector sum;
  double covered = 0;
  for (const AVMotionVector &v : vectors) {
    const cv::Rect block(v.dst_x - v.w / 2, v.dst_y - v.h / 2, v.w, v.h);
    const double area = (block & region).area();
    if (area == 0 || v.motion_scale == 0)
      continue;
    const double forward = v.source < 0 ? -1.0 : 1.0;
    sum += Vector(v.motion_x, v.motion_y) * (forward * area / v.motion_scale);
    covered += area;
  }
  if (covered == 0)
    return {};
  return {.velocity = sum / covered, .confidence = std::min(1.0, covered / region.area())};
}

// Answers to one video by one method.
struct Tally {
  std::vector<double> errors;
  std::vector<double> times;
  double answered = 0;

  void add(const Reading &reading, Vector truth, double time) {
    errors.push_back(cv::norm((reading.confidence > 0 ? reading.velocity : Vector()) - truth));
    times.push_back(time);
    answered += reading.confidence > 0;
  }
  VectorRow row(const std::string &video, const std::string &method, double decoding) const {
    return {.video = video,
            .method = method,
            .cases = errors.size(),
            .answered = answered / static_cast<double>(errors.size()),
            .error = mean(errors),
            .p95 = percentile(errors, 0.95),
            .decoding = decoding,
            .time = percentile(times, 0.5)};
  }
};

constexpr const char *kVectors = "vectors of the decoder";

// What is compared with the vectors: the methods as shipped that need no more than a millisecond.
std::vector<Configuration> trackers() {
  std::vector<Configuration> list = configurations(true);
  std::erase_if(list, [](const Configuration &c) {
    return !c.is_default || (c.method != "fast" && c.method != "PyrLK crop");
  });
  return list;
}

// One video and what all methods answer to it.
class Contest {
public:
  explicit Contest(std::string video) : video_(std::move(video)) {
    for (const Configuration &c : trackers())
      methods_.push_back({c.method, c.make(), {}});
  }

  void compare(const Decoded &before, const Decoded &now, cv::Point place, Vector truth) {
    const cv::Rect region(place, cv::Size(kSide, kSide));
    const auto begin = Clock::now();
    const Reading of_vectors = mean_vector(now.vectors, region);
    vectors_.add(of_vectors, truth, microseconds_since(begin));
    const Vector middle(place.x + kSide / 2.0, place.y + kSide / 2.0);
    const Task task{
        before.luma, now.luma, {middle.x / now.luma.cols, middle.y / now.luma.rows}, kSide};
    for (Entry &entry : methods_) {
      entry.method->forget();
      const auto start = Clock::now();
      const Reading reading = entry.method->measure(task);
      entry.tally.add(reading, truth, microseconds_since(start));
    }
  }

  void finish(double decoding, std::vector<VectorRow> &rows) const {
    if (vectors_.errors.empty())
      return;
    rows.push_back(vectors_.row(video_, kVectors, decoding));
    for (const Entry &entry : methods_)
      rows.push_back(entry.tally.row(video_, entry.name, 0));
  }

private:
  struct Entry {
    std::string name;
    std::unique_ptr<Method> method;
    Tally tally;
  };

  std::string video_;
  Tally vectors_;
  std::vector<Entry> methods_;
};

const cv::Size kFrame(352, 288);

struct RenderedVideo {
  const char *scene; // nullptr: translations within 3 px
  int quantizer;
  int references = 1;
};

void measure_scenes(bool quick, std::vector<VectorRow> &rows) {
  constexpr int kFrames = 8;
  constexpr std::size_t kSettling = 4; // frames from the key frame on
  const std::vector<Scene> scenes = hard_scenes(kSide);
  for (const auto &[name, quantizer, references] : {RenderedVideo{nullptr, 20},
                                                    {nullptr, 30},
                                                    {nullptr, 30, 3},
                                                    {nullptr, 40},
                                                    {"rotation", 30},
                                                    {"two motions", 30},
                                                    {"still noise 1.5", 30}}) {
    const std::string video = std::string(name ? name : "translation") + ", quantizer " +
                              std::to_string(quantizer) +
                              (references > 1 ? ", three references" : "");
    Random random(seed_of("vectors " + video));
    Contest contest(video);
    double decoding = 0;
    const int count = quick ? 2 : 24;
    for (int i = 0; i < count; ++i) {
      const Movie movie =
          name ? scene_named(scenes, name).make(random) : uniform_translation(random, 3);
      std::vector<cv::Mat> clip;
      clip.reserve(kFrames);
      for (int time = 0; time < kFrames; ++time)
        clip.push_back(embed(expose(movie, time, random), kFrame));
      const H264Stream stream = encode_h264(clip, quantizer, references);
      const std::vector<Decoded> frames = decode(stream);
      decoding += export_time(stream, frames.size(), quick) / count;
      const cv::Point place((kFrame.width - kSide) / 2, (kFrame.height - kSide) / 2);
      for (std::size_t at = kSettling; at < frames.size(); ++at)
        contest.compare(frames[at - 1], frames[at], place, movie.velocity);
    }
    contest.finish(decoding, rows);
  }
}

// A dense peer at its finest scale stands for the truth of a clip.
std::unique_ptr<Method> reference() {
  for (const Configuration &c : peer_configurations(false))
    if (c.method == "DIS medium" && c.parameters == "finest-scale=0")
      return c.make();
  throw std::runtime_error("there is no reference for clips");
}

void measure_clip(const std::filesystem::path &file, bool quick, std::vector<VectorRow> &rows) {
  constexpr std::size_t kMost = 100; // frames
  constexpr int kRaster = 60;        // px
  const H264Stream stream = read_h264(file, quick ? 10 : kMost);
  if (stream.empty())
    return; // another codec
  const std::vector<Decoded> frames = decode(stream);
  const auto truth = reference();
  const std::size_t step = quick ? 5 : 10;
  const cv::Size size = frames.empty() ? cv::Size() : frames.front().luma.size();
  Contest contest(file.stem().string() + ", " + std::to_string(size.width) + "×" +
                  std::to_string(size.height));
  for (std::size_t at = step; at < frames.size(); at += step)
    for (int y = kSide; y + 2 * kSide <= size.height; y += kRaster)
      for (int x = kSide; x + 2 * kSide <= size.width; x += kRaster) {
        const Task task{frames[at - 1].luma,
                        frames[at].luma,
                        {(x + kSide / 2.0) / size.width, (y + kSide / 2.0) / size.height},
                        kSide};
        contest.compare(frames[at - 1], frames[at], {x, y}, truth->measure(task).velocity);
      }
  contest.finish(export_time(stream, frames.size(), quick), rows);
}

} // namespace

std::string why_no_motion_vectors() {
  return has_h264_encoder() ? "" : "x264enc is not installed";
}

std::vector<VectorRow> measure_vectors(bool quick,
                                       const std::optional<std::filesystem::path> &clips) {
  std::vector<VectorRow> rows;
  if (!why_no_motion_vectors().empty())
    return rows;
  measure_scenes(quick, rows);
  if (clips)
    for (const std::filesystem::path &file : videos_in(*clips))
      measure_clip(file, quick, rows);
  return rows;
}

#endif

} // namespace lab
