// SPDX-License-Identifier: LGPL-2.1-or-later
// What the window shows while a film plays.
#include "window/window.hpp"

#include "window/appearance.hpp"
#include "window/session-text.hpp"
#include "window/widgets.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <utility>

namespace program {
namespace {

using namespace std::chrono_literals;
using haptic::GCharPtr;
using Clock = std::chrono::steady_clock;

constexpr guint kTick = 200; // ms
constexpr auto kStall = 10s; // without a frame
constexpr auto kNote = 3s;
constexpr auto kBetweenSeeks = 100ms;

std::string time_text(double seconds) {
  const int whole = static_cast<int>(std::max(0.0, seconds));
  const int hours = whole / 3600;
  const GCharPtr text(hours ? g_strdup_printf("%d:%02d:%02d", hours, whole / 60 % 60, whole % 60)
                            : g_strdup_printf("%d:%02d", whole / 60, whole % 60));
  return text.get();
}

std::string number(const char *format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return std::isfinite(value) ? text : "–";
}

// A label that is set only when it changes, so that a screen reader does not repeat it.
void set_text(GtkWidget *label, const std::string &text) {
  if (text != gtk_label_get_text(GTK_LABEL(label)))
    gtk_label_set_text(GTK_LABEL(label), text.c_str());
}

} // namespace

Window::Window(GtkApplication *application, const WindowOptions &options)
    : player_(*this), recorder_([this](const std::string &sentence) {
        update_sensitivity();
        add_info(sentence);
      }),
      settings_(Settings::load()), on_close_(options.on_close), verbose_(options.verbose),
      start_(options.start), remembers_strength_(!options.strength_given),
      remembers_law_(!options.law_given) {
  player_.setup = options.setup;
  if (!options.strength_given && settings_.alpha > 0)
    player_.setup.alpha = settings_.alpha;
  if (!options.law_given)
    player_.setup.law = settings_.law;
  player_.setup.region = static_cast<guint>(settings_.region);
  player_.setup.drawing = settings_.drawing;
  player_.setup.volume = settings_.volume;
  player_.setup.muted = settings_.muted;
  set_appearance(settings_.appearance);
  make_window(application);
  add_actions();
  update_sensitivity();
  timer_ = g_timeout_add(
      kTick, [](gpointer self) noexcept -> gboolean { return static_cast<Window *>(self)->tick(); },
      this);
}

Window::~Window() {
  gdk_event_handler_set([](GdkEvent *event, gpointer) { gtk_main_do_event(event); }, nullptr,
                        nullptr);
  g_source_remove(timer_);
  if (drawing_film_)
    g_subprocess_send_signal(drawing_film_.get(), SIGTERM); // it leaves nothing behind
  save_settings();
  chooser_.reset();
  gtk_widget_hide(window_);
  player_.release(); // finish() may wait for seconds, while the film plays on
  recorder_.finish();
  player_.close();
  g_object_unref(camera_menu_);
  g_object_unref(device_menu_);
  g_object_unref(menu_);
  g_object_unref(sound_menu_);
  gtk_widget_destroy(window_);
  on_close_();
}

void Window::save_settings() {
  if (remembers_strength_)
    settings_.alpha = player_.setup.alpha;
  if (remembers_law_)
    settings_.law = player_.setup.law;
  settings_.region = static_cast<int>(player_.setup.region);
  settings_.drawing = player_.setup.drawing;
  settings_.volume = player_.setup.volume;
  settings_.muted = player_.setup.muted;
  if (!settings_.save())
    std::fprintf(stderr,
                 "feeling-wind: the settings cannot be saved; check the permissions of %s\n",
                 g_get_user_config_dir());
}

void Window::open(const Source &source) {
  hide_info();
  end_recording_before("another film");
  sized_ = false;
  last_sign_ = Clock::now();
  chart_.clear();
  session_ = {};
  player_.setup.direction = player_.setup.deinterlace = "auto";
  gtk_header_bar_set_title(GTK_HEADER_BAR(header_), source.title.c_str());
  if (source.kind == SourceKind::file) {
    const GCharPtr folder(g_path_get_dirname(source.name.c_str()));
    settings_.folder = folder.get();
  }
  player_.open(source);
  update_sensitivity();
}

// ---- from the player ----------------------------------------------------------------------------

void Window::on_widget(GtkWidget *video) {
  end_recording_before("the film is opened again"); // its pads are those of the pipeline before
  newest_ = {};
  mark_choices(); // the player replaces a device that cannot be opened
  if (video_)
    gtk_container_remove(GTK_CONTAINER(film_box_), video_);
  video_ = video;
  set_accessible_name(video, "Film");
  g_signal_connect_after(video, "draw",
                         G_CALLBACK(+[](GtkWidget *widget, cairo_t *cairo, gpointer self) noexcept {
                           static_cast<Window *>(self)->draw_over_film(cairo, widget);
                           return gboolean{FALSE};
                         }),
                         this);
  g_signal_connect(video, "destroy", G_CALLBACK(gtk_widget_destroyed), &video_);
  gtk_box_pack_start(GTK_BOX(film_box_), video, TRUE, TRUE, 0);
  gtk_widget_show(video);
  gtk_stack_set_visible_child_name(GTK_STACK(pages_), "film");
  gtk_widget_grab_focus(video);
}

void Window::on_first_frame() {
  if (!sized_)
    size_to_film();
  sized_ = true;
  if (!devices_)
    devices_ = std::make_unique<Devices>([this] { list_cameras(); });
  list_cameras();
  update_sensitivity();
  print(number("first frame after %.2f s",
               std::chrono::duration<double>(Clock::now() - start_).count()));
}

void Window::on_failure(const std::string &sentence) {
  std::fprintf(stderr, "feeling-wind: %s\n", sentence.c_str());
  recorder_.stop();
  session_ = {};
  chart_.clear();
  gtk_stack_set_visible_child_name(GTK_STACK(pages_), "empty");
  gtk_header_bar_set_title(GTK_HEADER_BAR(header_), "Feeling Wind");
  update_sensitivity();
  show_info(sentence, GTK_MESSAGE_ERROR);
}

void Window::on_note(const std::string &sentence) {
  std::fprintf(stderr, "feeling-wind: %s\n", sentence.c_str());
  show_info(sentence, GTK_MESSAGE_WARNING);
}

void Window::on_session(const Session &session) {
  session_ = session;
  print("state " + session.state + " " + session.reason);
}

void Window::on_reading(const Reading &reading) {
  if (reading.hold != newest_.hold) {
    const std::string words(haptic::hold_words(reading.hold));
    print("hold " + words);
    // A latch ends with it, and takes the words beside the light along.
    if (reading.hold == haptic::HoldState::lost || reading.hold == haptic::HoldState::refused)
      show_note(words);
  }
  newest_ = reading;
  last_sign_ = Clock::now();
  chart_.add(reading);
  gtk_widget_queue_draw(strip_);
}

void Window::on_end() {
  end_recording_before("the end of the film");
}

void Window::on_buffering(int percent) {
  last_sign_ = Clock::now();
  show_note(percent < 100 ? "loading, " + std::to_string(percent) + " %" : "");
}

// ---- five times a second ------------------------------------------------------------------------

gboolean Window::tick() {
  if (!devices_ && Clock::now() - start_ > 1s) {
    devices_ = std::make_unique<Devices>([this] { list_cameras(); });
    list_cameras();
  }
  if (wanted_position_ && Clock::now() - last_seek_ > kBetweenSeeks)
    seek_to(*wanted_position_);
  if (Clock::now() - last_note_ > kNote)
    gtk_widget_hide(note_);
  update_time();
  update_force();
  check_stall();
  check_drawing();
  if (gtk_toggle_button_get_active(GTK_TOGGLE_BUTTON(device_button_)))
    list_devices();
  return G_SOURCE_CONTINUE;
}

void Window::update_time() {
  const Playback *playback = player_.playback();
  const double now = playback ? static_cast<double>(playback->position()) / kSecond : 0;
  const double end = playback ? static_cast<double>(playback->duration()) / kSecond : 0;
  set_text(time_, time_text(now));
  set_text(duration_, end > 0 ? time_text(end) : playback && player_.has_frame() ? "live" : "0:00");
  if (!playback)
    gtk_range_set_value(GTK_RANGE(position_), 0);
  if (end > 0 && !wanted_position_) {
    gtk_range_set_range(GTK_RANGE(position_), 0, end);
    gtk_range_set_value(GTK_RANGE(position_), now);
  }
  gtk_widget_set_sensitive(position_, end > 0 && player_.can_seek());
  const std::string rate = number("%g×", playback ? playback->rate() : 1);
  set_text(rate_, rate);
  set_accessible_name(rate_, ("Speed " + rate).c_str());
  const bool plays = playback && !playback->paused();
  set_icon(play_button_, plays ? "media-playback-pause-symbolic" : "media-playback-start-symbolic");
  describe(play_button_, plays ? "Pause" : "Play", "play");
  describe(record_button_, recorder_.is_recording() ? "End the recording" : "Record", "record");
  set_icon(mute_button_,
           player_.setup.muted ? "audio-volume-muted-symbolic" : "audio-volume-high-symbolic");
  set_icon(record_button_,
           recorder_.is_recording() ? "media-playback-stop-symbolic" : "media-record-symbolic");
  std::string subtitle;
  if (recorder_.is_recording())
    subtitle = "● Recording " +
               time_text(std::chrono::duration<double>(Clock::now() - recording_since_).count());
  gtk_header_bar_set_subtitle(GTK_HEADER_BAR(header_),
                              subtitle.empty() ? nullptr : subtitle.c_str());
}

void Window::update_force() {
  std::string text;
  if (player_.is_open()) {
    const bool begun = player_.has_frame() || session_.state == "armed";
    text =
        begun ? session_sentence(session_, player_.is_armed()) : "Force off: no frame has come yet";
    if (session_.state == "armed")
      text += number(", %.2f N", std::hypot(newest_.fx, newest_.fy)) + limit_text();
    if (newest_.hold != haptic::HoldState::none)
      text.append(" (").append(haptic::hold_words(newest_.hold)).append(")");
  }
  set_text(force_text_, text);
  const bool released = player_.is_open() && !player_.is_armed(); // as toggle_force() decides
  const char *label = released ? "Switch force on" : "Switch force off";
  if (g_strcmp0(gtk_button_get_label(GTK_BUTTON(arm_button_)), label) != 0)
    gtk_button_set_label(GTK_BUTTON(arm_button_), label);
  set_accessible_name(arm_button_, label);
  gtk_widget_queue_draw(light_);
}

std::string Window::limit_text() {
  const std::string limit = limits_.update(player_.statistics().get());
  const std::string text = limit.empty() ? "" : "limited by " + limit;
  if (text != std::exchange(limit_text_, text))
    print(text);
  return text.empty() ? "" : ", " + text;
}

void Window::check_stall() {
  const Playback *playback = player_.playback();
  const bool stalls = playback && !playback->paused() && Clock::now() - last_sign_ >= kStall;
  if (!stalls && stall_shown_)
    hide_info();
  if (!stalls || stall_shown_)
    return;
  show_info("Nothing has come from “" + player_.source().title +
                "” for 10 s. Wait, or open another film.",
            GTK_MESSAGE_WARNING, true);
}

void Window::check_drawing() {
  if (!drawing_film_ || g_subprocess_get_identifier(drawing_film_.get()))
    return;
  drawing_film_.reset();
  demonstration_drawn_ = true;
  play_demonstration();
  demonstration_drawn_ = false;
}

void Window::list_cameras() {
  g_menu_remove_all(camera_menu_);
  for (const ListedDevice &camera : devices_->cameras())
    g_menu_append(camera_menu_, camera.title.c_str(), ("win.camera::" + camera.name).c_str());
  if (g_menu_model_get_n_items(G_MENU_MODEL(camera_menu_)) == 0)
    g_menu_append(camera_menu_, "No camera is plugged in", "win.none");
}

void Window::list_devices() {
  if (!devices_)
    return;
  static std::vector<ListedDevice> shown;
  const std::vector<ListedDevice> devices = devices_->haptic_devices();
  if (devices == shown)
    return;
  shown = devices;
  g_menu_remove_all(device_menu_);
  for (const ListedDevice &device : devices) {
    const std::string title =
        device.problem.empty() ? device.title : device.title + ": " + device.problem;
    g_menu_append(device_menu_, title.c_str(),
                  device.problem.empty() ? ("win.device::" + device.name).c_str() : "win.none");
  }
}

// When the menu is opened.
void Window::list_sound_devices() {
  if (!devices_)
    return;
  g_menu_remove_all(sound_menu_);
  for (const ListedDevice &device : devices_->sound_devices()) {
    GMenuItem *item = g_menu_item_new(device.title.c_str(), nullptr);
    g_menu_item_set_action_and_target(item, "win.array-sink", "s", device.name.c_str());
    g_menu_append_item(sound_menu_, item);
    g_object_unref(item);
  }
}

// ---- shared by the actions ----------------------------------------------------------------------

void Window::seek_to(double seconds) {
  Playback *playback = player_.playback();
  wanted_position_.reset();
  if (!playback)
    return;
  if (Clock::now() - last_seek_ < kBetweenSeeks) { // the slider moves faster than a film can
    wanted_position_ = seconds;
    return;
  }
  if (!player_.can_seek())
    return show_note("this film cannot be sought in");
  end_recording_before("seeking");
  last_seek_ = Clock::now();
  show_note(playback->seek_to(static_cast<gint64>(seconds * kSecond))
                ? "at " + time_text(seconds)
                : "this film cannot be sought in");
}

void Window::end_recording_before(const char *what) {
  if (!recorder_.is_recording())
    return;
  recorder_.stop();
  show_note(std::string("the recording ends before ") + what);
}

// For --verbose.
void Window::print(const std::string &text) const {
  if (!verbose_ || text.empty())
    return;
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

void Window::show_note(const std::string &text) {
  set_text(note_, text);
  gtk_widget_set_visible(note_, !text.empty());
  last_note_ = Clock::now();
  print(text);
}

void Window::show_info(const std::string &sentence, GtkMessageType type, bool offers_waiting) {
  gtk_info_bar_set_message_type(GTK_INFO_BAR(info_), type);
  set_text(info_text_, sentence);
  stall_shown_ = offers_waiting;
  gtk_widget_set_visible(wait_button_, offers_waiting);
  gtk_widget_set_visible(other_button_, offers_waiting || type == GTK_MESSAGE_ERROR);
  gtk_widget_show(info_);
  print(sentence);
}

// Keeps an error or a warning that is shown.
void Window::add_info(const std::string &sentence) {
  if (!gtk_widget_get_visible(info_) || stall_shown_ ||
      gtk_info_bar_get_message_type(GTK_INFO_BAR(info_)) == GTK_MESSAGE_INFO)
    return show_info(sentence, GTK_MESSAGE_INFO);
  set_text(info_text_, gtk_label_get_text(GTK_LABEL(info_text_)) + (" " + sentence));
  print(sentence);
}

void Window::hide_info() {
  stall_shown_ = false;
  gtk_widget_hide(info_);
}

void Window::update_sensitivity() {
  const bool open = player_.is_open();
  for (const char *action : {"play", "back", "forward", "begin", "slower", "faster", "reverse",
                             "rotate", "deinterlace", "record", "arm", "hold", "calibrate"})
    if (GAction *found = g_action_map_lookup_action(G_ACTION_MAP(window_), action))
      g_simple_action_set_enabled(G_SIMPLE_ACTION(found), open);
}

} // namespace program
