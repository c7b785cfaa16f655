// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/reopening.hpp"

#include <algorithm>

namespace haptic {

Reopening::Device Reopening::attempt(std::int64_t now, const std::function<Device()> &open,
                                     SessionClient &client) {
  if (!next_at_) {
    next_at_ = now + wait_;
    reported_.clear();
  }
  if (now < *next_at_)
    return nullptr;
  try {
    Device device = open();
    next_at_.reset();
    return device;
  } catch (const spidar::Error &error) {
    report(error, now, client);
  } catch (const std::exception &error) { // no thread or no memory is left
    report(spidar::Error(spidar::Cause::io, error.what()), now, client);
  }
  return nullptr;
}

// A device that has just been plugged in may need a moment until it may be opened.
void Reopening::report(const spidar::Error &error, std::int64_t now, SessionClient &client) {
  wait_ = std::min(2 * wait_, kLast);
  next_at_ = now + wait_;
  client.note(Severity::debug, std::string("not opened again yet: ") + error.what());
  if (error.cause() == spidar::Cause::not_found) {
    reported_.clear();
  } else if (reported_ != error.what() && wait_ == kLast) {
    reported_ = error.what();
    client.on_notice({Severity::warning, NoticeCause::open, reported_, "while opening it again"});
  }
}

} // namespace haptic
