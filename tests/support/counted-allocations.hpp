// SPDX-License-Identifier: LGPL-2.1-or-later
// Counts what each thread of a program takes from the heap.
#pragma once

namespace test {

extern thread_local long allocations; // of the present thread

} // namespace test
