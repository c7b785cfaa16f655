/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Holds the grip at the centre with a spring, for a second, and says what stopped the force if
 * something did. The library fades the force in, and limits it. Example:
 *   cc -std=c11 hold.c $(pkg-config --cflags --libs spidar) -o hold && ./hold usb */
#define _POSIX_C_SOURCE 200809L /* NOLINT: POSIX reserves it for this */
#include <spidar/spidar.h>
#include <stdio.h>
#include <time.h>

static const double kStiffness = 40;  /* N/m */
static const int kTicks = 1000;       /* one second */
static const long kPeriod = 1000000L; /* ns */

static void wait_for(struct timespec *next) {
  next->tv_nsec += kPeriod;
  if (next->tv_nsec >= 1000000000L) {
    next->tv_nsec -= 1000000000L;
    ++next->tv_sec;
  }
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, next, NULL);
}

/* The force that pulls back to the centre; none where the pose is not known. */
static void spring(const spidar_state *state, double force[3]) {
  for (int axis = 0; axis < 3; ++axis)
    force[axis] = state->valid ? -kStiffness * state->position[axis] : 0;
}

static int hold(spidar_device *device) {
  const double torque[3] = {0, 0, 0};
  double force[3] = {0, 0, 0};
  spidar_state state = SPIDAR_STATE_INIT;
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  spidar_limits limits = SPIDAR_LIMITS_INIT;
  limits.force = 0.5; /* N */
  int code = spidar_set_limits(device, &limits);
  struct timespec next, now;
  clock_gettime(CLOCK_MONOTONIC, &next);
  for (int tick = 0; tick < kTicks && code == SPIDAR_OK; ++tick) {
    clock_gettime(CLOCK_MONOTONIC, &now); /* a tick may be late */
    code = spidar_exchange(device, 1000000000LL * now.tv_sec + now.tv_nsec);
    if (code == SPIDAR_OK)
      code = spidar_get_state(device, &state);
    if (code != SPIDAR_OK)
      return code;
    spring(&state, force);
    spidar_command(device, force, torque);
    wait_for(&next);
  }
  printf("grip at %.1f %.1f %.1f mm, force %.2f %.2f %.2f N\n", 1e3 * state.position[0],
         1e3 * state.position[1], 1e3 * state.position[2], state.force[0], state.force[1],
         state.force[2]);
  if (code == SPIDAR_OK)
    code = spidar_get_safety(device, &safety);
  if (safety.holds)
    printf("%s\n", spidar_hold_text(safety.holds));
  return code;
}

int main(int argc, char **argv) {
  spidar_options options = SPIDAR_OPTIONS_INIT;
  options.device = argc > 1 ? argv[1] : "usb";
  options.sim_hand = argc > 2 ? argv[2] : NULL;
  spidar_device *device = NULL;
  if (spidar_open(&options, &device) != SPIDAR_OK) {
    fprintf(stderr, "%s\n", spidar_open_error());
    return 1;
  }
  const char *name = "";
  spidar_describe(device, &name);
  printf("%s, libspidar %s\n", name, spidar_version());
  const int code = hold(device);
  if (code != SPIDAR_OK)
    fprintf(stderr, "%s\n", spidar_error_text(code));
  spidar_close(device);
  return code == SPIDAR_OK ? 0 : 1;
}
