// SPDX-License-Identifier: LGPL-2.1-or-later
#include "window/settings.hpp"

#include "glue/gst-raii.hpp"

#include <algorithm>
#include <cmath>
#include <glib.h>
#include <memory>

namespace program {
namespace {

using haptic::GCharPtr;

constexpr const char *kGroup = "window";

using KeyFile = std::unique_ptr<GKeyFile, decltype(&g_key_file_unref)>;

KeyFile make_file() {
  return {g_key_file_new(), g_key_file_unref};
}

std::string path() {
  const GCharPtr name(
      g_build_filename(g_get_user_config_dir(), "feeling-wind", "settings.ini", nullptr));
  return name.get();
}

bool has(const KeyFile &file, const char *key) {
  return g_key_file_has_key(file.get(), kGroup, key, nullptr);
}

void read(const KeyFile &file, const char *key, double &value, double least, double most) {
  if (!has(file, key))
    return;
  const double found = g_key_file_get_double(file.get(), kGroup, key, nullptr);
  if (std::isfinite(found))
    value = std::clamp(found, least, most);
}

void read(const KeyFile &file, const char *key, bool &value) {
  if (has(file, key))
    value = g_key_file_get_boolean(file.get(), kGroup, key, nullptr);
}

void read(const KeyFile &file, const char *key, std::string &value) {
  if (const GCharPtr found(g_key_file_get_string(file.get(), kGroup, key, nullptr)); found)
    value = found.get();
}

} // namespace

Settings Settings::load() {
  Settings settings;
  const KeyFile file = make_file();
  if (!g_key_file_load_from_file(file.get(), path().c_str(), G_KEY_FILE_NONE, nullptr))
    return settings;
  double region = 0;
  read(file, "alpha", settings.alpha, 0, 10);
  read(file, "region", region, 0, 65536);
  read(file, "law", settings.law);
  read(file, "drawing", settings.drawing);
  read(file, "curves", settings.curves);
  read(file, "volume", settings.volume, 0, 1);
  read(file, "muted", settings.muted);
  read(file, "appearance", settings.appearance);
  read(file, "folder", settings.folder);
  settings.region = static_cast<int>(region);
  return settings;
}

bool Settings::save() const {
  const KeyFile file = make_file();
  g_key_file_set_double(file.get(), kGroup, "alpha", alpha);
  g_key_file_set_integer(file.get(), kGroup, "region", region);
  g_key_file_set_string(file.get(), kGroup, "law", law.c_str());
  g_key_file_set_boolean(file.get(), kGroup, "drawing", drawing);
  g_key_file_set_boolean(file.get(), kGroup, "curves", curves);
  g_key_file_set_double(file.get(), kGroup, "volume", volume);
  g_key_file_set_boolean(file.get(), kGroup, "muted", muted);
  g_key_file_set_string(file.get(), kGroup, "appearance", appearance.c_str());
  g_key_file_set_string(file.get(), kGroup, "folder", folder.c_str());
  const GCharPtr parent(g_path_get_dirname(path().c_str()));
  return g_mkdir_with_parents(parent.get(), 0700) == 0 &&
         g_key_file_save_to_file(file.get(), path().c_str(), nullptr);
}

} // namespace program
