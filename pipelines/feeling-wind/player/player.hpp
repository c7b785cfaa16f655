// SPDX-License-Identifier: LGPL-2.1-or-later
// The pipeline of the program: frames to the window and to the hand, sound to the loudspeaker.
//
//   source ! videoconvert ! deinterlace ! videoflip ! roitracker ! tee
//       tee. ! queue ! videoconvert ! hapticoverlay ! gtksink
//       tee. ! queue ! velocityavg ! hapticsink
//       tee. ! queue ! velocityavg ! hapticarray ! … (array-output.hpp), if there is an array
//   source. ! queue ! audioconvert ! audioresample ! volume ! autoaudiosink
#pragma once

#include "glue/gst-raii.hpp"
#include "player/array-output.hpp"
#include "player/playback.hpp"
#include "player/reading.hpp"
#include "player/source.hpp"

#include <algorithm>
#include <chrono>
#include <gtk/gtk.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace program {

/// What a pipeline starts with.
struct Setup {
  std::string device = "sim";       ///< of hapticsink
  std::vector<std::string> options; ///< OPTION=VALUE of hapticsink
  double alpha = 0.04;              ///< s/px, strength; docs/force.md says why not the paper's
  guint region = 0;                 ///< px, 0: the default
  std::string law = "arctan";
  std::string direction = "auto";   ///< video-direction of videoflip
  std::string deinterlace = "auto"; ///< mode of deinterlace
  bool drawing = true;              ///< of hapticoverlay
  double volume = 1;                ///< 0..1
  bool muted = false;
  ArraySetup array;
  std::string touch; ///< table of reliefmap; empty: no surface

  /// A device that exerts a force.
  bool is_real() const { return device != "sim" && device != "none"; }
  /// A hand or a script points, else the mouse.
  bool has_hand() const {
    return is_real() || std::ranges::any_of(options, [](const std::string &option) {
             return option.starts_with("sim-hand=");
           });
  }
};

/// Sets a property of hapticsink. Returns why OPTION=VALUE cannot be set, in a sentence. Empty if
/// it is set.
std::string set_option(GstElement *sink, const std::string &option);

/// What the message haptic-session of hapticsink says.
struct Session {
  std::string state = "closed";
  std::string reason; ///< holds, separated by commas
  std::string device;
};

/// Hears from the player, in the main thread.
class PlayerClient {
public:
  virtual ~PlayerClient() = default;
  /// A new pipeline shows its frames here.
  virtual void on_widget(GtkWidget *video) = 0;
  virtual void on_first_frame() = 0;
  /// The film is closed.
  virtual void on_failure(const std::string &sentence) = 0;
  /// The film goes on.
  virtual void on_note(const std::string &sentence) = 0;
  virtual void on_session(const Session &session) = 0;
  virtual void on_reading(const Reading &reading) = 0;
  /// The end, before the film starts again.
  virtual void on_end() = 0;
  virtual void on_buffering(int percent) = 0;
};

/// Main thread only.
class Player {
public:
  explicit Player(PlayerClient &client) : client_(client) {}
  ~Player() { close(); }
  Player(const Player &) = delete;
  Player &operator=(const Player &) = delete;

  /// Closes what was open. Failures arrive at the client.
  void open(const Source &source);
  /// Opens the same source again, at the same position, with a changed setup.
  void open_again();
  void close();
  bool can_seek() const;
  bool is_open() const { return pipeline_ != nullptr; }
  bool has_frame() const { return has_frame_; }
  const Source &source() const { return source_; }

  /// Nothing while no film is open.
  Playback *playback() { return playback_ ? &*playback_ : nullptr; }

  /// What changes while a film runs: set here, then call apply_setup(). Device, options, array and
  /// deinterlacing need open_again().
  Setup setup;
  void apply_setup();

  void arm();
  /// Also of the pipelines that follow, until arm().
  void release();
  void calibrate() { emit("calibrate"); }
  /// Takes what is under the pointer now and holds it without a press. A thing that is lost, with
  /// its scene or by a seek, is let go, and so is one that cannot be taken.
  void latch(bool holds);
  bool is_latched() const { return latched_; }
  bool is_armed() const;
  double max_force() const;
  /// Of hapticsink; null while no film is open.
  haptic::StructurePtr statistics() const;
  int frame_width() const;
  /// It may be shorter than the film, and then it has ended.
  bool has_sound() const;
  /// The last frame in the window, or nothing.
  haptic::SamplePtr last_frame() const;
  void draw_array(cairo_t *cairo, double width, double height) const {
    array_.draw(cairo, width, height);
  }
  /// An element by its name in player.cpp, or nothing.
  haptic::ElementPtr element(const char *name) const;

private:
  bool build(bool with_sound);
  bool configure_sink();
  std::string numbered(const std::string &option) const;
  void add_array();
  std::string direction() const;
  void start(bool paused = false);
  void begin_again();
  void connect_source(GstElement *source);
  void fail(const std::string &sentence);
  void handle_message(GstMessage *message);
  void handle_element_message(GstMessage *message);
  void handle_error(GstMessage *message);
  void handle_warning(GstMessage *message);
  void hear_session(const GstStructure *fields);
  void add_reading(const GstStructure *fields);
  void note_frame();
  void emit(const char *signal);
  bool is_inside(GstMessage *message, const char *name) const;

  // In streaming threads.
  void on_pad(GstPad *pad);
  void on_no_more_pads();
  void on_type(const GstCaps *caps);
  void post(const char *what);
  void add_sound(GstPad *pad);

  PlayerClient &client_;
  Source source_;
  haptic::ElementPtr pipeline_;
  std::optional<Playback> playback_;
  ArrayOutput array_;
  guint watch_ = 0;
  bool released_ = false; // by a person
  int pipelines_ = 0;     // since the program began
  bool with_sound_ = true;
  bool seekable_ = true;     // as far as is known
  bool has_frame_ = false;   // of this pipeline
  bool had_frame_ = false;   // of this source
  bool sound_noted_ = false; // once, not with each film
  bool latched_ = false;
  gint64 start_at_ = 0; // ns, position to begin at
  std::string missing_; // sentence about the plugins that are missing
  std::chrono::steady_clock::time_point last_reading_{};
  bool type_seen_ = false; // streaming thread of the source
};

} // namespace program
