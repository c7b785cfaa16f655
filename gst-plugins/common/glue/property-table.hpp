// SPDX-License-Identifier: LGPL-2.1-or-later
// The properties of an element as a table: one row says how a property is declared, written and
// read.
#pragma once

#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"

#include <cmath>
#include <type_traits>

namespace haptic {

/// One property of an element whose settings are in a `Settings`. The object's lock is held while
/// `set` and `get` run.
template <typename Settings>
struct Property {
  GParamSpec *spec;
  void (*set)(Settings &, const GValue *); ///< null: the property is read-only
  void (*get)(const Settings &, GValue *);
};

template <typename T>
concept Enumeration = std::is_enum_v<T>;

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
template <Enumeration Enum>
void read_value(const GValue *value, Enum &to) {
  to = static_cast<Enum>(g_value_get_enum(value));
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
template <Enumeration Enum>
void write_value(GValue *value, Enum from) {
  g_value_set_enum(value, static_cast<gint>(from));
}

template <typename Member>
struct MemberOwner;
template <typename Settings, typename Value>
struct MemberOwner<Value Settings::*> {
  using type = Settings;
};

/// The row of a property that is a member of the settings, or of a base of them.
template <auto kMember, typename Settings = typename MemberOwner<decltype(kMember)>::type>
auto member_row(GParamSpec *spec) {
  return Property<Settings>{
      spec, [](Settings &s, const GValue *value) { read_value(value, s.*kMember); },
      [](const Settings &s, GValue *value) { write_value(value, s.*kMember); }};
}

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

inline constexpr auto kReadOnly =
    static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS);
inline constexpr auto kReadWrite = static_cast<GParamFlags>(
    G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING);
/// A GstController may change it; see controllers.hpp.
inline constexpr auto kControllable = static_cast<GParamFlags>(kReadWrite | GST_PARAM_CONTROLLABLE);

} // namespace haptic
