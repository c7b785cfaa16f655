// SPDX-License-Identifier: LGPL-2.1-or-later
// SPIDAR_API marks what the shared library exports. Everything else is hidden, but a class within
// an exported one is only so if it is marked SPIDAR_HIDDEN.
#pragma once

#define SPIDAR_API __attribute__((visibility("default")))
#define SPIDAR_HIDDEN __attribute__((visibility("hidden")))
