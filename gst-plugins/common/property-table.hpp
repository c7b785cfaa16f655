// SPDX-License-Identifier: LGPL-2.1-or-later
// The properties of an element as a table: one row says how a property is declared, written and
// read.
#pragma once

#include "gst-raii.hpp"

#include <span>
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

inline void read_value(const GValue *value, bool &to) {
  to = g_value_get_boolean(value) != FALSE;
}
inline void read_value(const GValue *value, guint &to) {
  to = g_value_get_uint(value);
}
inline void read_value(const GValue *value, double &to) {
  to = g_value_get_double(value);
}
template <typename Enum>
requires std::is_enum_v<Enum>
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
template <typename Enum>
requires std::is_enum_v<Enum>
void write_value(GValue *value, Enum from) {
  g_value_set_enum(value, static_cast<gint>(from));
}

template <typename Member>
struct MemberOwner;
template <typename Settings, typename Value>
struct MemberOwner<Value Settings::*> {
  using type = Settings;
};

/// The row of a property that is a member of the settings.
template <auto kMember>
auto member_row(GParamSpec *spec) {
  using Settings = typename MemberOwner<decltype(kMember)>::type;
  return Property<Settings>{
      spec, [](Settings &s, const GValue *value) { read_value(value, s.*kMember); },
      [](const Settings &s, GValue *value) { write_value(value, s.*kMember); }};
}

/// Row i becomes the property with the number i + 1.
template <typename Settings>
void install_properties(GObjectClass *klass, std::span<const Property<Settings>> table) {
  guint id = 0;
  for (const Property<Settings> &row : table)
    g_object_class_install_property(klass, ++id, row.spec);
}

/// For GObjectClass::set_property.
template <typename Settings>
void set_property(GObject *object, guint id, const GValue *value,
                  std::span<const Property<Settings>> table, Settings &settings) {
  const ObjectLock lock(object);
  table[id - 1].set(settings, value);
}

/// For GObjectClass::get_property.
template <typename Settings>
void get_property(GObject *object, guint id, GValue *value,
                  std::span<const Property<Settings>> table, const Settings &settings) {
  const ObjectLock lock(object);
  table[id - 1].get(settings, value);
}

inline constexpr auto kReadOnly =
    static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS);
inline constexpr auto kReadWrite = static_cast<GParamFlags>(
    G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING);
inline constexpr auto kControllable = static_cast<GParamFlags>(kReadWrite | GST_PARAM_CONTROLLABLE);

} // namespace haptic
