// Everything else in the library is hidden.
#pragma once

#define SPIDAR_API __attribute__((visibility("default")))
