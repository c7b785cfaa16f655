// SPDX-License-Identifier: LGPL-2.1-or-later
// SPIDAR_API marks what the shared library exports. Everything else is hidden.
#pragma once

#define SPIDAR_API __attribute__((visibility("default")))
