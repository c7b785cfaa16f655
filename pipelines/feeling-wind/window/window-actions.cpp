// SPDX-License-Identifier: LGPL-2.1-or-later
// What each action of the window does.
#include "format-text.hpp"
#include "samples/region-size.hpp"
#include "window/appearance.hpp"
#include "window/widgets.hpp"
#include "window/window.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glib/gstdio.h>
#include <utility>

namespace program {
namespace {

using haptic::ElementPtr;
using haptic::GCharPtr;

constexpr double kRegionStep = 1.25;
constexpr double kStrengthStep = 1.5;
constexpr double kWeakest = 1e-4; // s/px
constexpr double kStrongest = 10; // s/px, the largest alpha
constexpr double kStep = 5;       // s

// Returns the one after `value`, the first after the last.
std::string next_of(std::initializer_list<const char *> values, const std::string &value) {
  const auto *found = std::find(values.begin(), values.end(), value);
  return found == values.end() || found + 1 == values.end() ? *values.begin() : *(found + 1);
}

// Also by way of a link.
bool is_same_file(const std::string &one, const std::string &other) {
  GStatBuf a{}, b{};
  return g_stat(one.c_str(), &a) == 0 && g_stat(other.c_str(), &b) == 0 && a.st_dev == b.st_dev &&
         a.st_ino == b.st_ino;
}

void add_filter(GtkFileChooser *chooser, const char *name, const char *type) {
  GtkFileFilter *filter = gtk_file_filter_new();
  gtk_file_filter_set_name(filter, name);
  if (type)
    gtk_file_filter_add_mime_type(filter, type);
  else
    gtk_file_filter_add_pattern(filter, "*");
  gtk_file_chooser_add_filter(chooser, filter);
}

} // namespace

void Window::add_actions() {
  struct Action {
    const char *name;
    void (*run)(Window &);
  };
  static constexpr std::array kActions = {
      Action{"open", [](Window &w) { w.choose_film(); }},
      Action{"open-url", [](Window &w) { w.choose_url(); }},
      Action{"show-cameras", [](Window &w) { gtk_button_clicked(GTK_BUTTON(w.camera_button_)); }},
      Action{"play", [](Window &w) { w.toggle_pause(); }},
      Action{"back", [](Window &w) { w.seek_by(-kStep); }},
      Action{"forward", [](Window &w) { w.seek_by(kStep); }},
      Action{"begin", [](Window &w) { w.seek_to(0); }},
      Action{"slower", [](Window &w) { w.change_rate(&Playback::slower); }},
      Action{"faster", [](Window &w) { w.change_rate(&Playback::faster); }},
      Action{"reverse", [](Window &w) { w.change_rate(&Playback::reverse); }},
      Action{"rotate", [](Window &w) { w.rotate(); }},
      Action{"deinterlace", [](Window &w) { w.next_deinterlacing(); }},
      Action{"mute", [](Window &w) { w.toggle_mute(); }},
      Action{"quieter", [](Window &w) { w.change_volume(-0.1); }},
      Action{"louder", [](Window &w) { w.change_volume(0.1); }},
      Action{"record", [](Window &w) { w.toggle_recording(); }},
      Action{"arm", [](Window &w) { w.toggle_force(); }},
      Action{"release", [](Window &w) { w.force_off(); }},
      Action{"hold", [](Window &w) { w.toggle_hold(); }},
      Action{"weaker", [](Window &w) { w.scale_strength(1 / kStrengthStep); }},
      Action{"stronger", [](Window &w) { w.scale_strength(kStrengthStep); }},
      Action{"smaller-region", [](Window &w) { w.scale_region(1 / kRegionStep); }},
      Action{"larger-region", [](Window &w) { w.scale_region(kRegionStep); }},
      Action{"default-region", [](Window &w) { w.default_region(); }},
      Action{"next-law", [](Window &w) { w.next_law(); }},
      Action{"show-devices", [](Window &w) { gtk_button_clicked(GTK_BUTTON(w.device_button_)); }},
      Action{"calibrate", [](Window &w) { w.calibrate(); }},
      Action{"fullscreen", [](Window &w) { w.toggle_fullscreen(); }},
      Action{"drawing", [](Window &w) { w.toggle_drawing(); }},
      Action{"curves", [](Window &w) { w.toggle_curves(); }},
      Action{"menu", [](Window &w) { gtk_button_clicked(GTK_BUTTON(w.menu_button_)); }},
      Action{"keys", [](Window &w) { w.show_keys(); }},
      Action{"quit", [](Window &w) { w.quit(); }},
      Action{"appearance", [](Window &w) { w.next_appearance(); }},
      Action{"about", [](Window &w) { w.show_about(); }},
      Action{"demonstration", [](Window &w) { w.play_demonstration(); }},
  };
  for (const Action &action : kActions) {
    GSimpleAction *made = g_simple_action_new(action.name, nullptr);
    g_object_set_data(G_OBJECT(made), "action", const_cast<Action *>(&action));
    connect(made, "activate", [](GSimpleAction *which, GVariant *, Window *self) noexcept {
      const auto *found = static_cast<const Action *>(g_object_get_data(G_OBJECT(which), "action"));
      found->run(*self);
    });
    g_action_map_add_action(G_ACTION_MAP(window_), G_ACTION(made));
    g_object_unref(made);
  }
  for (const Key &key : kKeys)
    g_assert(g_action_map_lookup_action(G_ACTION_MAP(window_), key.action));
  add_choices();
}

// Its target is the name of what is chosen.
template <auto kChoose>
void Window::add_choice(const char *name, const std::string *state) {
  GSimpleAction *action = state ? g_simple_action_new_stateful(name, G_VARIANT_TYPE_STRING,
                                                               g_variant_new_string(state->c_str()))
                                : g_simple_action_new(name, G_VARIANT_TYPE_STRING);
  connect(action, "activate", [](GSimpleAction *, GVariant *chosen, Window *self) noexcept {
    (self->*kChoose)(g_variant_get_string(chosen, nullptr));
  });
  g_action_map_add_action(G_ACTION_MAP(window_), G_ACTION(action));
  g_object_unref(action);
}

void Window::add_choices() {
  add_choice<&Window::open_file>("camera", nullptr);
  add_choice<&Window::choose_device>("device", &player_.setup.device);
  add_choice<&Window::choose_array>("array", &player_.setup.array.layout);
  add_choice<&Window::choose_array_sink>("array-sink", &player_.setup.array.sink);
}

// ---- what is played -----------------------------------------------------------------------------

void Window::choose_film() {
  GtkFileChooserNative *dialog = gtk_file_chooser_native_new(
      "Open a film", GTK_WINDOW(window_), GTK_FILE_CHOOSER_ACTION_OPEN, "_Open", "_Cancel");
  add_filter(GTK_FILE_CHOOSER(dialog), "Films", "video/*");
  add_filter(GTK_FILE_CHOOSER(dialog), "All files", nullptr);
  if (!settings_.folder.empty())
    gtk_file_chooser_set_current_folder(GTK_FILE_CHOOSER(dialog), settings_.folder.c_str());
  show_chooser(dialog, [this](const std::string &path) { open_file(path); });
}

void Window::open_file(const std::string &path) {
  open(source_named(path, "/"));
}

// Without a main loop of its own: the window may be closed while the dialog is shown.
void Window::show_chooser(GtkFileChooserNative *dialog,
                          std::function<void(const std::string &)> chosen) {
  chooser_.reset(dialog);
  chosen_ = std::move(chosen);
  gtk_native_dialog_set_modal(GTK_NATIVE_DIALOG(dialog), TRUE);
  connect(dialog, "response", [](GtkNativeDialog *native, int response, Window *self) noexcept {
    const GCharPtr path(gtk_file_chooser_get_filename(GTK_FILE_CHOOSER(native)));
    self->chooser_.reset();
    if (response == GTK_RESPONSE_ACCEPT && path)
      self->chosen_(path.get());
  });
  gtk_native_dialog_show(GTK_NATIVE_DIALOG(dialog));
}

void Window::choose_url() {
  GtkWidget *dialog = gtk_dialog_new_with_buttons(
      "Open a URL", GTK_WINDOW(window_),
      static_cast<GtkDialogFlags>(GTK_DIALOG_MODAL | GTK_DIALOG_USE_HEADER_BAR |
                                  GTK_DIALOG_DESTROY_WITH_PARENT),
      "_Cancel", GTK_RESPONSE_CANCEL, "_Open", GTK_RESPONSE_ACCEPT, nullptr);
  gtk_dialog_set_default_response(GTK_DIALOG(dialog), GTK_RESPONSE_ACCEPT);
  GtkWidget *entry = gtk_entry_new();
  gtk_entry_set_activates_default(GTK_ENTRY(entry), TRUE);
  gtk_entry_set_placeholder_text(GTK_ENTRY(entry), "https:// or rtsp://");
  gtk_entry_set_width_chars(GTK_ENTRY(entry), 50);
  gtk_entry_set_input_purpose(GTK_ENTRY(entry), GTK_INPUT_PURPOSE_URL);
  set_accessible_name(entry, "URL of a film");
  GtkWidget *content = gtk_dialog_get_content_area(GTK_DIALOG(dialog));
  gtk_container_set_border_width(GTK_CONTAINER(content), 12);
  gtk_box_pack_start(GTK_BOX(content), entry, FALSE, FALSE, 0);
  g_object_set_data(G_OBJECT(dialog), "entry", entry);
  connect(dialog, "response", [](GtkDialog *shown, int response, Window *self) noexcept {
    const std::string url =
        gtk_entry_get_text(GTK_ENTRY(g_object_get_data(G_OBJECT(shown), "entry")));
    gtk_widget_destroy(GTK_WIDGET(shown));
    if (response == GTK_RESPONSE_ACCEPT && !url.empty())
      self->open_file(url);
  });
  gtk_widget_show_all(dialog);
}

// In the menus.
void Window::mark_choices() {
  const auto mark = [this](const char *name, const std::string &state) {
    GAction *action = g_action_map_lookup_action(G_ACTION_MAP(window_), name);
    g_simple_action_set_state(G_SIMPLE_ACTION(action), g_variant_new_string(state.c_str()));
  };
  mark("device", player_.setup.device);
  mark("array", player_.setup.array.layout);
  mark("array-sink", player_.setup.array.sink);
}

void Window::choose_device(const std::string &name) {
  end_recording_before("another device");
  player_.setup.device = name;
  mark_choices();
  player_.open_again();
  show_note(player_.setup.is_real() ? "hold the grip in the centre, then press s"
                                    : "the mouse points");
}

void Window::choose_array(const std::string &layout) {
  end_recording_before("another array");
  player_.setup.array.layout = layout;
  mark_choices();
  show_note(layout.empty() ? "without an array" : "array " + layout);
  player_.open_again();
}

void Window::choose_array_sink(const std::string &sink) {
  player_.setup.array.sink = sink;
  choose_array(player_.setup.array.layout);
}

// wind-film draws it the first time, in the user's cache. It writes under another name until it is
// complete.
void Window::play_demonstration() {
  const GCharPtr folder(g_build_filename(g_get_user_cache_dir(), "feeling-wind", nullptr));
  const GCharPtr film(g_build_filename(folder.get(), "wind.ts", nullptr));
  if (g_file_test(film.get(), G_FILE_TEST_EXISTS)) {
    if (demonstration_drawn_ && player_.is_open())
      return show_note("the film of a tree in the wind is drawn; the menu plays it");
    return open({SourceKind::file, film.get(), "A tree in the wind"});
  }
  if (std::exchange(demonstration_drawn_, false))
    return show_info("wind-film could not draw the film. Make room on the disk and try again.",
                     GTK_MESSAGE_ERROR);
  if (drawing_film_)
    return show_note("wind-film draws the film still");
  g_mkdir_with_parents(folder.get(), 0700);
  GError *error = nullptr;
  drawing_film_.reset(g_subprocess_new(G_SUBPROCESS_FLAGS_STDOUT_SILENCE, &error, "wind-film",
                                       film.get(), nullptr));
  const haptic::ErrorPtr owned(error);
  if (!drawing_film_)
    return show_info(std::string("wind-film does not start: ") + error->message, GTK_MESSAGE_ERROR);
  show_info("Drawing the film of a tree in the wind …", GTK_MESSAGE_INFO);
}

// ---- how it is played ---------------------------------------------------------------------------

void Window::toggle_pause() {
  if (Playback *playback = player_.playback()) {
    playback->toggle_pause();
    last_sign_ = std::chrono::steady_clock::now();
    show_note(playback->paused() ? "paused" : "playing");
  }
}

void Window::seek_by(double seconds) {
  if (const Playback *playback = player_.playback())
    seek_to(std::max(0.0, static_cast<double>(playback->position()) / kSecond + seconds));
}

void Window::change_rate(bool (Playback::*change)()) {
  Playback *playback = player_.playback();
  if (!playback)
    return;
  constexpr const char *kNot = "this video cannot be played at that speed or backwards";
  if (!player_.can_seek())
    return show_note(kNot);
  end_recording_before("another speed");
  const bool done = (playback->*change)();
  player_.apply_setup();
  show_note(done ? haptic::format_text("playing at %g times normal speed", playback->rate())
                 : kNot);
}

void Window::rotate() {
  end_recording_before("turning the film");
  player_.setup.direction = next_of({"auto", "90r", "180", "90l"}, player_.setup.direction);
  player_.apply_setup();
  show_note("rotation " + player_.setup.direction);
}

// A running deinterlace cannot ask for another format of frames.
void Window::next_deinterlacing() {
  std::string &mode = player_.setup.deinterlace;
  end_recording_before("deinterlacing");
  mode = next_of({"auto", "interlaced", "disabled"}, mode);
  player_.open_again();
  const char *shown = mode == "interlaced" ? "always" : mode == "disabled" ? "never" : "automatic";
  show_note(std::string("deinterlacing ") + shown);
}

void Window::toggle_mute() {
  player_.setup.muted = !player_.setup.muted;
  player_.apply_setup();
  show_note(player_.setup.muted ? "sound off" : "sound on");
}

void Window::change_volume(double step) {
  player_.setup.volume = std::clamp(player_.setup.volume + step, 0.0, 1.0);
  player_.apply_setup();
  show_note(haptic::format_text("sound at %.0f %%", 100 * player_.setup.volume));
}

void Window::toggle_recording() {
  if (recorder_.is_recording())
    return recorder_.stop();
  const Playback *playback = player_.playback();
  if (!playback || playback->rate() != 1)
    return show_note("only a film at normal speed can be recorded");
  GtkFileChooserNative *dialog =
      gtk_file_chooser_native_new("Record film and track", GTK_WINDOW(window_),
                                  GTK_FILE_CHOOSER_ACTION_SAVE, "_Record", "_Cancel");
  gtk_file_chooser_set_do_overwrite_confirmation(GTK_FILE_CHOOSER(dialog), TRUE);
  gtk_file_chooser_set_current_name(GTK_FILE_CHOOSER(dialog), "recording.mkv");
  if (const char *folder = g_get_user_special_dir(G_USER_DIRECTORY_VIDEOS))
    gtk_file_chooser_set_current_folder(GTK_FILE_CHOOSER(dialog), folder);
  show_chooser(dialog, [this](const std::string &path) { record_into(path); });
}

void Window::record_into(const std::string &chosen) {
  const bool named =
      g_str_has_suffix(chosen.c_str(), ".ts") || g_str_has_suffix(chosen.c_str(), ".mkv");
  const std::string path = named ? chosen : chosen + ".mkv";
  if (!player_.is_open())
    return;
  if (!named && g_file_test(path.c_str(), G_FILE_TEST_EXISTS)) // the dialog asked about `chosen`
    return show_info("There is a file " + path + ". Choose another name.", GTK_MESSAGE_ERROR);
  if (player_.source().kind == SourceKind::file && is_same_file(path, player_.source().name))
    return show_info("The film that plays is " + path + ". Choose another name.",
                     GTK_MESSAGE_ERROR);
  const std::string problem = recorder_.start(player_, path);
  if (!problem.empty())
    return show_info(problem, GTK_MESSAGE_ERROR);
  recording_since_ = std::chrono::steady_clock::now();
  show_note("recording into " + path);
}

// ---- the force ----------------------------------------------------------------------------------

void Window::toggle_force() {
  const bool armed = player_.is_armed();
  if (armed)
    player_.release();
  else
    player_.arm();
  show_note(armed ? "force off; s brings it back" : "force on");
}

// Escape: the force goes off, and never comes back by it.
void Window::force_off() {
  if (fullscreen_)
    gtk_window_unfullscreen(GTK_WINDOW(window_));
  if (!player_.is_open())
    return;
  player_.release();
  show_note("force off; s brings it back");
}

void Window::toggle_hold() {
  const bool holds = !player_.is_latched();
  player_.latch(holds);
  show_note(holds ? "held until h is pressed again" : "let go");
}

// alpha: how much force a slow motion gives; the greatest force stays.
void Window::scale_strength(double factor) {
  remembers_strength_ = true;
  player_.setup.alpha = std::clamp(player_.setup.alpha * factor, kWeakest, kStrongest);
  player_.apply_setup();
  show_note(haptic::format_text("strength (alpha) %.3g s/px", player_.setup.alpha));
}

void Window::scale_region(double factor) {
  const int width = player_.frame_width();
  if (width == 0)
    return;
  const double size =
      player_.setup.region ? player_.setup.region : haptic::default_region_side(width);
  constexpr int kSmallest = haptic::kSmallestRegion;
  player_.setup.region = static_cast<guint>(std::clamp(static_cast<int>(std::lround(size * factor)),
                                                       kSmallest, std::max(kSmallest, width / 2)));
  player_.apply_setup();
  show_note("region of " + std::to_string(player_.setup.region) + " px");
}

void Window::default_region() {
  player_.setup.region = 0;
  player_.apply_setup();
  show_note("region of the default size");
}

void Window::next_law() {
  remembers_law_ = true;
  player_.setup.law =
      next_of({"arctan", "arctan-axis", "linear", "drag", "inertial"}, player_.setup.law);
  player_.apply_setup();
  show_note("force law " + player_.setup.law);
}

void Window::calibrate() {
  player_.calibrate();
  show_note("the grip is in the centre now");
}

// ---- the window ---------------------------------------------------------------------------------

void Window::toggle_fullscreen() {
  if (fullscreen_)
    gtk_window_unfullscreen(GTK_WINDOW(window_));
  else
    gtk_window_fullscreen(GTK_WINDOW(window_));
}

void Window::toggle_drawing() {
  player_.setup.drawing = !player_.setup.drawing;
  player_.apply_setup();
  show_note(player_.setup.drawing ? "motion and force are drawn" : "the film alone");
}

void Window::toggle_curves() {
  settings_.curves = !settings_.curves;
  arrange();
  show_note(!settings_.curves ? "without curves"
            : fullscreen_     ? "with curves, outside full screen"
                              : "with curves");
}

void Window::next_appearance() {
  settings_.appearance = next_of({"system", "light", "dark"}, settings_.appearance);
  set_appearance(settings_.appearance);
  show_note(settings_.appearance == "system" ? "colours like the desktop"
                                             : settings_.appearance + " colours");
}

void Window::show_keys() {
  GtkWidget *keys = make_shortcuts_window(work_area().height);
  gtk_window_set_transient_for(GTK_WINDOW(keys), GTK_WINDOW(window_));
  gtk_widget_show(keys);
}

void Window::show_about() {
  gtk_show_about_dialog(GTK_WINDOW(window_), "program-name", "Feeling Wind", "version", VERSION,
                        "logo-icon-name", "feeling-wind", "license-type", GTK_LICENSE_LGPL_2_1,
                        "comments", "Point at something in a film and feel it move.", nullptr);
}

} // namespace program
