// SPDX-License-Identifier: LGPL-2.1-or-later
// The C API: arguments checked, exceptions turned into codes.
#include "device-name.hpp"
#include "fail.hpp"
#include "spidar/device.hpp"
#include "spidar/limited-device.hpp"
#include "spidar/spidar.h"

#include <algorithm>

struct spidar_device {
  spidar_device(std::unique_ptr<spidar::Controller> controller, const spidar::Geometry &geometry,
                double period)
      : description(controller->description()), device(std::move(controller), geometry, period),
        limited(device, period) {}

  std::string description;
  spidar::Device device;
  spidar::LimitedDevice limited;
};

namespace {

using namespace spidar;

// Programs are compiled with these sizes: a new member changes them, and then also SONAME or a way
// to read the old struct is needed.
static_assert(sizeof(void *) < 8 || sizeof(spidar_options) == 40);
static_assert(sizeof(void *) < 8 || sizeof(spidar_state) == 376);
static_assert(sizeof(void *) < 8 || sizeof(spidar_limits) == 48);
static_assert(sizeof(void *) < 8 || sizeof(spidar_safety) == 80);

int code_of(Cause cause) noexcept {
  switch (cause) {
  case Cause::not_found:
    return SPIDAR_E_NOT_FOUND;
  case Cause::permission:
    return SPIDAR_E_PERMISSION;
  case Cause::busy:
    return SPIDAR_E_BUSY;
  case Cause::geometry:
    return SPIDAR_E_GEOMETRY;
  case Cause::argument:
    return SPIDAR_E_ARGUMENT;
  case Cause::io:
    break;
  }
  return SPIDAR_E_IO;
}

/// Of the thread's last failed spidar_open(). An array: it cannot fail to be made.
struct OpenError {
  char text[2048];

  int set(int code, const char *what) noexcept {
    std::snprintf(text, sizeof text, "%s", what);
    return code;
  }
};

OpenError &open_error() noexcept {
  thread_local OpenError error{};
  return error;
}

std::string text_or(const char *text, const char *otherwise) {
  return text ? text : otherwise;
}

std::unique_ptr<spidar_device> open(const spidar_options &options) {
  const double period = options.period == 0 ? 0.001 : options.period;
  const Geometry geometry = load_geometry(text_or(options.geometry, kDefaultGeometry));
  auto controller = open_controller(text_or(options.device, "usb"), geometry,
                                    text_or(options.sim_hand, "hold:0,0,0"), period);
  return std::make_unique<spidar_device>(std::move(controller), geometry, period);
}

template <class Vector>
void copy(const Vector &from, double *to) noexcept {
  std::copy(from.data(), from.data() + from.size(), to);
}

} // namespace

extern "C" {

const char *spidar_version(void) {
  return SPIDAR_VERSION;
}

const char *spidar_error_text(int code) {
  switch (code) {
  case SPIDAR_OK:
    return "All is well.";
  case SPIDAR_E_NOT_FOUND:
    return messages::kCodeNotFound;
  case SPIDAR_E_PERMISSION:
    return messages::kCodePermission;
  case SPIDAR_E_BUSY:
    return messages::kCodeBusy;
  case SPIDAR_E_GEOMETRY:
    return messages::kCodeGeometry;
  case SPIDAR_E_ARGUMENT:
    return messages::kCodeArgument;
  case SPIDAR_E_IO:
    return messages::kCodeIo;
  case SPIDAR_E_NULL:
    return messages::kCodeNull;
  case SPIDAR_E_VERSION:
    return messages::kCodeVersion;
  case SPIDAR_E_MEMORY:
    return messages::kCodeMemory;
  default:
    return messages::kCodeUnknown;
  }
}

const char *spidar_open_error(void) {
  return open_error().text;
}

int spidar_open(const spidar_options *options, spidar_device **device) {
  if (device)
    *device = nullptr;
  if (!options || !device)
    return open_error().set(SPIDAR_E_NULL, messages::kCodeNull);
  if (options->struct_size != sizeof *options)
    return open_error().set(SPIDAR_E_VERSION, messages::kCodeVersion);
  try {
    *device = open(*options).release();
    return SPIDAR_OK;
  } catch (const Error &error) {
    return open_error().set(code_of(error.cause()), error.what());
  } catch (const std::exception &) {
    return open_error().set(SPIDAR_E_MEMORY, messages::kCodeMemory);
  }
}

int spidar_close(spidar_device *device) {
  if (!device)
    return SPIDAR_E_NULL;
  const std::unique_ptr<spidar_device> closed(device);
  return SPIDAR_OK;
}

int spidar_describe(const spidar_device *device, const char **text) {
  if (!device || !text)
    return SPIDAR_E_NULL;
  *text = device->description.c_str();
  return SPIDAR_OK;
}

int spidar_exchange(spidar_device *device, int64_t now) {
  if (!device)
    return SPIDAR_E_NULL;
  return device->limited.exchange(now) ? SPIDAR_OK : SPIDAR_E_IO;
}

int spidar_get_state(const spidar_device *device, spidar_state *state) {
  if (!device || !state)
    return SPIDAR_E_NULL;
  if (state->struct_size != sizeof *state)
    return SPIDAR_E_VERSION;
  const DeviceState &from = device->device.state();
  copy(from.pose.position, state->position);
  copy(Matrix3(from.pose.rotation.transpose()), state->rotation); // Eigen stores columns
  copy(from.velocity, state->velocity);
  copy(from.angular_velocity, state->angular_velocity);
  copy(from.lengths, state->lengths);
  copy(from.tensions, state->tensions);
  copy(from.realised.force, state->force);
  copy(from.realised.torque, state->torque);
  std::copy(from.counts.begin(), from.counts.end(), state->counts);
  state->valid = from.valid;
  state->feasible = from.feasible;
  state->interrupted = from.interrupted;
  state->connected = device->device.connected();
  return SPIDAR_OK;
}

int spidar_command(spidar_device *device, const double force[3], const double torque[3]) {
  if (!device || !force || !torque)
    return SPIDAR_E_NULL;
  device->limited.command({Vector3(force), Vector3(torque)});
  return SPIDAR_OK;
}

int spidar_get_safety(const spidar_device *device, spidar_safety *safety) {
  if (!device || !safety)
    return SPIDAR_E_NULL;
  if (safety->struct_size != sizeof *safety)
    return SPIDAR_E_VERSION;
  const LimitedDevice &from = device->limited;
  copy(from.wrench().force, safety->force);
  copy(from.wrench().torque, safety->torque);
  const DeviceState &state = device->device.state();
  safety->work = state.acted.force.dot(state.moved) + state.acted.torque.dot(state.turned);
  safety->holds = from.holds();
  safety->limited_by = from.limited_by();
  safety->switched_off = from.switched_off();
  safety->armed = from.armed();
  return SPIDAR_OK;
}

const char *spidar_hold_text(uint32_t holds) {
  static constexpr struct {
    spidar_hold hold;
    const char *text;
  } kTexts[] = {
      {SPIDAR_HOLD_FAULTED, messages::kHoldFaulted},
      {SPIDAR_HOLD_LET_GO, messages::kHoldLetGo},
      {SPIDAR_HOLD_RELEASED, messages::kHoldReleased},
      {SPIDAR_HOLD_SLIPPED, messages::kHoldSlipped},
      {SPIDAR_HOLD_NO_POSE, messages::kHoldNoPose},
      {SPIDAR_HOLD_LATE, messages::kHoldLate},
      {SPIDAR_HOLD_NOT_FINITE, messages::kHoldNotFinite},
  };
  for (const auto &[hold, text] : kTexts)
    if (holds & hold)
      return text;
  return "";
}

int spidar_set_limits(spidar_device *device, const spidar_limits *limits) {
  if (!device || !limits)
    return SPIDAR_E_NULL;
  if (limits->struct_size != sizeof *limits)
    return SPIDAR_E_VERSION;
  const ForceLimits wanted{.force = limits->force,
                           .torque = limits->torque,
                           .continuous_force = limits->continuous_force,
                           .slew_rate = limits->slew_rate,
                           .damping = limits->damping};
  if (!wanted.are_possible())
    return SPIDAR_E_ARGUMENT;
  device->limited.set_limits(wanted);
  return SPIDAR_OK;
}

int spidar_arm(spidar_device *device) {
  if (!device)
    return SPIDAR_E_NULL;
  device->limited.arm();
  return SPIDAR_OK;
}

int spidar_release(spidar_device *device) {
  if (!device)
    return SPIDAR_E_NULL;
  device->limited.release();
  return SPIDAR_OK;
}

int spidar_switch_off_safety(spidar_device *device, uint32_t parts) {
  if (!device)
    return SPIDAR_E_NULL;
  device->limited.switch_off_safety(parts);
  return SPIDAR_OK;
}

int spidar_calibrate(spidar_device *device) {
  if (!device)
    return SPIDAR_E_NULL;
  device->device.calibrate();
  return SPIDAR_OK;
}

int spidar_workspace(const spidar_device *device, double half[3]) {
  if (!device || !half)
    return SPIDAR_E_NULL;
  copy(device->device.workspace_half(), half);
  return SPIDAR_OK;
}

} // extern "C"
