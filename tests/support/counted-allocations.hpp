// SPDX-License-Identifier: LGPL-2.1-or-later
// Counts what a program takes from the heap: in one source file of it.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace test {

inline std::atomic<long> allocations = 0;

} // namespace test

// NOLINTBEGIN(cppcoreguidelines-no-malloc, cppcoreguidelines-owning-memory)
void *operator new(std::size_t size) {
  ++test::allocations;
  if (void *memory = std::malloc(size))
    return memory;
  throw std::bad_alloc();
}
void operator delete(void *memory) noexcept {
  std::free(memory);
}
void operator delete(void *memory, std::size_t /*size*/) noexcept {
  std::free(memory);
}
// NOLINTEND(cppcoreguidelines-no-malloc, cppcoreguidelines-owning-memory)
