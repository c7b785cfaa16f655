// SPDX-License-Identifier: LGPL-2.1-or-later
#include "guard/file-descriptor.hpp"

#include <unistd.h>

namespace spidar {

void FileDescriptor::reset(int value) noexcept {
  if (value_ >= 0)
    close(value_);
  value_ = value;
}

} // namespace spidar
