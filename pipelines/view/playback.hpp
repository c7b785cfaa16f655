// SPDX-License-Identifier: LGPL-2.1-or-later
// How a pipeline is played: paused, slower, faster, backwards, from its end back to its beginning.
#pragma once

#include <gst/gst.h>

namespace view {

/// The main thread only.
class Playback {
public:
  /// The pipeline outlives it.
  explicit Playback(GstElement *pipeline) : pipeline_(pipeline) {}

  /// False if the pipeline cannot.
  bool start() { return set_paused(false); }
  bool toggle_pause() { return set_paused(!paused_); }
  bool slower() { return play_at(rate_ / 2); }
  bool faster() { return play_at(rate_ * 2); }
  bool reverse() { return play_at(-rate_); }
  /// Once more, after the end has been reached.
  bool again();

  double rate() const { return rate_; }
  bool paused() const { return paused_; }

private:
  bool set_paused(bool paused);
  bool play_at(double rate);
  bool seek(double rate, gint64 position);

  GstElement *pipeline_;
  double rate_ = 1;
  bool paused_ = true;
};

} // namespace view
