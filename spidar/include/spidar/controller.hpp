// SPDX-License-Identifier: LGPL-2.1-or-later
// The border to the motor electronics: D/A words out, encoder counts in, one exchange per tick.
#pragma once

#include "spidar/export.hpp"
#include "spidar/types.hpp"

#include <string>

namespace spidar {

class SPIDAR_API Controller {
public:
  virtual ~Controller() = default;

  /// Sends `words` and receives the counts. False when the exchange failed (`counts` is then
  /// unchanged). Called from the real-time thread: no allocation, lock or log, and no throw.
  virtual bool exchange(const DacWords &words, Counts &counts) noexcept = 0;

  /// Counts with the grip in the centre, where the controller knows them. A counter that starts
  /// anywhere at power-on (every USB controller) does not: its user holds the grip in the centre
  /// while Device is made. The simulator does, so that its hand may start where its script says.
  virtual bool home(Counts & /*counts*/) const noexcept { return false; }

  /// Has somebody else send `rest` should this process die or stop exchanging while it sends other
  /// words. Not from the real-time thread. Throws Error (io). A simulator needs nobody.
  virtual void guard(const DacWords & /*rest*/) {}

  /// False when no further exchange will succeed: only opening the device anew can help.
  virtual bool connected() const noexcept { return true; }

  /// Whether the motors were put at rest by somebody else since this was last asked.
  virtual bool interrupted() noexcept { return false; }

  /// For people: model, identity, where it is connected.
  virtual std::string description() const = 0;
};

} // namespace spidar
