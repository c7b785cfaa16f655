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

  /// For people: model, identity, where it is connected.
  virtual std::string description() const = 0;
};

} // namespace spidar
