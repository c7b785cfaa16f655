// SPDX-License-Identifier: LGPL-2.1-or-later
// Records film, sound and haptic track of a player into one file, as pipelines/record.sh does. The
// recording is a pipeline of its own: its errors do not stop the film.
#pragma once

#include "player/player.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace program {

/// Main thread only.
class Recorder {
public:
  /// `on_end` hears in a sentence how a recording ended.
  explicit Recorder(std::function<void(const std::string &)> on_end) : on_end_(std::move(on_end)) {}
  ~Recorder() { finish(); }
  Recorder(const Recorder &) = delete;
  Recorder &operator=(const Recorder &) = delete;

  /// `path` ends in .ts (track as KLV) or .mkv (track as text). Returns why it cannot record, or an
  /// empty text. Never waits.
  std::string start(const Player &player, const std::string &path);
  /// Completes the file; `on_end` is called later.
  void stop();
  /// Completes the file and waits for it.
  void finish();
  /// Until stop().
  bool is_recording() const { return recording_; }

private:
  struct Shared;
  struct Tap;

  void tap(const Player &player, const char *element, const char *pad, const char *input);
  void handle_message(GstMessage *message);
  void end(const std::string &sentence);

  std::function<void(const std::string &)> on_end_;
  haptic::ElementPtr pipeline_;
  std::vector<std::pair<haptic::PadPtr, gulong>> probes_;
  std::shared_ptr<Shared> shared_;
  std::string path_;
  guint watch_ = 0;
  bool recording_ = false;
};

} // namespace program
