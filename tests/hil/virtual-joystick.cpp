// SPDX-License-Identifier: LGPL-2.1-or-later
// A virtual joystick with force feedback (uinput). Prints the commands to its driver, one a line,
// until its input ends. A line "X Y PRESSED" of the input moves the stick (-1..1, y down) and
// presses (1) or releases (0) its button.
//
//   virtual-joystick
#include "virtual-joystick.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace {

void print(const test::VirtualJoystick::Told &told) {
  using Told = test::VirtualJoystick::Told;
  switch (told.what) {
  case Told::upload:
    std::printf("upload level %d direction %u length %u\n", told.effect.u.constant.level,
                told.effect.direction, told.effect.replay.length);
    break;
  case Told::play:
    std::printf("play\n");
    break;
  case Told::stop:
    std::printf("stop\n");
    break;
  case Told::erase:
    std::printf("erase\n");
    break;
  }
}

} // namespace

int main() {
  test::VirtualJoystick stick;
  std::printf("%s\n", stick.path().c_str());
  std::fflush(stdout);
  std::jthread printer([&](const std::stop_token &stop) {
    for (bool last = false; !last;) {
      last = stop.stop_requested();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      std::ranges::for_each(stick.take_told(), print);
      std::fflush(stdout);
    }
  });
  double x = 0;
  double y = 0;
  bool pressed = false;
  while (std::cin >> x >> y >> pressed) {
    stick.move(std::clamp(x, -1.0, 1.0), std::clamp(y, -1.0, 1.0));
    stick.press(pressed);
  }
}
