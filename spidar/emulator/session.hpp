// SPDX-License-Identifier: LGPL-2.1-or-later
// One connection of a USB/IP client: bytes in, bytes out. Knows nothing of sockets.
#pragma once

#include "unit.hpp"
#include "usbip-wire.hpp"

#include <memory>

namespace emulator {

using Units = std::vector<std::unique_ptr<Unit>>;

class Session {
public:
  /// `units` outlive the session and stay as many.
  explicit Session(Units &units) : units_(units) {}
  ~Session();
  Session(const Session &) = delete;
  Session &operator=(const Session &) = delete;

  /// Takes what the network brought. False when the connection has nothing more to say, or made no
  /// sense: it is to be closed once output() has been sent.
  bool receive(std::span<const std::uint8_t> bytes, Time now);

  /// Replies that became due.
  void collect(Time now);
  std::optional<Time> due() const;

  /// The unit of this connection, if it has one. Unplugged: close.
  Unit *unit() noexcept { return unit_; }

  /// Replies of transfers that the unit gave up on its own.
  void complete(const std::vector<Completion> &done);

  usbip::Bytes &output() noexcept { return output_; }

private:
  enum class Progress { more, wait, end };
  Progress step(std::span<const std::uint8_t> bytes, std::size_t &used, Time now);
  Progress request(std::span<const std::uint8_t> bytes, std::size_t &used, Time now);
  bool import(const std::string &bus_id, Time now);

  Units &units_;
  Unit *unit_ = nullptr;
  usbip::Bytes input_;
  usbip::Bytes output_;
  std::vector<Completion> done_;
};

} // namespace emulator
