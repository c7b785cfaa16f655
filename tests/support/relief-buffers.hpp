// SPDX-License-Identifier: LGPL-2.1-or-later
// Reliefs in buffers.
#pragma once

#include "glue/gst-raii.hpp"
#include "samples/relief-field.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace test {

/// The relief that a buffer holds, and nothing else.
inline haptic::ReliefField relief_of(const haptic::BufferPtr &buffer) {
  haptic::ReliefField relief;
  EXPECT_TRUE(buffer);
  if (!buffer)
    return relief;
  GstMapInfo map;
  gst_buffer_map(buffer.get(), &map, GST_MAP_READ);
  EXPECT_TRUE(haptic::unpack_relief_field({map.data, map.size}, relief));
  EXPECT_EQ(map.size, haptic::packed_size(relief));
  gst_buffer_unmap(buffer.get(), &map);
  return relief;
}

inline bool is_silent(const haptic::ReliefField &relief) {
  return std::ranges::all_of(relief.cells,
                             [](const auto &cell) { return cell == haptic::ReliefCell{}; });
}

} // namespace test
