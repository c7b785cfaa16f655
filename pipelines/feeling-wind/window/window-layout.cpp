// SPDX-License-Identifier: LGPL-2.1-or-later
// The widgets of the window.
#include "builtin-layouts.hpp"
#include "window/force-gauge.hpp"
#include "window/session-text.hpp"
#include "window/widgets.hpp"
#include "window/window.hpp"

#include <algorithm>
#include <gst/video/video.h>

namespace program {
namespace {

using haptic::GCharPtr;

constexpr int kWidth = 800;
constexpr int kHeight = 600;
constexpr int kStripHeight = 120;
constexpr int kLightSize = 20;
constexpr int kTextWidth = 230; // of two lines that say why the force is off
constexpr int kMargin = 6;
constexpr double kOfScreen = 0.9; // the largest window
constexpr double kSecondsPerStep = 5;
constexpr double kSecondsPerPage = 30;

GtkWidget *make_row() {
  GtkWidget *row = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, kMargin);
  gtk_container_set_border_width(GTK_CONTAINER(row), kMargin);
  return row;
}

GtkWidget *make_label(const char *text) {
  GtkWidget *label = gtk_label_new(text);
  gtk_label_set_ellipsize(GTK_LABEL(label), PANGO_ELLIPSIZE_END);
  gtk_label_set_xalign(GTK_LABEL(label), 0);
  return label;
}

void add(GtkWidget *row, GtkWidget *widget, bool fills = false) {
  gtk_box_pack_start(GTK_BOX(row), widget, fills, TRUE, 0);
}

} // namespace

void Window::make_window(GtkApplication *application) {
  window_ = gtk_application_window_new(application);
  gtk_window_set_title(GTK_WINDOW(window_), "Feeling Wind");
  gtk_window_set_icon_name(GTK_WINDOW(window_), "feeling-wind");
  gtk_window_set_default_size(GTK_WINDOW(window_), kWidth, kHeight);
  camera_menu_ = g_menu_new();
  device_menu_ = g_menu_new();
  menu_ = g_menu_new();
  sound_menu_ = g_menu_new();
  gtk_window_set_titlebar(GTK_WINDOW(window_), make_header());

  GtkWidget *box = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
  add(box, make_info_bar());
  pages_ = gtk_stack_new();
  gtk_stack_add_named(GTK_STACK(pages_), make_empty_page(), "empty");
  film_box_ = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
  gtk_stack_add_named(GTK_STACK(pages_), film_box_, "film");
  gtk_widget_show(film_box_);
  add(box, make_overlay(), true);
  add(box, make_strip());
  film_controls_ = make_film_controls();
  add(box, film_controls_);
  add(box, make_force_controls());
  gtk_container_add(GTK_CONTAINER(window_), box);
  fill_menu();
  connect_events();
  gtk_widget_show_all(window_);
  arrange();
  gtk_widget_hide(info_);
  gtk_widget_hide(note_);
}

// The whole screen is for the film, and for the light that says why the force is off.
void Window::arrange() {
  gtk_widget_set_visible(strip_, settings_.curves && !fullscreen_);
  gtk_widget_set_visible(film_controls_, !fullscreen_);
  gtk_widget_set_visible(leave_button_, fullscreen_);
}

// What an action did is shown over the film, for a moment.
GtkWidget *Window::make_overlay() {
  GtkWidget *overlay = gtk_overlay_new();
  gtk_container_add(GTK_CONTAINER(overlay), pages_);
  note_ = gtk_label_new("");
  gtk_widget_set_halign(note_, GTK_ALIGN_START);
  gtk_widget_set_valign(note_, GTK_ALIGN_END);
  gtk_style_context_add_class(gtk_widget_get_style_context(note_), "osd");
  gtk_label_set_ellipsize(GTK_LABEL(note_), PANGO_ELLIPSIZE_END);
  g_object_set(note_, "margin", 2 * kMargin, "xpad", kMargin, "ypad", kMargin, nullptr);
  gtk_overlay_add_overlay(GTK_OVERLAY(overlay), note_);
  gtk_overlay_set_overlay_pass_through(GTK_OVERLAY(overlay), note_, TRUE);
  return overlay;
}

GtkWidget *Window::make_header() {
  header_ = gtk_header_bar_new();
  gtk_header_bar_set_show_close_button(GTK_HEADER_BAR(header_), TRUE);
  gtk_header_bar_set_title(GTK_HEADER_BAR(header_), "Feeling Wind");
  GtkHeaderBar *bar = GTK_HEADER_BAR(header_);
  camera_button_ = make_menu_button("camera-web-symbolic", "Camera", "show-cameras", camera_menu_);
  device_button_ =
      make_menu_button("input-gaming-symbolic", "Haptic device", "show-devices", device_menu_);
  menu_button_ = make_menu_button("open-menu-symbolic", "Menu", "menu", menu_);
  record_button_ = make_button("media-record-symbolic", "Record", "record");
  gtk_header_bar_pack_start(bar, make_button("document-open-symbolic", "Open a film", "open"));
  gtk_header_bar_pack_start(bar, camera_button_);
  gtk_header_bar_pack_start(bar, device_button_);
  gtk_header_bar_pack_end(bar, menu_button_);
  gtk_header_bar_pack_end(bar,
                          make_button("view-fullscreen-symbolic", "Full screen", "fullscreen"));
  gtk_header_bar_pack_end(bar, record_button_);
  return header_;
}

GtkWidget *Window::make_info_bar() {
  info_ = gtk_info_bar_new();
  info_text_ = gtk_label_new("");
  gtk_label_set_line_wrap(GTK_LABEL(info_text_), TRUE);
  gtk_label_set_xalign(GTK_LABEL(info_text_), 0);
  gtk_label_set_selectable(GTK_LABEL(info_text_), TRUE);
  gtk_widget_set_can_focus(info_text_, FALSE);
  GtkWidget *content = gtk_info_bar_get_content_area(GTK_INFO_BAR(info_));
  gtk_box_pack_start(GTK_BOX(content), info_text_, TRUE, TRUE, 0);
  wait_button_ = gtk_info_bar_add_button(GTK_INFO_BAR(info_), "Go on _waiting", GTK_RESPONSE_APPLY);
  other_button_ = gtk_info_bar_add_button(GTK_INFO_BAR(info_), "_Open another …", GTK_RESPONSE_YES);
  gtk_info_bar_add_button(GTK_INFO_BAR(info_), "_Close", GTK_RESPONSE_CLOSE);
  connect(info_, "response", [](GtkInfoBar *, int response, Window *self) noexcept {
    self->hide_info();
    self->last_sign_ = std::chrono::steady_clock::now();
    if (response == GTK_RESPONSE_YES)
      self->choose_film();
  });
  return info_;
}

GtkWidget *Window::make_empty_page() {
  GtkWidget *page = gtk_box_new(GTK_ORIENTATION_VERTICAL, 2 * kMargin);
  gtk_widget_set_valign(page, GTK_ALIGN_CENTER);
  gtk_widget_set_halign(page, GTK_ALIGN_CENTER);
  GtkWidget *title = gtk_label_new(nullptr);
  gtk_label_set_markup(GTK_LABEL(title),
                       "<big><b>Point at something in a film and feel it move</b></big>");
  add(page, title);
  add(page, gtk_label_new("Drop a film here, or open one:"));
  GtkWidget *buttons = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, kMargin);
  gtk_widget_set_halign(buttons, GTK_ALIGN_CENTER);
  add(buttons, make_text_button("Open a film …", "Open a film", "open"));
  add(buttons, make_text_button("Open a URL …", "Open a URL", "open-url"));
  add(page, buttons);
  demonstration_button_ = make_text_button("Play the film of a tree in the wind",
                                           "Play the film of the demonstration", "demonstration");
  gtk_widget_set_halign(demonstration_button_, GTK_ALIGN_CENTER);
  const GCharPtr drawer(g_find_program_in_path("wind-film"));
  if (drawer)
    add(page, demonstration_button_);
  GtkWidget *hint =
      gtk_label_new("Cameras and haptic devices are in the bar above. F1 shows all keys.");
  gtk_style_context_add_class(gtk_widget_get_style_context(hint), "dim-label");
  add(page, hint);
  gtk_widget_show_all(page);
  return page;
}

GtkWidget *Window::make_strip() {
  strip_ = gtk_drawing_area_new();
  gtk_widget_set_size_request(strip_, -1, kStripHeight);
  set_accessible_name(strip_, "Curves of velocity and force");
  connect(strip_, "draw", [](GtkWidget *widget, cairo_t *cairo, Window *self) noexcept {
    GtkStyleContext *style = gtk_widget_get_style_context(widget);
    ChartColors colors;
    gtk_style_context_lookup_color(style, "theme_base_color", &colors.background);
    gtk_style_context_lookup_color(style, "theme_text_color", &colors.text);
    self->chart_.draw(cairo, gtk_widget_get_allocated_width(widget),
                      gtk_widget_get_allocated_height(widget), colors);
    return gboolean{TRUE};
  });
  return strip_;
}

GtkWidget *Window::make_film_controls() {
  GtkWidget *row = make_row();
  play_button_ = make_button("media-playback-start-symbolic", "Play", "play");
  time_ = gtk_label_new("0:00");
  duration_ = gtk_label_new("0:00");
  position_ = gtk_scale_new_with_range(GTK_ORIENTATION_HORIZONTAL, 0, 1, kSecondsPerStep);
  gtk_range_set_increments(GTK_RANGE(position_), kSecondsPerStep, kSecondsPerPage);
  gtk_scale_set_draw_value(GTK_SCALE(position_), FALSE);
  gtk_widget_set_size_request(position_, 120, -1);
  gtk_widget_set_focus_on_click(position_, FALSE);
  set_accessible_name(position_, "Position in the film, seconds");
  connect(position_, "change-value",
          [](GtkRange *, GtkScrollType, double value, Window *self) noexcept {
            return self->handle_scroll_to(value);
          });
  rate_ = gtk_label_new("1×");
  gtk_label_set_width_chars(GTK_LABEL(rate_), 6);
  mute_button_ = make_button("audio-volume-high-symbolic", "Sound off and on", "mute");
  add(row, play_button_);
  add(row, time_);
  add(row, position_, true);
  add(row, duration_);
  add(row, make_button("media-seek-backward-symbolic", "Slower", "slower"));
  add(row, rate_);
  add(row, make_button("media-seek-forward-symbolic", "Faster", "faster"));
  add(row, make_button("object-flip-horizontal-symbolic", "Reverse the direction", "reverse"));
  add(row, mute_button_);
  return row;
}

GtkWidget *Window::make_force_controls() {
  GtkWidget *row = make_row();
  light_ = gtk_drawing_area_new();
  gtk_widget_set_size_request(light_, kLightSize, kLightSize);
  gtk_widget_set_valign(light_, GTK_ALIGN_CENTER);
  connect(light_, "draw", [](GtkWidget *, cairo_t *cairo, Window *self) noexcept {
    draw_light(cairo, kLightSize, light_of(self->session_, self->player_.is_armed()));
    return gboolean{TRUE};
  });
  force_text_ = make_label("");
  gtk_widget_set_size_request(force_text_, kTextWidth, -1);
  gtk_label_set_line_wrap(GTK_LABEL(force_text_), TRUE);
  gtk_label_set_lines(GTK_LABEL(force_text_), 2);
  arm_button_ = make_text_button("Force off", "Force off and on", "arm");
  add(row, light_);
  add(row, arm_button_);
  add(row, force_text_, true);
  add(row, gtk_label_new("Region"));
  add(row, make_button("list-remove-symbolic", "Smaller region", "smaller-region"));
  add(row, make_button("list-add-symbolic", "Larger region", "larger-region"));
  add(row, gtk_label_new("Strength"));
  add(row, make_button("list-remove-symbolic", "Weaker", "weaker"));
  add(row, make_button("list-add-symbolic", "Stronger", "stronger"));
  leave_button_ = make_button("view-restore-symbolic", "Leave full screen", "fullscreen");
  add(row, leave_button_);
  return row;
}

// Every action without a button, so that each can be reached with the mouse too.
void Window::fill_menu() {
  constexpr const char *kSections[][10] = {
      {"open", "open-url", "demonstration", "record"},
      {"back", "forward", "begin", "slower", "faster", "reverse", "rotate", "deinterlace"},
      {"quieter", "louder"},
      {"hold", "default-region", "next-law", "calibrate"},
      {"drawing", "curves", "appearance"},
      {"keys", "about", "quit"}};
  const auto label = [](const char *action) -> std::string {
    for (const Key &key : kKeys)
      if (g_str_equal(key.action, action))
        return key.what;
    if (g_str_equal(action, "appearance"))
      return "Like the desktop, light, dark";
    return g_str_equal(action, "about") ? "About Feeling Wind" : "Film of the demonstration";
  };
  for (const auto &section : kSections) {
    if (g_str_equal(section[0], "drawing"))
      add_array_menu();
    GMenu *part = g_menu_new();
    for (const char *action : section)
      if (action)
        g_menu_append(part, label(action).c_str(), (std::string("win.") + action).c_str());
    g_menu_append_section(menu_, nullptr, G_MENU_MODEL(part));
    g_object_unref(part);
  }
}

// Which array vibrates with the film, and which sound device drives it.
void Window::add_array_menu() {
  GMenu *layouts = g_menu_new();
  const auto add_layout = [layouts](const char *title, const char *name) {
    GMenuItem *item = g_menu_item_new(title, nullptr);
    g_menu_item_set_action_and_target(item, "win.array", "s", name);
    g_menu_append_item(layouts, item);
    g_object_unref(item);
  };
  add_layout("None", "");
  for (const auto &[name, text] : haptic::kBuiltinLayouts)
    add_layout(std::string(name).c_str(), std::string(name).c_str());
  GMenu *part = g_menu_new();
  g_menu_append_submenu(part, "Array of actuators", G_MENU_MODEL(layouts));
  g_menu_append_submenu(part, "Sound device of the array", G_MENU_MODEL(sound_menu_));
  g_menu_append_section(menu_, nullptr, G_MENU_MODEL(part));
  g_object_unref(layouts);
  g_object_unref(part);
}

void Window::connect_events() {
  connect(window_, "key-press-event", [](GtkWidget *, GdkEventKey *event, Window *self) noexcept {
    return self->handle_key(event);
  });
  gdk_event_handler_set(
      [](GdkEvent *event, gpointer self) noexcept {
        static_cast<Window *>(self)->filter_event(event);
      },
      this, nullptr);
  connect(window_, "window-state-event",
          [](GtkWidget *, GdkEventWindowState *event, Window *self) noexcept {
            self->fullscreen_ = event->new_window_state & GDK_WINDOW_STATE_FULLSCREEN;
            self->arrange();
            return gboolean{FALSE};
          });
  connect(device_button_, "toggled",
          [](GtkToggleButton *, Window *self) noexcept { self->list_devices(); });
  connect(menu_button_, "toggled", [](GtkToggleButton *button, Window *self) noexcept {
    if (gtk_toggle_button_get_active(button))
      self->list_sound_devices();
  });
  connect(window_, "delete-event", [](GtkWidget *, GdkEvent *, Window *self) noexcept {
    self->quit();
    return gboolean{TRUE};
  });
  gtk_drag_dest_set(window_, GTK_DEST_DEFAULT_ALL, nullptr, 0, GDK_ACTION_COPY);
  gtk_drag_dest_add_uri_targets(window_);
  connect(window_, "drag-data-received",
          [](GtkWidget *, GdkDragContext *, int, int, GtkSelectionData *data, guint, guint,
             Window *self) noexcept { self->handle_drop(data); });
}

// Escape closes an open menu or dialog and reaches no action then: the force goes off before.
void Window::filter_event(GdkEvent *event) {
  guint key = 0;
  if (gdk_event_get_event_type(event) == GDK_KEY_PRESS && gdk_event_get_keyval(event, &key) &&
      key == GDK_KEY_Escape)
    player_.release();
  gtk_main_do_event(event); // may delete this window
}

// The focused widget first: Space presses a focused button, and plays or pauses otherwise.
gboolean Window::handle_key(GdkEventKey *event) {
  GtkWidget *focus = gtk_window_get_focus(GTK_WINDOW(window_));
  if (!focus || focus == video_)
    return FALSE;
  // Space is a binding of the window, which comes after its accelerators.
  return gtk_window_propagate_key_event(GTK_WINDOW(window_), event) ||
         (event->keyval == GDK_KEY_space && GTK_IS_BUTTON(focus) &&
          gtk_bindings_activate_event(G_OBJECT(window_), event));
}

void Window::handle_drop(GtkSelectionData *data) {
  gchar **uris = gtk_selection_data_get_uris(data);
  if (uris && uris[0])
    open(source_named(uris[0], "/"));
  g_strfreev(uris);
}

gboolean Window::handle_scroll_to(double seconds) {
  seek_to(seconds);
  return FALSE; // the slider moves too
}

void Window::draw_over_film(cairo_t *cairo, GtkWidget *video) {
  const haptic::SamplePtr frame = player_.last_frame();
  if (!frame || !player_.setup.drawing)
    return;
  const int width = gtk_widget_get_allocated_width(video);
  const int height = gtk_widget_get_allocated_height(video);
  draw_force_gauge(cairo, frame.get(), width, height, player_.max_force());
  player_.draw_array(cairo, width, height);
}

// The part of the screen that windows can use.
GdkRectangle Window::work_area() {
  GdkWindow *surface = gtk_widget_get_window(window_);
  GdkMonitor *monitor = gdk_display_get_monitor_at_window(gtk_widget_get_display(window_), surface);
  GdkRectangle area;
  gdk_monitor_get_workarea(monitor, &area);
  return area;
}

// A pixel of the film on a pixel of the screen, where the screen has room for it.
void Window::size_to_film() {
  const haptic::SamplePtr frame = player_.last_frame();
  GstVideoInfo info;
  if (!frame || !gst_video_info_from_caps(&info, gst_sample_get_caps(frame.get())) || fullscreen_ ||
      gtk_window_is_maximized(GTK_WINDOW(window_)))
    return;
  const GdkRectangle area = work_area();
  int width = 0, height = 0;
  gtk_window_get_size(GTK_WINDOW(window_), &width, &height);
  const int others_x = width - gtk_widget_get_allocated_width(pages_);
  const int others_y = height - gtk_widget_get_allocated_height(pages_);
  const double pixel = gtk_widget_get_scale_factor(window_);
  const double film_width = info.width * static_cast<double>(info.par_n) / info.par_d / pixel;
  const double film_height = info.height / pixel;
  const double fit = std::min({1.0, (kOfScreen * area.width - others_x) / film_width,
                               (kOfScreen * area.height - others_y) / film_height});
  gtk_window_resize(GTK_WINDOW(window_), std::max(1, static_cast<int>(fit * film_width) + others_x),
                    std::max(1, static_cast<int>(fit * film_height) + others_y));
}

} // namespace program
