// SPDX-License-Identifier: LGPL-2.1-or-later
// Owns a file descriptor.
#pragma once

#include <utility>

namespace spidar {

class FileDescriptor {
public:
  explicit FileDescriptor(int value = -1) noexcept : value_(value) {}
  ~FileDescriptor() { reset(); }
  FileDescriptor(FileDescriptor &&other) noexcept : value_(std::exchange(other.value_, -1)) {}
  FileDescriptor &operator=(FileDescriptor &&other) noexcept {
    reset(std::exchange(other.value_, -1));
    return *this;
  }
  int get() const noexcept { return value_; }
  void reset(int value = -1) noexcept;

private:
  int value_;
};

} // namespace spidar
