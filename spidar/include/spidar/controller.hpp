// SPDX-License-Identifier: LGPL-2.1-or-later
// Interface of the motor electronics: D/A words out, encoder counts in, one exchange per tick.
// Real-time safe functions are for the real-time thread, the others are not.
#pragma once

#include "spidar/export.hpp"
#include "spidar/types.hpp"

#include <cstdint>
#include <string>

namespace spidar {

class SPIDAR_API Controller {
public:
  virtual ~Controller() = default;

  /// Sends `words` and receives `counts`. False if the exchange failed; `counts` is then unchanged.
  /// Real-time safe: no allocation, lock or log.
  virtual bool exchange(const DacWords &words, Counts &counts) noexcept = 0;

  /// Sets `counts` to those of the grip in the centre, if the controller knows them. A USB
  /// controller does not: its user holds the grip in the centre while Device is made. The simulator
  /// does, so that its hand may start anywhere.
  virtual bool home(Counts & /*counts*/) const noexcept { return false; }

  /// Starts a guard that sends `rest` if this process dies, or stops to exchange while it sends
  /// other words. Throws Error (io). A simulator needs none.
  virtual void guard(const DacWords & /*rest*/) {}

  /// False if no further exchange will succeed: open the device again. Real-time safe.
  virtual bool connected() const noexcept { return true; }

  /// Whether `rest` was sent in place of the words since the call before: by the guard, or because
  /// it did not answer. The next words should begin from zero. Real-time safe.
  virtual bool interrupted() noexcept { return false; }

  /// For messages: model, identity, connection.
  virtual std::string description() const = 0;

  /// What its user should know of the guard, with the cure. Empty if nothing.
  virtual std::string remark() const { return {}; }

  /// The next exchange() is at `now` (ns, monotonic). For a simulator, which has no time of its
  /// own; real-time safe.
  virtual void set_time(std::int64_t /*now*/) noexcept {}

  /// Whether a button of the grip is pressed, as of the last exchange. A USB controller does not
  /// know which of its inputs() that is: the geometry does. Real-time safe.
  virtual bool pressed() const noexcept { return false; }

  /// What finds this unit again among others after it was unplugged: a USB controller has no serial
  /// number, but a model and a rotary switch. Empty if nothing does.
  virtual std::string identity() const { return {}; }

  /// The input pins as of the last exchange that succeeded, bit 0 first: 0 to 3 of both USB
  /// controllers, 8 to 15 of "USB2.0 SH4" alone. What is wired to them is not known, but for the
  /// button that a geometry names.
  /// Real-time safe.
  virtual std::uint16_t inputs() const noexcept { return 0; }
};

} // namespace spidar
