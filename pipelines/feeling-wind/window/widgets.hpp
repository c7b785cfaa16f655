// SPDX-License-Identifier: LGPL-2.1-or-later
// Widgets with a name for screen readers.
#pragma once

#include "window/keys.hpp"

#include <gtk/gtk.h>
#include <string>

namespace program {

inline void set_accessible_name(GtkWidget *widget, const char *name) {
  atk_object_set_name(gtk_widget_get_accessible(widget), name);
}

/// Sets name and tooltip, the tooltip with the keys of the action.
inline void describe(GtkWidget *widget, const char *name, const char *action) {
  const std::string keys = keys_of(action);
  const std::string tip = keys.empty() ? name : std::string(name) + " (" + keys + ")";
  gtk_widget_set_tooltip_text(widget, tip.c_str());
  set_accessible_name(widget, name);
}

inline GtkWidget *make_button(const char *icon, const char *name, const char *action) {
  GtkWidget *button = gtk_button_new_from_icon_name(icon, GTK_ICON_SIZE_BUTTON);
  gtk_actionable_set_action_name(GTK_ACTIONABLE(button), (std::string("win.") + action).c_str());
  gtk_widget_set_focus_on_click(button, FALSE);
  describe(button, name, action);
  return button;
}

inline GtkWidget *make_text_button(const char *text, const char *name, const char *action) {
  GtkWidget *button = gtk_button_new_with_label(text);
  gtk_actionable_set_action_name(GTK_ACTIONABLE(button), (std::string("win.") + action).c_str());
  gtk_widget_set_focus_on_click(button, FALSE);
  describe(button, name, action);
  return button;
}

inline GtkWidget *make_menu_button(const char *icon, const char *name, const char *action,
                                   GMenu *menu) {
  GtkWidget *button = gtk_menu_button_new();
  gtk_button_set_image(GTK_BUTTON(button),
                       gtk_image_new_from_icon_name(icon, GTK_ICON_SIZE_BUTTON));
  // A popover would be cut off by a small window, and leave keys to the accelerators of the window.
  gtk_menu_button_set_use_popover(GTK_MENU_BUTTON(button), FALSE);
  gtk_menu_button_set_menu_model(GTK_MENU_BUTTON(button), G_MENU_MODEL(menu));
  gtk_widget_set_focus_on_click(button, FALSE);
  describe(button, name, action);
  return button;
}

inline void set_icon(GtkWidget *button, const char *icon) {
  gtk_button_set_image(GTK_BUTTON(button),
                       gtk_image_new_from_icon_name(icon, GTK_ICON_SIZE_BUTTON));
}

} // namespace program
