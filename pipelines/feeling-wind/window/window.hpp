// SPDX-License-Identifier: LGPL-2.1-or-later
// The window: film, curves, controls, and the actions of keys.hpp.
#pragma once

#include "player/devices.hpp"
#include "player/player.hpp"
#include "player/recorder.hpp"
#include "window/session-text.hpp"
#include "window/settings.hpp"
#include "window/strip-chart.hpp"

#include <chrono>
#include <functional>
#include <gtk/gtk.h>
#include <memory>
#include <optional>
#include <string>

namespace program {

inline constexpr double kSecond = GST_SECOND; ///< ns

/// What the command line asks for.
struct WindowOptions {
  Setup setup;
  bool strength_given = false; ///< setup.alpha is not to be taken from the settings
  bool law_given = false;      ///< the same of setup.law
  bool verbose = false;        ///< print what happens
  std::chrono::steady_clock::time_point start;
  std::function<void()> on_close; ///< the window is deleted
};

/// Main thread only. Deletes itself when the window is closed.
class Window final : public PlayerClient {
public:
  Window(GtkApplication *application, const WindowOptions &options);
  Window(const Window &) = delete;
  Window &operator=(const Window &) = delete;

  void open(const Source &source);
  /// Also while a dialog is shown. Completes a recording, lets the force fade, deletes the window.
  void quit() { delete this; }

private:
  ~Window() override;

  // PlayerClient
  void on_widget(GtkWidget *video) override;
  void on_first_frame() override;
  void on_failure(const std::string &sentence) override;
  void on_note(const std::string &sentence) override;
  void on_session(const Session &session) override;
  void on_reading(const Reading &reading) override;
  void on_end() override;
  void on_buffering(int percent) override;

  // `handler`: a function whose last argument is the window.
  template <typename Handler>
  void connect(gpointer object, const char *signal, Handler handler) {
    g_signal_connect(object, signal, G_CALLBACK(+handler), this);
  }

  // window-layout.cpp
  void make_window(GtkApplication *application);
  GtkWidget *make_overlay();
  GtkWidget *make_header();
  GtkWidget *make_info_bar();
  GtkWidget *make_empty_page();
  GtkWidget *make_strip();
  GtkWidget *make_film_controls();
  GtkWidget *make_force_controls();
  void connect_events();
  void fill_menu();
  void add_array_menu();
  void size_to_film();
  GdkRectangle work_area();
  void arrange();
  void draw_over_film(cairo_t *cairo, GtkWidget *video);
  gboolean handle_key(GdkEventKey *event);
  void filter_event(GdkEvent *event);
  void handle_drop(GtkSelectionData *data);
  gboolean handle_scroll_to(double seconds);

  // window-actions.cpp
  void add_actions();
  void add_choices();
  template <auto kChoose>
  void add_choice(const char *name, const std::string *state);
  void choose_film();
  void show_chooser(GtkFileChooserNative *dialog, std::function<void(const std::string &)> chosen);
  void open_file(const std::string &path);
  void record_into(const std::string &chosen);
  void choose_url();
  void toggle_pause();
  void seek_by(double seconds);
  void rotate();
  void next_deinterlacing();
  void toggle_mute();
  void change_volume(double step);
  void toggle_recording();
  void toggle_force();
  void force_off();
  void toggle_hold();
  void scale_strength(double factor);
  void scale_region(double factor);
  void default_region();
  void next_law();
  void calibrate();
  void toggle_fullscreen();
  void toggle_drawing();
  void toggle_curves();
  void next_appearance();
  void show_keys();
  void show_about();
  void play_demonstration();
  void choose_device(const std::string &name);
  void choose_array(const std::string &layout);
  void choose_array_sink(const std::string &sink);
  void mark_choices();
  void change_rate(bool (Playback::*change)());

  // window.cpp
  gboolean tick();
  void update_time();
  void update_force();
  std::string limit_text();
  void check_stall();
  void check_drawing();
  void list_cameras();
  void list_devices();
  void list_sound_devices();
  void seek_to(double seconds);
  void end_recording_before(const char *what);
  void print(const std::string &text) const;
  void show_note(const std::string &text);
  void show_info(const std::string &sentence, GtkMessageType type, bool offers_waiting = false);
  void add_info(const std::string &sentence);
  void hide_info();
  void update_sensitivity();
  void save_settings();

  Player player_;
  Recorder recorder_;
  Settings settings_;
  StripChart chart_;
  std::unique_ptr<Devices> devices_;
  const std::function<void()> on_close_;
  const bool verbose_;
  const std::chrono::steady_clock::time_point start_;

  GtkWidget *window_ = nullptr;
  GtkWidget *header_ = nullptr, *info_ = nullptr, *info_text_ = nullptr, *wait_button_ = nullptr,
            *other_button_ = nullptr;
  GtkWidget *pages_ = nullptr, *film_box_ = nullptr, *video_ = nullptr, *strip_ = nullptr;
  GtkWidget *camera_button_ = nullptr, *device_button_ = nullptr, *menu_button_ = nullptr;
  GtkWidget *record_button_ = nullptr, *play_button_ = nullptr, *mute_button_ = nullptr;
  GtkWidget *time_ = nullptr, *duration_ = nullptr, *position_ = nullptr, *rate_ = nullptr;
  GtkWidget *film_controls_ = nullptr, *leave_button_ = nullptr;
  GtkWidget *light_ = nullptr, *force_text_ = nullptr, *arm_button_ = nullptr, *note_ = nullptr;
  GtkWidget *demonstration_button_ = nullptr;
  GMenu *camera_menu_ = nullptr, *device_menu_ = nullptr, *menu_ = nullptr, *sound_menu_ = nullptr;
  guint timer_ = 0;
  struct Destroy {
    void operator()(GtkFileChooserNative *dialog) const noexcept {
      gtk_native_dialog_destroy(GTK_NATIVE_DIALOG(dialog));
      g_object_unref(dialog);
    }
  };
  std::unique_ptr<GtkFileChooserNative, Destroy> chooser_; // while it is shown
  std::function<void(const std::string &)> chosen_;        // called with what it chose
  using Process = std::unique_ptr<GSubprocess, decltype(&g_object_unref)>;
  Process drawing_film_{nullptr, g_object_unref}; // wind-film, until it ends
  bool demonstration_drawn_ = false;              // it has just ended

  bool remembers_strength_; // not one of the command line
  bool remembers_law_;      // not one of the command line
  Session session_;
  Reading newest_;
  LimitWatch limits_;
  std::string limit_text_;   // as last written
  bool stall_shown_ = false; // in the info bar
  bool sized_ = false;       // to the present film
  bool fullscreen_ = false;
  std::optional<double> wanted_position_;             // s, while the user drags
  std::chrono::steady_clock::time_point last_sign_{}; // of the film
  std::chrono::steady_clock::time_point last_seek_{}, last_note_{};
  std::chrono::steady_clock::time_point recording_since_{};
};

} // namespace program
