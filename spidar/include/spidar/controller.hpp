// The border to the motor electronics: D/A words out, encoder counts in, one exchange per tick.
#pragma once

#include "spidar/types.hpp"

#include <memory>
#include <string>

namespace spidar {

class Controller {
public:
  virtual ~Controller() = default;

  /// Sends `words` and receives the counts. False when the exchange failed (`counts` is then
  /// unchanged). Called from the real-time thread: no allocation, lock or log, and no throw.
  virtual bool exchange(const DacWords &words, Counts &counts) noexcept = 0;

  /// For people: model, identity, where it is connected.
  virtual std::string description() const = 0;
};

} // namespace spidar
