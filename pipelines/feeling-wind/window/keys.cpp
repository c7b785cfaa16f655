// SPDX-License-Identifier: LGPL-2.1-or-later
#include "window/keys.hpp"

#include "glue/gst-raii.hpp"

#include <cstring>

namespace program {
namespace {

using haptic::GCharPtr;

constexpr std::array kGroups = {"Film", "Playing", "Force", "Window"};
constexpr int kHeightOfAll = 880; // px; of two columns with all keys

using Strings = std::unique_ptr<gchar *, decltype(&g_strfreev)>;

Strings split(const char *accelerators) {
  return {g_strsplit(accelerators, " ", -1), g_strfreev};
}

// Without gtk_accelerator_get_label(), which needs a display: --help must not.
std::string label_of(const char *accelerator) {
  struct Name {
    const char *accelerator;
    const char *label;
  };
  constexpr std::array kNames = {
      Name{"minus", "-"},   Name{"plus", "+"},        Name{"less", "<"},
      Name{"greater", ">"}, Name{"bracketleft", "["}, Name{"bracketright", "]"},
      Name{"comma", ","},   Name{"period", "."},      Name{"<Control>question", "Ctrl+?"},
      Name{"equal", "="}};
  for (const Name &name : kNames)
    if (std::strcmp(name.accelerator, accelerator) == 0)
      return name.label;
  constexpr const char *kControl = "<Control>";
  if (g_str_has_prefix(accelerator, kControl))
    return "Ctrl+" + std::string(1, g_ascii_toupper(accelerator[std::strlen(kControl)]));
  return accelerator;
}

// The keys of the number pad are the same signs again.
bool is_on_keypad(const char *accelerator) {
  return g_str_has_prefix(accelerator, "KP_");
}

std::string labels_of(const char *accelerators) {
  std::string text;
  const Strings parts = split(accelerators);
  for (gchar **part = parts.get(); *part; ++part)
    if (!is_on_keypad(*part))
      text += (text.empty() ? "" : " or ") + label_of(*part);
  return text;
}

std::string shown_accelerators(const char *accelerators) {
  std::string text;
  const Strings parts = split(accelerators);
  for (gchar **part = parts.get(); *part; ++part)
    if (!is_on_keypad(*part))
      text += (text.empty() ? "" : " ") + std::string(*part);
  return text;
}

std::string escaped(const char *text) {
  const GCharPtr owned(g_markup_escape_text(text, -1));
  return owned.get();
}

} // namespace

void set_accelerators(GtkApplication *application) {
  for (const Key &key : kKeys) {
    const Strings parts = split(key.accelerators);
    gtk_application_set_accels_for_action(application, (std::string("win.") + key.action).c_str(),
                                          parts.get());
  }
}

// GtkShortcutsWindow can only be made from XML.
GtkWidget *make_shortcuts_window(int screen_height) {
  std::string xml = "<interface><object class=\"GtkShortcutsWindow\" id=\"keys\">"
                    "<property name=\"modal\">1</property>"
                    "<child><object class=\"GtkShortcutsSection\">"
                    "<property name=\"visible\">1</property>"
                    "<property name=\"max-height\">" +
                    std::string(screen_height < kHeightOfAll ? "14" : "20") + "</property>";
  for (std::size_t group = 0; group < kGroups.size(); ++group) {
    xml += "<child><object class=\"GtkShortcutsGroup\"><property name=\"visible\">1</property>"
           "<property name=\"title\">" +
           std::string(kGroups[group]) + "</property>";
    for (const Key &key : kKeys)
      if (key.group == static_cast<KeyGroup>(group))
        xml += "<child><object class=\"GtkShortcutsShortcut\"><property name=\"visible\">1"
               "</property><property name=\"accelerator\">" +
               escaped(shown_accelerators(key.accelerators).c_str()) +
               "</property><property name=\"title\">" + escaped(key.what) +
               "</property></object></child>";
    xml += "</object></child>";
  }
  xml += "</object></child></object></interface>";
  GtkBuilder *builder = gtk_builder_new_from_string(xml.c_str(), -1);
  auto *window = GTK_WIDGET(g_object_ref(gtk_builder_get_object(builder, "keys")));
  g_object_unref(builder);
  return window;
}

std::string keys_of(const std::string &action) {
  for (const Key &key : kKeys)
    if (action == key.action)
      return labels_of(key.accelerators);
  return "";
}

std::string keys_as_text() {
  std::string text = "Keys:";
  for (std::size_t group = 0; group < kGroups.size(); ++group) {
    text += "\n " + std::string(kGroups[group]) + ":\n";
    for (const Key &key : kKeys)
      if (key.group == static_cast<KeyGroup>(group)) {
        const GCharPtr line(
            g_strdup_printf("  %-18s %s\n", labels_of(key.accelerators).c_str(), key.what));
        text += line.get();
      }
  }
  return text;
}

} // namespace program
