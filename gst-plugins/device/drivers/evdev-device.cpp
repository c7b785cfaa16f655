// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/evdev-device.hpp"

#include "drivers/evdev-list.hpp"
#include "drivers/force-effect.hpp"
#include "drivers/stick.hpp"
#include "format-text.hpp"
#include "messages.hpp"
#include "non-blocking.hpp"
#include "share/newest-slot.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <libevdev/libevdev.h>
#include <numbers>
#include <poll.h>
#include <spidar/error.hpp>
#include <sys/ioctl.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>

namespace haptic {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
using spidar::Cause;
using spidar::Error;

constexpr auto kRound = 8ms;           // 125 Hz: more is too much for old drivers
constexpr auto kReplay = 40ms;         // well before an effect of 100 ms is over
constexpr auto kLoopStands = 100ms;    // then the force is zero
constexpr auto kDriverStands = 300ms;  // then the device does not answer; its effect is over
constexpr double kStickHalf = 0.04;    // m, travel of the top of a stick to either side
constexpr double kVelocityCutoff = 10; // Hz; the stick reports its position some 100 times a second

struct CloseFile {
  int file = -1;
  ~CloseFile() {
    if (file >= 0)
      close(file);
  }
};

struct FreeEvdev {
  void operator()(libevdev *device) const noexcept { libevdev_free(device); }
};

std::string description_of(const EvdevUnit &unit) {
  return "\"" + unit.name + "\" (" + unit.path + ")";
}

int open_node(const std::string &path) {
  const int file = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file >= 0)
    return file;
  switch (errno) {
  case EACCES:
  case EPERM:
    throw Error(Cause::permission, format_text(messages::kJoystickForbidden, path.c_str()));
  case ENOENT:
  case ENODEV:
  case ENXIO:
  case ENOTDIR:
    throw Error(Cause::not_found, format_text(messages::kNoInputDevice, path.c_str()));
  default:
    throw Error(Cause::io, format_text(messages::kInputNotOpened, path.c_str(),
                                       std::generic_category().message(errno).c_str()));
  }
}

EvdevUnit unit_of(const std::string &path, const libevdev *device) {
  const char *serial = libevdev_get_uniq(device);
  const std::string name = libevdev_get_name(device);
  return {path, name,
          format_text("%04x %04x %04x %04x %s %s", libevdev_get_id_bustype(device),
                      libevdev_get_id_vendor(device), libevdev_get_id_product(device),
                      libevdev_get_id_version(device), serial ? serial : "", name.c_str())};
}

class EvdevDevice final : public spidar::HapticDevice {
public:
  EvdevDevice(const std::string &path, bool needs_button) : file_{open_node(path)} {
    libevdev *device = nullptr;
    if (libevdev_new_from_fd(file_.file, &device) != 0)
      throw Error(Cause::argument, format_text(messages::kNotAnInput, path.c_str()));
    evdev_.reset(device);
    unit_ = unit_of(path, device);
    stick_ = Stick(device);
    if (libevdev_has_event_code(device, EV_FF, FF_CONSTANT))
      kind_ = ForceKind::constant;
    else if (libevdev_has_event_code(device, EV_FF, FF_RUMBLE))
      kind_ = ForceKind::rumble;
    else
      throw Error(Cause::argument,
                  format_text(messages::kNoForceFeedback, description_of(unit_).c_str()));
    if (!stick_.has_x())
      throw Error(Cause::argument, format_text(messages::kNoStick, description_of(unit_).c_str()));
    limits_.force = kFullForce;
    limits_.degrees_of_freedom = stick_.has_y() ? 2 : 1;
    limits_.metres_per_count = kStickHalf * stick_.step();
    if (needs_button && !stick_.has_button())
      throw Error(Cause::argument, format_text(messages::kNoButton, description_of(unit_).c_str()));
    if (libevdev_grab(device, LIBEVDEV_GRAB) != 0)
      throw Error(Cause::busy, format_text(messages::kJoystickBusy, description_of(unit_).c_str()));
    upload(spidar::Vector3::Zero()); // fails now if the driver refuses effects
    publish();
    round_at_ = tick_at_ = spidar::monotonic_time();
    exchange(tick_at_);
    state_.velocity.setZero();
    driver_ = std::jthread([this](const std::stop_token &stop) { run(stop); });
  }

  ~EvdevDevice() override {
    driver_ = {};
    if (!gone_)
      ioctl(file_.file, EVIOCRMFF, effect_.id); // which stops it
  }

  // ---- the loop's thread ------------------------------------------------------------------------

  bool exchange(std::int64_t now) noexcept HAPTIC_NONBLOCKING override {
    tick_at_.store(now);
    const bool answered =
        connected() && now - round_at_.load() < std::chrono::nanoseconds(kDriverStands).count();
    state_.valid = answered;
    state_.pressed = state_.pressed && answered;
    state_.moved.setZero();
    if (!answered)
      return false;
    stick_state_.refresh();
    const StickState &stick = stick_state_.value();
    const spidar::Vector3 position = kStickHalf * (stick.place - centre_);
    state_.moved = position - state_.pose.position;
    state_.acted.force = commanded_;
    if (const double dt = static_cast<double>(now - exchanged_at_) * 1e-9; dt > 0) {
      const double share = 1 - std::exp(-2 * std::numbers::pi * kVelocityCutoff * dt);
      state_.velocity += share * (state_.moved / dt - state_.velocity);
    }
    exchanged_at_ = now;
    state_.pose.position = position;
    state_.pressed = stick.pressed;
    return true;
  }
  bool connected() const noexcept override { return !gone_.load(); }
  void command(const spidar::Wrench &wrench) noexcept HAPTIC_NONBLOCKING override {
    commanded_ = wrench.force;
    force_.write(wrench.force);
  }
  void calibrate() noexcept override {
    centre_ = stick_state_.value().place;
    state_.pose.position.setZero();
    state_.velocity.setZero();
  }
  const spidar::DeviceState &state() const noexcept override { return state_; }
  const spidar::Vector3 &workspace_half() const noexcept override { return workspace_half_; }
  const spidar::DeviceLimits &limits() const noexcept override { return limits_; }
  std::string description() const override { return description_of(unit_); }
  std::string identity() const override { return unit_.identity; }

private:
  // ---- the driver's thread ----------------------------------------------------------------------

  void run(const std::stop_token &stop) noexcept {
    while (!stop.stop_requested() && !gone_) {
      read_events();
      publish();
      force_.refresh();
      const bool loop_stands = spidar::monotonic_time() - tick_at_.load() >
                               std::chrono::nanoseconds(kLoopStands).count();
      const spidar::Vector3 none = spidar::Vector3::Zero();
      if (play(loop_stands ? none : force_.value()))
        round_at_.store(spidar::monotonic_time());
      std::this_thread::sleep_for(kRound);
    }
    if (!gone_)
      play(spidar::Vector3::Zero());
  }

  void read_events() noexcept {
    pollfd there{.fd = file_.file, .events = POLLIN, .revents = 0};
    if (poll(&there, 1, 0) > 0 && (there.revents & (POLLERR | POLLHUP | POLLNVAL)))
      gone_ = true;
    input_event event{};
    unsigned mode = LIBEVDEV_READ_FLAG_NORMAL;
    // libevdev keeps the positions of the axes; after too many events at once it reads them anew.
    for (;;) {
      const int result = libevdev_next_event(evdev_.get(), mode, &event);
      if (result == LIBEVDEV_READ_STATUS_SYNC) {
        mode = LIBEVDEV_READ_FLAG_SYNC;
      } else if (result == -EAGAIN && mode == LIBEVDEV_READ_FLAG_SYNC) {
        mode = LIBEVDEV_READ_FLAG_NORMAL;
      } else if (result < 0) {
        gone_ = gone_ || result == -ENODEV;
        return;
      }
    }
  }

  void publish() noexcept { stick_state_.write(stick_.read(evdev_.get())); }

  // Returns false if the driver refuses. The present effect then ends by itself.
  bool play(const spidar::Vector3 &force) noexcept {
    const ff_effect wanted = force_effect(force, kind_, stick_.has_y(), effect_.id);
    if (!feels_alike(wanted, effect_) && !send(wanted))
      return false;
    if (is_silent(effect_))
      return !playing_ || set_playing(false);
    return (playing_ && Clock::now() - played_ < kReplay) || set_playing(true);
  }

  bool send(ff_effect effect) noexcept {
    if (ioctl(file_.file, EVIOCSFF, &effect) != 0) {
      gone_ = gone_ || errno == ENODEV;
      return false;
    }
    effect_ = effect;
    return true;
  }

  bool set_playing(bool on) noexcept {
    input_event event{};
    event.type = EV_FF;
    event.code = static_cast<std::uint16_t>(effect_.id);
    event.value = on ? 1 : 0;
    if (write(file_.file, &event, sizeof event) != sizeof event) {
      gone_ = gone_ || errno == ENODEV;
      return false;
    }
    playing_ = on;
    played_ = Clock::now();
    return true;
  }

  // ---- opening ----------------------------------------------------------------------------------

  void upload(const spidar::Vector3 &force) {
    if (send(force_effect(force, kind_, stick_.has_y(), -1)))
      return;
    const int error = errno;
    if (error == ENOSPC)
      throw Error(Cause::busy,
                  format_text(messages::kNoRoomForEffect, description_of(unit_).c_str()));
    throw Error(Cause::io, format_text(messages::kForceRefused, description_of(unit_).c_str(),
                                       std::generic_category().message(error).c_str()));
  }

  // Before the driver's thread starts, and then read by both.
  CloseFile file_;
  EvdevUnit unit_;
  ForceKind kind_ = ForceKind::constant;
  const spidar::Vector3 workspace_half_ = spidar::Vector3::Constant(kStickHalf);
  spidar::DeviceLimits limits_; // no stiffness and no damping: its strength is unknown

  // Between the two threads.
  NewestSlot<StickState> stick_state_; // driver's thread -> loop
  NewestSlot<spidar::Vector3> force_;  // N: loop -> driver's thread
  std::atomic<std::int64_t> round_at_ = 0;
  std::atomic<std::int64_t> tick_at_ = 0;
  std::atomic<bool> gone_ = false;

  // The loop's thread.
  spidar::DeviceState state_;
  spidar::Vector3 centre_ = spidar::Vector3::Zero();
  spidar::Vector3 commanded_ = spidar::Vector3::Zero(); // N, nominal
  std::int64_t exchanged_at_ = 0;                       // ns

  // The driver's thread.
  std::unique_ptr<libevdev, FreeEvdev> evdev_;
  Stick stick_;
  ff_effect effect_{};
  bool playing_ = false;
  Clock::time_point played_;

  std::jthread driver_; // last: ends before what it uses
};

std::string first_evdev(const std::string &path) {
  if (!path.empty())
    return path;
  const EvdevUnits units = list_evdev();
  if (!units.with_force.empty())
    return units.with_force.front().path;
  std::string others;
  for (const EvdevUnit &unit : units.without)
    others += " " + description_of(unit) + " has none.";
  throw Error(Cause::not_found, format_text(messages::kNoJoystick, others.c_str()));
}

} // namespace

std::unique_ptr<spidar::HapticDevice> open_evdev(const std::string &path, bool needs_button) {
  return std::make_unique<EvdevDevice>(first_evdev(path), needs_button);
}

} // namespace haptic
