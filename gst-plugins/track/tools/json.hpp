// SPDX-License-Identifier: LGPL-2.1-or-later
// JSON as haptic-track reads and writes it.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <type_traits>

namespace haptic {

/// Keeps its keys in the order in which they are written.
using Json = nlohmann::ordered_json;

/// Returns the nearest multiple of 1 / `units`, which has few digits.
inline double rounded(double value, double units) {
  return std::round(value * units) / units;
}

/// A type whose static function members(value, call) calls `call(key, member)` for each member: it
/// names them once, for reading and writing.
template <typename Value>
concept HasMembers = requires(Value &value) {
  Value::members(value, [](const char *, auto &) {});
};

template <HasMembers Value>
void to_json(Json &json, const Value &value) {
  Value::members(value, [&](const char *key, const auto &member) { json[key] = member; });
}

/// Throws if a member is missing or of another kind.
template <HasMembers Value>
void from_json(const Json &json, Value &value) {
  Value::members(value, [&]<typename Member>(const char *key, Member &member) {
    json.at(key).get_to(member);
    if constexpr (std::is_unsigned_v<Member>) // a negative or larger number is another one now
      if (json.at(key).template get_ref<const Json::number_unsigned_t &>() != member)
        throw std::out_of_range(key);
  });
}

} // namespace haptic
