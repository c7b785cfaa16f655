/* SPDX-License-Identifier: LGPL-2.1-or-later
 * libspidar for C: a SPIDAR-G on USB, or a simulated one. SI units; origin in the workspace centre,
 * x to the right, y up, z towards the user.
 *
 * A function that returns an int returns SPIDAR_OK or a negative spidar_error, and refuses null
 * pointers. Call those that take a device from one thread, if they do not say otherwise.
 * spidar/examples/hold.c shows the order of calls. */
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
  double period;        /* s between two exchanges, 0.00001 to 0.1; 0 stands for 0.001. Above 0.01
                           there is no force (SPIDAR_HOLD_LATE) */
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
  int32_t interrupted;        /* 1: the motors were put at rest: begin from zero */
  int32_t connected;          /* 0: no exchange will succeed any more; close and open again */
  double angular_velocity[3]; /* rad/s, low-passed */
} spidar_state;

/* Why there is no force, as bits. While any is set the force fades to zero; it comes back from zero
 * when the last one ends. The latches end with spidar_arm() alone. */
typedef enum spidar_hold {
  SPIDAR_HOLD_RELEASED = 1 << 4,    /* spidar_release() was called: a latch */
  SPIDAR_HOLD_LET_GO = 1 << 5,      /* the grip moved or turned as if it was let go: a latch */
  SPIDAR_HOLD_FAULTED = 1 << 6,     /* three exchanges in a row failed, or it is gone: a latch */
  SPIDAR_HOLD_LATE = 1 << 7,        /* more than 10 ms after the one before; until it is zero */
  SPIDAR_HOLD_NO_POSE = 1 << 8,     /* the pose of the grip is not known */
  SPIDAR_HOLD_NOT_FINITE = 1 << 13, /* the command was not finite; this exchange only */
  SPIDAR_HOLD_SLIPPED = 1 << 16     /* a string slips; if it did for 0.2 s, until calibrated */
} spidar_hold;

/* What made the force less than the command, as bits. */
typedef enum spidar_limit {
  SPIDAR_LIMIT_FADE = 1 << 0,             /* a hold, or the way back from one */
  SPIDAR_LIMIT_FORCE = 1 << 2,            /* spidar_limits.force */
  SPIDAR_LIMIT_TORQUE = 1 << 3,           /* spidar_limits.torque */
  SPIDAR_LIMIT_CONTINUOUS_FORCE = 1 << 4, /* spidar_limits.continuous_force */
  SPIDAR_LIMIT_SLEW = 1 << 5,             /* spidar_limits.slew_rate */
  SPIDAR_LIMIT_WORK = 1 << 6              /* work on the hand: 0.9 J at once, 0.3 W for ever */
} spidar_limit;

/* The parts that spidar_switch_off_safety() knows, as bits. */
#define SPIDAR_SAFETY_SLEW 1U         /* the limit of the change */
#define SPIDAR_SAFETY_WORK 2U         /* the limit of the work on the hand */
#define SPIDAR_SAFETY_LET_GO 4U       /* the latch after the grip was let go */
#define SPIDAR_SAFETY_ALL 0xffffffffU /* these, every other limit, fade and latch */

/* Begin with SPIDAR_LIMITS_INIT: the defaults. */
typedef struct spidar_limits {
  size_t struct_size;      /* sizeof(spidar_limits) */
  double force;            /* N, 0 to 5; default 1 */
  double torque;           /* N m, 0 to 0.1; default 0.02 */
  double continuous_force; /* N rms over any minute, 0 to 5; default 1; 0: no limit */
  double slew_rate;        /* N/s, 0.1 to 1000; default 20; for the torque at 0.02 m */
  double damping;          /* N s/m, against a grip faster than 0.1 m/s, 0 to 10; default 1 */
} spidar_limits;

/* Begin with SPIDAR_SAFETY_INIT. */
typedef struct spidar_safety {
  size_t struct_size;    /* sizeof(spidar_safety) */
  double force[3];       /* N, that the last exchange sent: the part of the command within limits */
  double torque[3];      /* N m, the same */
  double work;           /* J, that the strings did on the hand between the last two exchanges */
  uint32_t holds;        /* spidar_hold; the latches are those of now */
  uint32_t limited_by;   /* spidar_limit, of the last exchange */
  uint32_t switched_off; /* SPIDAR_SAFETY_... */
  int32_t armed;         /* 0: a latch holds the force */
} spidar_safety;

/* Versions of clang-format disagree here. */
/* clang-format off */
#ifdef __cplusplus
#define SPIDAR_OPTIONS_INIT {sizeof(spidar_options)}
#define SPIDAR_STATE_INIT {sizeof(spidar_state)}
#define SPIDAR_SAFETY_INIT {sizeof(spidar_safety)}
#else
#define SPIDAR_OPTIONS_INIT {.struct_size = sizeof(spidar_options)}
#define SPIDAR_STATE_INIT {.struct_size = sizeof(spidar_state)}
#define SPIDAR_SAFETY_INIT {.struct_size = sizeof(spidar_safety)}
#endif
#define SPIDAR_LIMITS_INIT {sizeof(spidar_limits), 1, 0.02, 1, 20, 1}
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
 * the part of the last command that the limits let through, receives the pose. SPIDAR_E_IO if the
 * device did not answer. Call it once a period: it does not wait. Real-time safe. */
SPIDAR_C_API int spidar_exchange(spidar_device *device, int64_t now);

/* The state after the last exchange. Real-time safe. */
SPIDAR_C_API int spidar_get_state(const spidar_device *device, spidar_state *state);

/* Force (N) and torque (N m) that the exchanges from the next one on approach, until the next call.
 * They pass the limits of hapticsink (docs/safety.md): of force, torque, change and work on the
 * hand, the latch after the grip was let go, and the fades. The tensions of the strings keep within
 * the limits of the geometry. A wrench that is not finite counts as zero. Real-time safe.
 * The first packages limited the tensions alone. */
SPIDAR_C_API int spidar_command(spidar_device *device, const double force[3],
                                const double torque[3]);

/* What the limits made of the command, and why. Real-time safe. */
SPIDAR_C_API int spidar_get_safety(const spidar_device *device, spidar_safety *safety);

/* What the most lasting of these holds (spidar_safety.holds) means, and its cure. Empty if none. */
SPIDAR_C_API const char *spidar_hold_text(uint32_t holds);

/* Sets other limits. SPIDAR_E_ARGUMENT if one is out of its range; then nothing changes. */
SPIDAR_C_API int spidar_set_limits(spidar_device *device, const spidar_limits *limits);

/* Ends every latch. The force comes back from zero within 0.5 s. A device is armed when it was
 * opened. Let a person ask for it who holds the grip. From any thread; real-time safe. */
SPIDAR_C_API int spidar_arm(spidar_device *device);

/* The force fades to zero within 50 ms, until spidar_arm(). From any thread and from a signal
 * handler; real-time safe. */
SPIDAR_C_API int spidar_release(spidar_device *device);

/* Switches off these parts (SPIDAR_SAFETY_...), and no others: 0 switches all on. For an experiment
 * whose own program, or a person at the power switch, stands in for them. With SPIDAR_SAFETY_ALL
 * the tensions of the strings alone are limited, and the torque that comes with a force unasked
 * (20 mN.m); spidar_release() takes the force off at once.
 * Real-time safe. */
SPIDAR_C_API int spidar_switch_off_safety(spidar_device *device, uint32_t parts);

/* Takes the present place of the grip as the centre and its orientation as the identity.
 * Real-time safe. */
SPIDAR_C_API int spidar_calibrate(spidar_device *device);

/* m from the centre: what the workspace is on each axis. */
SPIDAR_C_API int spidar_workspace(const spidar_device *device, double half[3]);

#ifdef __cplusplus
}
#endif
