// SPDX-License-Identifier: LGPL-2.1-or-later
// The exception of the library. Nothing that is marked real-time safe throws.
#pragma once

#include "spidar/export.hpp"

#include <stdexcept>
#include <string>

namespace spidar {

enum class Cause {
  not_found,  ///< no such device, geometry or file
  permission, ///< the device is there but may not be opened
  busy,       ///< another program holds the device
  geometry,   ///< unreadable or impossible geometry
  argument,   ///< a value that makes no sense
  io,         ///< the device answers wrongly or not at all
};

/// what() is for the user: what happened, and the cure. All texts are in src/messages.hpp.
class SPIDAR_API Error : public std::runtime_error {
public:
  Error(Cause cause, const std::string &message) : std::runtime_error(message), cause_(cause) {}
  Cause cause() const noexcept { return cause_; }

private:
  Cause cause_;
};

} // namespace spidar
