// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "moving-texture.hpp"
#include "pixels/luma-view.hpp"

namespace test {

inline haptic::LumaView view_of(const Frame &frame) {
  return {frame.pixels.data(), frame.width, frame.height, frame.width};
}

} // namespace test
