// SPDX-License-Identifier: LGPL-2.1-or-later
// Pauses a pipeline, changes its speed and direction, and starts it again at its end.
#pragma once

#include <gst/gst.h>

namespace view {

/// Main thread only.
class Playback {
public:
  /// `pipeline` must outlive this object.
  explicit Playback(GstElement *pipeline) : pipeline_(pipeline) {}

  /// These return false if the pipeline refuses.
  bool start() { return set_paused(false); }
  bool toggle_pause() { return set_paused(!paused_); }
  bool slower() { return play_at(rate_ / 2); }
  bool faster() { return play_at(rate_ * 2); }
  bool reverse() { return play_at(-rate_); }
  /// Seeks to the beginning, or to the end when it plays backwards.
  bool restart();

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
