// SPDX-License-Identifier: LGPL-2.1-or-later
// Counts what each thread of a program takes from the heap. For one source file of a program.
#pragma once

#include <cstdlib>
#include <new>

namespace test {

inline thread_local long allocations = 0; // of the present thread

} // namespace test

// Inlined, the pair would look mismatched to the compiler.
// NOLINTBEGIN(cppcoreguidelines-no-malloc, cppcoreguidelines-owning-memory)
[[gnu::noinline]] void *operator new(std::size_t size) {
  ++test::allocations;
  if (void *memory = std::malloc(size))
    return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void *operator new(std::size_t size, const std::nothrow_t & /*tag*/) noexcept {
  ++test::allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void *memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void *memory, std::size_t /*size*/) noexcept {
  std::free(memory);
}
// NOLINTEND(cppcoreguidelines-no-malloc, cppcoreguidelines-owning-memory)
