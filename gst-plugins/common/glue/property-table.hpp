// SPDX-License-Identifier: LGPL-2.1-or-later
// The properties of an element as a table: one row says how a property is declared, written and
// read.
#pragma once

#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"

#include <cmath>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <vector>

namespace haptic {

inline constexpr auto kReadOnly =
    static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS);
inline constexpr auto kReadWrite = static_cast<GParamFlags>(
    G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING);
/// It takes effect at the next start.
inline constexpr auto kReady =
    static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_READY);
/// A GstController may change it; see controllers.hpp.
inline constexpr auto kControllable = static_cast<GParamFlags>(kReadWrite | GST_PARAM_CONTROLLABLE);

/// One property of an element whose settings are in a `Settings`. The object's lock is held while
/// `set` and `get` run.
template <typename Settings>
struct Property {
  GParamSpec *spec;
  void (*set)(Settings &, const GValue *); ///< null: the property is read-only
  void (*get)(const Settings &, GValue *);
};

inline void read_value(const GValue *value, bool &to) {
  to = g_value_get_boolean(value) != FALSE;
}
inline void read_value(const GValue *value, guint &to) {
  to = g_value_get_uint(value);
}
/// NaN, which the range check of GLib 2.74 lets pass, changes nothing.
inline void read_value(const GValue *value, double &to) {
  const double read = g_value_get_double(value);
  if (!std::isnan(read))
    to = read;
}

inline void write_value(GValue *value, bool from) {
  g_value_set_boolean(value, from);
}
inline void write_value(GValue *value, guint from) {
  g_value_set_uint(value, from);
}
inline void write_value(GValue *value, double from) {
  g_value_set_double(value, from);
}

template <typename Enum>
struct EnumName {
  Enum value;
  const char *description;
  const char *name;
};

/// Registers the type of an enumeration, which belongs to the interface of the plugin. Once for
/// each; `values` and all texts last as long as the type: for ever.
inline GType register_enum(const char *type_name, std::vector<GEnumValue> &values) {
  values.push_back({0, nullptr, nullptr});
  const GType type = g_enum_register_static(type_name, values.data());
  gst_type_mark_as_plugin_api(type, static_cast<GstPluginAPIFlags>(0));
  return type;
}
template <typename Enum>
GType register_enum(const char *type_name, std::initializer_list<EnumName<Enum>> names) {
  static std::vector<GEnumValue> values;
  for (const auto &[value, description, name] : names)
    values.push_back({static_cast<gint>(value), description, name});
  return register_enum(type_name, values);
}

/// The rows of settings. A property is a member of them, of a member of them and so on, by kPath,
/// and has the default of new settings.
template <typename Settings>
struct Rows {
  using Row = Property<Settings>;

  template <auto... kPath>
  static auto &at(auto &settings) {
    // clang-format off
    return (settings .* ... .* kPath);
    // clang-format on
  }

  template <auto... kPath>
  static Row row(GParamSpec *spec) {
    return {spec, [](Settings &s, const GValue *value) { read_value(value, at<kPath...>(s)); },
            [](const Settings &s, GValue *value) { write_value(value, at<kPath...>(s)); }};
  }

  template <auto... kPath>
  static Row number(const char *name, const char *nick, const char *blurb, double least,
                    double most, GParamFlags flags = kReadWrite) {
    const Settings usual = Settings();
    const auto number = at<kPath...>(usual);
    if constexpr (std::is_same_v<decltype(number), const double>)
      return row<kPath...>(g_param_spec_double(name, nick, blurb, least, most, number, flags));
    else
      return row<kPath...>(g_param_spec_uint(name, nick, blurb, static_cast<guint>(least),
                                             static_cast<guint>(most), number, flags));
  }

  template <auto... kPath>
  static Row flag(const char *name, const char *nick, const char *blurb) {
    const Settings usual = Settings();
    return row<kPath...>(g_param_spec_boolean(name, nick, blurb, at<kPath...>(usual), kReadWrite));
  }

  /// One of an enumeration, or an index that `type` has names for.
  template <auto... kPath>
  static Row choice(const char *name, const char *nick, const char *blurb, GType type,
                    GParamFlags flags = kReadWrite) {
    const Settings usual = Settings();
    GParamSpec *spec =
        g_param_spec_enum(name, nick, blurb, type, static_cast<gint>(at<kPath...>(usual)), flags);
    return {spec,
            [](Settings &s, const GValue *value) {
              auto &place = at<kPath...>(s);
              place =
                  static_cast<std::remove_reference_t<decltype(place)>>(g_value_get_enum(value));
            },
            [](const Settings &s, GValue *value) {
              g_value_set_enum(value, static_cast<gint>(at<kPath...>(s)));
            }};
  }

  /// Takes effect at the next start. NULL stands for the default.
  template <auto... kPath>
  static Row text(const char *name, const char *nick, const char *blurb) {
    const Settings usual = Settings();
    const std::string &text = at<kPath...>(usual);
    return {g_param_spec_string(name, nick, blurb, text.empty() ? nullptr : text.c_str(), kReady),
            [](Settings &s, const GValue *value) {
              const gchar *given = g_value_get_string(value);
              const Settings fresh = Settings();
              at<kPath...>(s) = given ? given : at<kPath...>(fresh);
            },
            [](const Settings &s, GValue *value) {
              const std::string &now = at<kPath...>(s);
              g_value_set_string(value, now.empty() ? nullptr : now.c_str());
            }};
  }
};

/// Declares the properties of `kTable()`, a span of Property<Settings>, and reads and writes them.
/// Row i becomes the property with the number i + 1. `SettingsOf` is a captureless lambda that
/// returns the settings of an element.
template <auto kTable, typename SettingsOf>
void install_properties(GObjectClass *klass, SettingsOf) {
  klass->set_property = [](GObject *object, guint id, const GValue *value, GParamSpec *) {
    guarded(object, [&] {
      const ObjectLock lock(object);
      kTable()[id - 1].set(SettingsOf{}(object), value);
    });
  };
  klass->get_property = [](GObject *object, guint id, GValue *value, GParamSpec *) {
    guarded(object, [&] {
      const ObjectLock lock(object);
      kTable()[id - 1].get(SettingsOf{}(object), value);
    });
  };
  guint id = 0;
  for (const auto &row : kTable())
    g_object_class_install_property(klass, ++id, row.spec);
}

} // namespace haptic
