/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Pushes a simulated hand on with 5 N wherever it goes, for 5 s of the simulation, and prints what
 * came of it. push-test.sh judges that. */
#include <math.h>
#include <spidar/spidar.h>
#include <stdio.h>

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
  limits.force = 5;
  limits.slew_rate = 1000;
  if (spidar_open(&options, &device) != SPIDAR_OK ||
      spidar_set_limits(device, &limits) != SPIDAR_OK)
    return 1;
  for (int ms = 1; ms <= 5000; ++ms) {
    const spidar_safety before = safety;
    const double *v = state.velocity;
    const double speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + 1e-9;
    const double force[3] = {5 * v[0] / speed, 5 * v[1] / speed, 5 * v[2] / speed};
    spidar_command(device, force, torque);
    if (spidar_exchange(device, 1000000LL * ms) != SPIDAR_OK ||
        spidar_get_state(device, &state) != SPIDAR_OK ||
        spidar_get_safety(device, &safety) != SPIDAR_OK)
      return 1;
    double square = 0, change = 0;
    for (int axis = 0; axis < 3; ++axis) {
      square += pow(safety.force[axis], 2);
      change += pow(safety.force[axis] - before.force[axis], 2);
    }
    work += fmax(safety.work, 0);
    strongest = fmax(strongest, sqrt(square));
    fastest = fmax(fastest, 1e3 * sqrt(change));
  }
  printf("%.3f N, %.2f N/s, %.3f J. %s\n", strongest, fastest, work,
         spidar_hold_text(safety.holds));
  return spidar_close(device);
}
