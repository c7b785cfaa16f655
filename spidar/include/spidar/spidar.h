/* SPDX-License-Identifier: LGPL-2.1-or-later
 * libspidar for C: a SPIDAR-G on USB, or a simulated one. SI units; origin in the workspace centre,
 * x to the right, y up, z towards the user.
 *
 * A function that returns an int returns SPIDAR_OK or a negative spidar_error, and refuses null
 * pointers. Call those that take a device from one thread. spidar/examples/hold.c shows the order
 * of calls. */
#pragma once

#include "spidar/version.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SPIDAR_C_API __attribute__((visibility("default")))
#define SPIDAR_STRINGS 8

typedef enum spidar_error {
  SPIDAR_OK = 0,
  SPIDAR_E_NOT_FOUND = -1,  /* no such device, geometry or file */
  SPIDAR_E_PERMISSION = -2, /* the device is there but may not be opened */
  SPIDAR_E_BUSY = -3,       /* another program holds the device */
  SPIDAR_E_GEOMETRY = -4,   /* unreadable or impossible geometry */
  SPIDAR_E_ARGUMENT = -5,   /* a value that makes no sense */
  SPIDAR_E_IO = -6,         /* the device answers wrongly or not at all */
  SPIDAR_E_NULL = -7,       /* a pointer is null */
  SPIDAR_E_VERSION = -8,    /* a struct has another size than that of this library */
  SPIDAR_E_MEMORY = -9      /* no memory left, or another error of the system */
} spidar_error;

typedef struct spidar_device spidar_device;

/* Begin with SPIDAR_OPTIONS_INIT. A null text stands for its default. */
typedef struct spidar_options {
  size_t struct_size;   /* sizeof(spidar_options) */
  const char *device;   /* "usb" (default: the first one found), "usb:ID" (rotary switch), "sim" */
  const char *geometry; /* name or file; default "spidar-g6x3r" */
  const char *sim_hand; /* of "sim": "hold:X,Y,Z" (default "hold:0,0,0"), "circle:RADIUS,PERIOD",
                           "file:PATH" or "free" */
  double period;        /* s between two exchanges, 0.00001 to 0.1; 0 stands for 0.001 */
} spidar_options;

/* Begin with SPIDAR_STATE_INIT. */
typedef struct spidar_state {
  size_t struct_size;              /* sizeof(spidar_state) */
  double position[3];              /* m */
  double rotation[9];              /* grip frame to workspace frame, row after row */
  double velocity[3];              /* m/s, low-passed */
  double lengths[SPIDAR_STRINGS];  /* m, of the strings */
  double tensions[SPIDAR_STRINGS]; /* N, as last commanded */
  double force[3];                 /* N, what these tensions do at this pose */
  double torque[3];                /* N m, the same */
  int32_t counts[SPIDAR_STRINGS];
  int32_t valid;              /* 1: the pose was measured */
  int32_t feasible;           /* 1: the commanded force is given within 5 mN */
  int32_t interrupted;        /* 1: minimum tension was set meanwhile: begin from zero */
  int32_t connected;          /* 0: no exchange will succeed any more; close and open again */
  double angular_velocity[3]; /* rad/s, low-passed */
} spidar_state;

/* Versions of clang-format disagree here. */
/* clang-format off */
#ifdef __cplusplus
#define SPIDAR_OPTIONS_INIT {sizeof(spidar_options)}
#define SPIDAR_STATE_INIT {sizeof(spidar_state)}
#else
#define SPIDAR_OPTIONS_INIT {.struct_size = sizeof(spidar_options)}
#define SPIDAR_STATE_INIT {.struct_size = sizeof(spidar_state)}
#endif
/* clang-format on */

/* "0.1.0": of the library, where SPIDAR_VERSION is that of the headers. */
SPIDAR_C_API const char *spidar_version(void);

/* What a code means, and the cure. Also of a code that is not known. */
SPIDAR_C_API const char *spidar_error_text(int code);

/* What the last failed spidar_open() of this thread had to say, with the cure: the file, the udev
 * line, the program that holds the device. Empty if none has failed. Valid until the next one. */
SPIDAR_C_API const char *spidar_open_error(void);

/* Opens a device, sets minimum tension, and takes the place of the grip as the centre. */
SPIDAR_C_API int spidar_open(const spidar_options *options, spidar_device **device);

/* Leaves minimum tension behind. `device` is gone afterwards. */
SPIDAR_C_API int spidar_close(spidar_device *device);

/* "SPIDAR-G, controller USB2.0 SH4, switch 2, USB 1-5". Valid until spidar_close(). */
SPIDAR_C_API int spidar_describe(const spidar_device *device, const char **text);

/* One tick at `now` (ns, of CLOCK_MONOTONIC; for a simulated device, of a clock of your own): sends
 * the last command, receives the pose. SPIDAR_E_IO if the device did not answer. Call it once a
 * period: it does not wait. Real-time safe. */
SPIDAR_C_API int spidar_exchange(spidar_device *device, int64_t now);

/* The state after the last exchange. Real-time safe. */
SPIDAR_C_API int spidar_get_state(const spidar_device *device, spidar_state *state);

/* Force (N) and torque (N m) that the next exchange sends. The tensions of the strings keep within
 * the limits of the geometry, and nothing else is limited: neither force, work, change nor speed of
 * the grip, as hapticsink does. A wrench that is not finite counts as zero. Real-time safe. */
SPIDAR_C_API int spidar_command(spidar_device *device, const double force[3],
                                const double torque[3]);

/* Takes the present place of the grip as the centre and its orientation as the identity.
 * Real-time safe. */
SPIDAR_C_API int spidar_calibrate(spidar_device *device);

/* m from the centre: what the workspace is on each axis. */
SPIDAR_C_API int spidar_workspace(const spidar_device *device, double half[3]);

#ifdef __cplusplus
}
#endif
