// SPDX-License-Identifier: LGPL-2.1-or-later
// A joystick that only the kernel sees (uinput), and what its driver would have been told.
#pragma once

#include <atomic>
#include <chrono>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <linux/uinput.h>
#include <mutex>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/ioctl.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace test {

class VirtualJoystick {
public:
  enum class Force { constant, rumble, none };

  struct Told {
    enum { upload, play, stop, erase } what;
    ff_effect effect; ///< of an upload
    std::chrono::steady_clock::time_point when = std::chrono::steady_clock::now();
  };

  static bool possible() { return access("/dev/uinput", R_OK | W_OK) == 0; }

  explicit VirtualJoystick(Force force = Force::constant, const std::string &name = "Test stick")
      : file_(open("/dev/uinput", O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
    set(UI_SET_EVBIT, EV_KEY);
    set(UI_SET_KEYBIT, BTN_JOYSTICK);
    set(UI_SET_EVBIT, EV_ABS);
    for (const unsigned axis : {ABS_X, ABS_Y}) {
      uinput_abs_setup setup{};
      setup.code = static_cast<std::uint16_t>(axis);
      setup.absinfo.minimum = -kFull;
      setup.absinfo.maximum = kFull;
      set(UI_ABS_SETUP, &setup);
    }
    uinput_setup setup{};
    setup.id.bustype = BUS_VIRTUAL;
    std::strncpy(setup.name, name.c_str(), sizeof setup.name - 1);
    if (force != Force::none) {
      set(UI_SET_EVBIT, EV_FF);
      set(UI_SET_FFBIT, force == Force::constant ? FF_CONSTANT : FF_RUMBLE);
      setup.ff_effects_max = 4;
    }
    set(UI_DEV_SETUP, &setup);
    set(UI_DEV_CREATE, 0);
    driver_ = std::jthread([this](const std::stop_token &stop) { drive(stop); });
    path_ = find_node();
  }
  ~VirtualJoystick() { unplug(); }

  /// "/dev/input/event5"
  const std::string &path() const { return path_; }

  /// -1..1, y down.
  void move(double x, double y) {
    emit(EV_ABS, ABS_X, static_cast<int>(x * kFull));
    emit(EV_ABS, ABS_Y, static_cast<int>(y * kFull));
    emit(EV_SYN, SYN_REPORT, 0);
  }
  void press(bool pressed) {
    emit(EV_KEY, BTN_JOYSTICK, pressed);
    emit(EV_SYN, SYN_REPORT, 0);
  }
  void unplug() {
    driver_ = {};
    if (file_ >= 0)
      close(file_);
    file_ = -1;
  }
  std::vector<Told> told() const {
    const std::lock_guard lock(mutex_);
    return told_;
  }
  std::vector<Told> take_told() {
    const std::lock_guard lock(mutex_);
    return std::exchange(told_, {});
  }

private:
  static constexpr int kFull = 1000;

  template <typename T>
  void set(unsigned long request, T value) {
    if (ioctl(file_, request, value) < 0)
      throw std::runtime_error("uinput: " + std::string(std::strerror(errno)));
  }
  void emit(int type, int code, int value) {
    input_event event{};
    event.type = static_cast<std::uint16_t>(type);
    event.code = static_cast<std::uint16_t>(code);
    event.value = value;
    if (write(file_, &event, sizeof event) != sizeof event)
      throw std::runtime_error("uinput: an event was lost");
  }
  std::string find_node() {
    char input[64] = {};
    set(UI_GET_SYSNAME(sizeof input), input);
    const std::string folder = "/sys/devices/virtual/input/" + std::string(input);
    std::string node;
    DIR *entries = opendir(folder.c_str());
    while (const dirent *entry = entries ? readdir(entries) : nullptr)
      if (std::string(entry->d_name).starts_with("event"))
        node = "/dev/input/" + std::string(entry->d_name);
    if (entries)
      closedir(entries);
    for (int i = 0; i < 100 && access(node.c_str(), F_OK) != 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return node;
  }

  void tell(Told told) {
    const std::lock_guard lock(mutex_);
    told_.push_back(told);
  }
  void drive(const std::stop_token &stop) {
    while (!stop.stop_requested()) {
      pollfd there{.fd = file_, .events = POLLIN, .revents = 0};
      if (poll(&there, 1, 5) <= 0)
        continue;
      input_event event{};
      while (read(file_, &event, sizeof event) == sizeof event)
        answer(event);
    }
  }
  void answer(const input_event &event) {
    if (event.type == EV_FF) {
      tell({event.value ? Told::play : Told::stop, {}});
    } else if (event.type == EV_UINPUT && event.code == UI_FF_UPLOAD) {
      uinput_ff_upload upload{};
      upload.request_id = static_cast<std::uint32_t>(event.value);
      ioctl(file_, UI_BEGIN_FF_UPLOAD, &upload);
      tell({Told::upload, upload.effect});
      ioctl(file_, UI_END_FF_UPLOAD, &upload);
    } else if (event.type == EV_UINPUT && event.code == UI_FF_ERASE) {
      uinput_ff_erase erase{};
      erase.request_id = static_cast<std::uint32_t>(event.value);
      ioctl(file_, UI_BEGIN_FF_ERASE, &erase);
      tell({Told::erase, {}});
      ioctl(file_, UI_END_FF_ERASE, &erase);
    }
  }

  int file_;
  std::string path_;
  mutable std::mutex mutex_;
  std::vector<Told> told_; // mutex_
  std::jthread driver_;    // last: ends before what it uses
};

} // namespace test
