// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads a Geometry from a GKeyFile, finds the file for a name, and writes one.
#include "builtin-geometries.hpp"
#include "fail.hpp"
#include "spidar/calibration.hpp"
#include "spidar/geometry.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glib.h>
#include <locale>
#include <set>
#include <sstream>

namespace spidar {

namespace {

namespace fs = std::filesystem;

struct Unref {
  void operator()(GKeyFile *file) const { g_key_file_unref(file); }
  void operator()(GError *error) const { g_error_free(error); }
  void operator()(char *text) const { g_free(text); }
  void operator()(char **texts) const { g_strfreev(texts); }
};
using KeyFile = std::unique_ptr<GKeyFile, Unref>;

class Reader {
public:
  /// `where` begins every message: the file's path, or the built-in name.
  Reader(KeyFile file, std::string where) : file_(std::move(file)), where_(std::move(where)) {}

  Geometry read(const std::string &name) {
    Geometry geometry;
    geometry.name = name;
    group_ = "device";
    geometry.digits_per_volt = number("digits-per-volt");
    geometry.dac_limit = whole("dac-limit", 1, 32767);
    geometry.tension_min = number("tension-min");
    geometry.tension_max = number("tension-max");
    geometry.grip_radius = number("grip-radius");
    geometry.workspace_half = vector("workspace-half");
    if (has("button-bit") || has("button-pressed"))
      geometry.button = {.bit = whole("button-bit", 0, 3),
                         .pressed = whole("button-pressed", 0, 1) == 1};
    for (std::size_t i = 0; i < kStrings; ++i) {
      group_ = "string-" + std::to_string(i);
      geometry.motors[i] = vector("motor");
      geometry.attachments[i] = vector("attachment");
      geometry.metres_per_count[i] = number("metres-per-count");
      geometry.volts_per_newton[i] = number("volts-per-newton");
    }
    refuse_unknown();
    return geometry;
  }

private:
  bool has(const char *key) const {
    return g_key_file_has_key(file_.get(), group_.c_str(), key, nullptr) != 0;
  }

  std::string text(const char *key) {
    known_.insert(group_ + "/" + key);
    const std::unique_ptr<char, Unref> value(
        g_key_file_get_value(file_.get(), group_.c_str(), key, nullptr));
    if (!value)
      fail(Cause::geometry, messages::kGeometryKeyMissing, where_.c_str(), group_.c_str(), key);
    return value.get();
  }

  double parse(const char *key, const char *text) const {
    char *end = nullptr;
    const double value = g_ascii_strtod(text, &end); // whatever the locale's decimal point
    while (end != text && g_ascii_isspace(*end))
      ++end;
    if (end == text || *end != '\0' || !std::isfinite(value))
      fail(Cause::geometry, messages::kGeometryNumber, where_.c_str(), group_.c_str(), key, text);
    return value;
  }

  double number(const char *key) { return parse(key, text(key).c_str()); }

  int whole(const char *key, int least, int most) {
    const double value = number(key);
    if (value != std::floor(value) || value < least || value > most)
      fail(Cause::geometry, messages::kGeometryWhole, where_.c_str(), group_.c_str(), key, least,
           most);
    return static_cast<int>(value);
  }

  Vector3 vector(const char *key) {
    std::string value = text(key);
    if (!value.empty() && value.back() == ';')
      value.pop_back();
    const std::unique_ptr<char *, Unref> parts(g_strsplit(value.c_str(), ";", -1));
    if (g_strv_length(parts.get()) != 3)
      fail(Cause::geometry, messages::kGeometryVector, where_.c_str(), group_.c_str(), key,
           value.c_str());
    return {parse(key, parts.get()[0]), parse(key, parts.get()[1]), parse(key, parts.get()[2])};
  }

  /// Refuses unknown keys: one may be misspelt.
  void refuse_unknown() {
    const std::unique_ptr<char *, Unref> groups(g_key_file_get_groups(file_.get(), nullptr));
    for (char **group = groups.get(); *group != nullptr; ++group) {
      group_ = *group;
      const std::unique_ptr<char *, Unref> keys(
          g_key_file_get_keys(file_.get(), *group, nullptr, nullptr));
      for (char **key = keys.get(); key != nullptr && *key != nullptr; ++key)
        if (known_.count(group_ + "/" + *key) == 0)
          fail(Cause::geometry, messages::kGeometryKeyUnknown, where_.c_str(), group_.c_str(),
               *key);
    }
  }

  KeyFile file_;
  std::string where_;
  std::string group_;
  std::set<std::string> known_;
};

Geometry finish(KeyFile file, const std::string &where, const std::string &name) {
  Geometry geometry = Reader(std::move(file), where).read(name);
  try {
    check_geometry(geometry);
  } catch (const Error &error) {
    throw Error(error.cause(), where + ": " + error.what());
  }
  return geometry;
}

Geometry load_file(const fs::path &path) {
  std::error_code unknown;
  if (fs::is_fifo(path, unknown)) // opening it would wait for a writer
    fail(Cause::geometry, messages::kGeometryUnreadable, path.c_str(), "it is a FIFO");
  KeyFile file(g_key_file_new());
  GError *raw = nullptr;
  if (!g_key_file_load_from_file(file.get(), path.c_str(), G_KEY_FILE_NONE, &raw)) {
    const std::unique_ptr<GError, Unref> error(raw);
    const bool missing = g_error_matches(raw, G_FILE_ERROR, G_FILE_ERROR_NOENT);
    fail(missing ? Cause::not_found : Cause::geometry, messages::kGeometryUnreadable, path.c_str(),
         error->message);
  }
  return finish(std::move(file), path.string(), path.stem().string());
}

Geometry load_builtin(const std::string &name, std::string_view text) {
  KeyFile file(g_key_file_new());
  GError *raw = nullptr;
  if (!g_key_file_load_from_data(file.get(), text.data(), text.size(), G_KEY_FILE_NONE, &raw)) {
    const std::unique_ptr<GError, Unref> error(raw);
    fail(Cause::geometry, messages::kGeometryBroken, name.c_str(), error->message);
  }
  return finish(std::move(file), "Built-in geometry", name);
}

std::vector<fs::path> search_path() {
  std::vector<fs::path> directories;
  if (const char *list = std::getenv("SPIDAR_GEOMETRY_PATH")) {
    const std::unique_ptr<char *, Unref> parts(g_strsplit(list, ":", -1));
    for (char **part = parts.get(); *part != nullptr; ++part)
      if (**part != '\0')
        directories.emplace_back(*part);
  }
  return directories;
}

std::string shortest(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string shortest(const Vector3 &vector) {
  return shortest(vector.x()) + ";" + shortest(vector.y()) + ";" + shortest(vector.z());
}

} // namespace

std::vector<std::string> builtin_geometries() {
  std::vector<std::string> names;
  names.reserve(kBuiltinGeometries.size());
  for (const auto &[name, text] : kBuiltinGeometries)
    names.emplace_back(name);
  return names;
}

Geometry load_geometry(const std::string &name_or_file) {
  const std::string suffix = ".ini";
  if (name_or_file.find('/') != std::string::npos || name_or_file.ends_with(suffix))
    return load_file(name_or_file);

  const std::string file_name = name_or_file + suffix;
  std::error_code ignored;
  for (const fs::path &directory : search_path())
    if (fs::exists(directory / file_name, ignored))
      return load_file(directory / file_name);
  for (const auto &[name, text] : kBuiltinGeometries)
    if (name == name_or_file)
      return load_builtin(name_or_file, text);
  const fs::path installed = fs::path(SPIDAR_GEOMETRY_DIR) / file_name;
  if (fs::exists(installed, ignored))
    return load_file(installed);

  std::string names;
  for (const std::string &name : builtin_geometries())
    names += (names.empty() ? "" : ", ") + name;
  fail(Cause::not_found, messages::kNoGeometry, name_or_file.c_str(), names.c_str(),
       SPIDAR_GEOMETRY_DIR);
}

void save_geometry(const Geometry &geometry, const std::string &path) {
  check_geometry(geometry);
  std::ostringstream file;
  file.imbue(std::locale::classic()); // whatever the program has
  file << "# Measured by spidar-calibrate. docs/formats/geometry.md explains every key.\n"
       << "\n[device]"
       << "\ndigits-per-volt=" << shortest(geometry.digits_per_volt)
       << "\ndac-limit=" << geometry.dac_limit << "\ntension-min=" << shortest(geometry.tension_min)
       << "\ntension-max=" << shortest(geometry.tension_max)
       << "\ngrip-radius=" << shortest(geometry.grip_radius)
       << "\nworkspace-half=" << shortest(geometry.workspace_half) << "\n";
  if (geometry.button)
    file << "button-bit=" << geometry.button->bit << "\nbutton-pressed=" << geometry.button->pressed
         << "\n";
  for (std::size_t i = 0; i < kStrings; ++i)
    file << "\n[string-" << i << "]"
         << "\nmotor=" << shortest(geometry.motors[i])
         << "\nattachment=" << shortest(geometry.attachments[i])
         << "\nmetres-per-count=" << shortest(geometry.metres_per_count[i])
         << "\nvolts-per-newton=" << shortest(geometry.volts_per_newton[i]) << "\n";
  // A full disk leaves the file of before.
  const std::string text = file.str();
  GError *raw = nullptr;
  if (!g_file_set_contents(path.c_str(), text.data(), static_cast<gssize>(text.size()), &raw)) {
    const std::unique_ptr<GError, Unref> error(raw);
    fail(Cause::not_found, messages::kGeometryUnwritable, path.c_str(), error->message);
  }
}

} // namespace spidar
