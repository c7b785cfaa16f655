// SPDX-License-Identifier: LGPL-2.1-or-later
// Serves USB/IP clients over TCP, and commands from standard input and a local socket. One thread,
// GLib's main loop.
#pragma once

#include "session.hpp"
#include "word-log.hpp"

#include <string>

namespace emulator {

struct ServerOptions {
  std::string address = "127.0.0.1"; ///< to listen on, numeric
  std::uint16_t port = 3240;         ///< registered for USB/IP; 0 for any free one
  std::string control;               ///< path of a local socket for commands; empty for none
};

/// Serves until SIGINT or SIGTERM. `log` may be null. Throws spidar::Error (argument, busy) when it
/// cannot listen.
void serve(const ServerOptions &options, Units &units, WordLog *log);

} // namespace emulator
