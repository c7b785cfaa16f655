// SPDX-License-Identifier: LGPL-2.1-or-later
// Pauses a pipeline, changes its speed and direction, seeks, and starts it again at its end.
#pragma once

#include <chrono>
#include <gst/gst.h>
#include <optional>

namespace program {

/// Main thread only.
class Playback {
public:
  /// `pipeline` must outlive this object.
  explicit Playback(GstElement *pipeline) : pipeline_(pipeline) {}

  /// These return false if the pipeline refuses.
  bool start(bool paused) { return set_paused(paused); }
  bool toggle_pause() { return set_paused(!paused_); }
  bool slower() { return play_at(rate_ / 2); }
  bool faster() { return play_at(rate_ * 2); }
  bool reverse() { return play_at(-rate_); }
  /// Seeks to `position`, ns, within the film.
  bool seek_to(gint64 position);
  /// Seeks to the beginning, or to the end when it plays backwards.
  bool restart();
  /// Of the pipeline's message ASYNC_DONE: begins the seek that has waited for the one before. Two
  /// at once make tsdemux fail.
  void end_seek();
  /// While held, for example to fill a buffer, the pipeline is paused whatever the user wants.
  bool set_held(bool held);

  double rate() const { return rate_; }
  bool paused() const { return paused_; }
  /// ns, or -1 if unknown.
  gint64 position() const;
  gint64 duration() const;
  bool can_seek() const;

private:
  bool set_paused(bool paused);
  bool update_state();
  bool play_at(double rate);
  struct Target {
    double rate;
    gint64 position; // ns
  };
  bool seek(const Target &target);

  GstElement *pipeline_;
  double rate_ = 1;
  bool paused_ = true;
  bool held_ = false;
  std::optional<std::chrono::steady_clock::time_point> seeking_since_;
  std::optional<Target> waiting_; // the newest
};

} // namespace program
