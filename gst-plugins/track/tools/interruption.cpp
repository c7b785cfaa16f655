// SPDX-License-Identifier: LGPL-2.1-or-later
#include "interruption.hpp"

#include "track-error.hpp"

#include <csignal>

namespace haptic {
namespace {

volatile std::sig_atomic_t interrupted = 0;

} // namespace

void stop_when_interrupted() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGXFSZ, SIG_IGN);
}

bool is_interrupted() noexcept {
  return interrupted != 0;
}

void throw_if_interrupted() {
  if (is_interrupted())
    throw_error(messages::kWorkIsInterrupted);
}

} // namespace haptic
