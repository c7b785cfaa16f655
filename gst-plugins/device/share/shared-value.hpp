// SPDX-License-Identifier: LGPL-2.1-or-later
// An atomic that can be copied, so that a struct of them can be replaced as a whole.
#pragma once

#include <atomic>

namespace haptic {

/// Copying is an atomic load followed by an atomic store: each value is whole, a struct of several
/// is not. Use it where one thread writes at a time and others read.
template <typename T>
class SharedValue : public std::atomic<T> {
public:
  SharedValue() noexcept : std::atomic<T>(T{}) {}
  SharedValue(T value) noexcept : std::atomic<T>(value) {} // NOLINT(google-explicit-constructor)
  SharedValue(const SharedValue &other) noexcept : std::atomic<T>(other.load()) {}
  SharedValue &operator=(const SharedValue &other) noexcept {
    this->store(other.load());
    return *this;
  }
  ~SharedValue() = default;
  using std::atomic<T>::operator=;
};

} // namespace haptic
