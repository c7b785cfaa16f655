// SPDX-License-Identifier: LGPL-2.1-or-later
// Linked into a test, this answers libusb's ioctl() calls in the caller's own thread. umockdev
// still shows the bus, but an exchange costs what libusb and we make of it, and not what umockdev
// does.
#include "mock-bus.hpp"

#include <cstdarg>
#include <dlfcn.h>

namespace test {

std::atomic<MockBus *> direct_bus = nullptr;

} // namespace test

extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void *argument = va_arg(arguments, void *);
  va_end(arguments);
  if (test::MockBus *bus = test::direct_bus)
    if (const auto result = bus->ioctl(descriptor, request, argument))
      return *result;
  using Ioctl = int (*)(int, unsigned long, ...);
  static const auto next = reinterpret_cast<Ioctl>(dlsym(RTLD_NEXT, "ioctl"));
  return next(descriptor, request, argument);
}
