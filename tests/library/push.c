/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Pushes a simulated hand on with 5 N for 5 s. push-test.sh judges what it prints. */
#include <math.h>
#include <spidar/spidar.h>
#include <stdio.h>

static double length(double x, double y, double z) {
  return sqrt(x * x + y * y + z * z);
}

int main(int argc, char **argv) {
  const double torque[3] = {0, 0, 0};
  double strongest = 0, fastest = 0, work = 0; /* N, N/s, J */
  spidar_options options = SPIDAR_OPTIONS_INIT;
  spidar_limits limits = SPIDAR_LIMITS_INIT;
  spidar_state state = SPIDAR_STATE_INIT;
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  spidar_device *device = NULL;
  options.device = "sim";
  options.sim_hand = argc > 1 ? argv[1] : NULL;
  limits.force = 5;        /* N */
  limits.slew_rate = 1000; /* N/s */
  if (spidar_open(&options, &device) || spidar_set_limits(device, &limits))
    return 1;
  for (int ms = 1; ms <= 5000; ++ms) {
    const double *v = state.velocity, *f = safety.force;
    const double x = f[0], y = f[1], z = f[2], speed = length(v[0], v[1], v[2]) + 1e-9;
    const double force[3] = {5 * v[0] / speed, 5 * v[1] / speed, 5 * v[2] / speed};
    spidar_command(device, force, torque);
    if (spidar_exchange(device, 1000000LL * ms) || spidar_get_state(device, &state) ||
        spidar_get_safety(device, &safety))
      return 1;
    work += fmax(safety.work, 0);
    strongest = fmax(strongest, length(f[0], f[1], f[2]));
    fastest = fmax(fastest, 1e3 * length(f[0] - x, f[1] - y, f[2] - z));
  }
  printf("%.3f N, %.2f N/s, %.3f J. %s\n", strongest, fastest, work,
         spidar_hold_text(safety.holds));
  return spidar_close(device);
}
