// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads a GKeyFile that a user wrote, and refuses what is wrong in it with a message for them.
#pragma once

#include "format-text.hpp"

#include <algorithm>
#include <filesystem>
#include <glib.h>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace haptic {

/// Formats of the messages for what can be wrong in any such file.
struct KeyFileMessages {
  const char *no_such;    ///< name of a built-in file
  const char *unreadable; ///< file, reason
  const char *missing;    ///< file, group, key
  const char *unknown;    ///< file, group, key
  const char *number;     ///< file, group, key, value, least, most
};

/// All functions throw std::runtime_error with a message for a user.
class KeyFile {
public:
  using BuiltIn = std::pair<std::string_view, std::string_view>; ///< name, text

  /// `name`: a path, if it has a slash or ends in .ini, else a built-in file.
  KeyFile(const std::string &name, std::span<const BuiltIn> built_in,
          const KeyFileMessages &messages)
      : messages_(messages), where_(name), file_(g_key_file_new()) {
    if (name.find('/') != std::string::npos || name.ends_with(".ini")) {
      std::error_code unknown;
      if (std::filesystem::is_fifo(name, unknown)) // opening it would wait for a writer
        refuse(messages_.unreadable, "it is a FIFO");
      GError *raw = nullptr;
      if (!g_key_file_load_from_file(file_.get(), name.c_str(), G_KEY_FILE_NONE, &raw)) {
        const std::unique_ptr<GError, Release> error(raw);
        refuse(messages_.unreadable, error->message);
      }
      return;
    }
    const auto found = std::ranges::find(built_in, std::string_view(name), &BuiltIn::first);
    if (found == built_in.end())
      refuse(messages_.no_such);
    g_key_file_load_from_data(file_.get(), found->second.data(), found->second.size(),
                              G_KEY_FILE_NONE, nullptr);
  }

  /// The group of the calls that follow. Returns whether it is there.
  bool enter(std::string group) {
    group_ = std::move(group);
    return g_key_file_has_group(file_.get(), group_.c_str());
  }

  std::optional<std::string> text(const char *key) {
    known_.insert(group_ + "/" + key);
    const std::unique_ptr<char, Release> value(
        g_key_file_get_value(file_.get(), group_.c_str(), key, nullptr));
    return value ? std::optional<std::string>(g_strstrip(value.get())) : std::nullopt;
  }

  std::optional<double> number(const char *key, double least, double most) {
    const auto value = text(key);
    if (!value)
      return std::nullopt;
    char *end = nullptr;
    const double found = g_ascii_strtod(value->c_str(), &end); // whatever the locale's point
    if (value->empty() || *end != '\0' || !(found >= least && found <= most))
      refuse(messages_.number, group_.c_str(), key, value->c_str(), least, most);
    return found;
  }

  template <typename Value>
  Value need(const char *key, const std::optional<Value> &value) const {
    if (!value)
      refuse(messages_.missing, group_.c_str(), key);
    return *value;
  }

  /// Metres of the unit that `key` names, or nothing.
  std::optional<double> unit(const char *key) {
    constexpr std::pair<std::string_view, double> kUnits[] = {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}};
    const auto name = text(key);
    for (const auto &[unit, metres] : kUnits)
      if (name == unit)
        return metres;
    return std::nullopt;
  }

  /// Refuses keys that were not asked for. One may be misspelt, or its number left out.
  void refuse_unknown() const {
    const std::unique_ptr<char *, Release> groups(g_key_file_get_groups(file_.get(), nullptr));
    for (char **group = groups.get(); *group != nullptr; ++group) {
      const std::unique_ptr<char *, Release> keys(
          g_key_file_get_keys(file_.get(), *group, nullptr, nullptr));
      for (char **key = keys.get(); key != nullptr && *key != nullptr; ++key)
        if (!known_.contains(std::string(*group) + "/" + *key))
          refuse(messages_.unknown, *group, *key);
    }
  }

  /// The file is the first argument of the format.
  template <typename... Arguments>
  [[noreturn]] void refuse(const char *format, Arguments... arguments) const {
    throw std::runtime_error(format_text(format, where_.c_str(), arguments...));
  }

private:
  struct Release {
    void operator()(GKeyFile *file) const { g_key_file_unref(file); }
    void operator()(GError *error) const { g_error_free(error); }
    void operator()(char *text) const { g_free(text); }
    void operator()(char **texts) const { g_strfreev(texts); }
  };

  const KeyFileMessages &messages_;
  std::string where_; // begins every message
  std::unique_ptr<GKeyFile, Release> file_;
  std::string group_;
  std::set<std::string> known_;
};

} // namespace haptic
