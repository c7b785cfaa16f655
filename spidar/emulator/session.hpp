// SPDX-License-Identifier: LGPL-2.1-or-later
// One connection of a USB/IP client as a function of bytes, without sockets. One thread.
#pragma once

#include "unit.hpp"
#include "usbip-wire.hpp"

#include <memory>

namespace emulator {

using Units = std::vector<std::unique_ptr<Unit>>;

class Session {
public:
  /// `units` must outlive the session, and none may be added or removed.
  explicit Session(Units &units) : units_(units) {}
  ~Session();
  Session(const Session &) = delete;
  Session &operator=(const Session &) = delete;

  /// Handles bytes of the client. False if the connection is complete or the bytes are malformed:
  /// send output(), then close it.
  bool receive(std::span<const std::uint8_t> bytes, Time now);

  /// Adds the replies that are due to output().
  void collect(Time now);
  std::optional<Time> due() const;

  /// The unit of this connection, or null. If it is unplugged, close the connection.
  Unit *unit() noexcept { return unit_; }

  /// Adds the replies of these transfers to output().
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
