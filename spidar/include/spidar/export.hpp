// SPDX-License-Identifier: LGPL-2.1-or-later
// Everything else in the library is hidden.
#pragma once

#define SPIDAR_API __attribute__((visibility("default")))
