// SPDX-License-Identifier: LGPL-2.1-or-later
// One USB device on a virtual bus: descriptors, standard control requests (USB 2.0, chapter 9), and
// two bulk endpoints with the firmware behind them. It does not know who submits the transfers:
// USB/IP in the emulator, a mocked usbfs in the tests. One thread.
#pragma once

#include "firmware.hpp"

namespace emulator {

/// A transfer that the host wants.
struct Transfer {
  std::uint32_t sequence = 0;          ///< chosen by the host, names the transfer
  bool in = false;                     ///< to the host
  std::uint8_t endpoint = 0;           ///< number without the direction
  std::uint32_t length = 0;            ///< bytes wanted, of a transfer to the host
  std::array<std::uint8_t, 8> setup{}; ///< of endpoint 0
  std::span<const std::uint8_t> data;  ///< of a transfer from the host
};

/// The end of a transfer.
struct Completion {
  std::uint32_t sequence = 0;
  std::int32_t status = 0;  ///< 0 or a negative errno
  std::uint32_t actual = 0; ///< bytes transferred
  Bytes data;               ///< of a transfer to the host
};

/// Device descriptor, with names at string indices 1 and 2 if `named`.
Bytes device_descriptor(std::uint16_t vendor, std::uint16_t product, bool named);
/// Configuration, interface, and three bulk endpoints.
Bytes configuration_descriptor();

class Unit {
public:
  /// `number` from 1.
  Unit(int number, Firmware firmware);

  std::string bus_id() const { return "1-" + std::to_string(number_); }
  int number() const noexcept { return number_; }
  std::uint16_t product() const noexcept { return product_id(firmware_.model()); }
  Firmware &firmware() noexcept { return firmware_; }
  const Firmware &firmware() const noexcept { return firmware_; }
  std::string description() const;

  bool plugged() const noexcept { return plugged_; }
  bool attached() const noexcept { return attached_; }

  /// A host begins to use the unit: not configured, no endpoint halted.
  void attach(Time now);
  /// The host has gone. Waiting transfers are dropped; unread replies stay, as after a program that
  /// ended in the middle of an exchange.
  void detach(Time now);

  /// Starts a transfer. Appends to `done` every transfer that ends now, this one or others.
  void submit(const Transfer &transfer, Time now, std::vector<Completion> &done);
  /// Drops a waiting transfer. False if it has ended before.
  bool unlink(std::uint32_t sequence);
  /// Appends to `done` the waiting transfers that can end by now.
  void collect(Time now, std::vector<Completion> &done);
  /// Time at which collect() has something to do, or nothing if only the host can change that.
  std::optional<Time> due() const;

  // Faults of the bus; those of the firmware are in firmware().faults().
  void unplug() noexcept { plugged_ = false; }
  void plug(Time now);                                ///< and switches it on
  void stall(bool in, std::vector<Completion> &done); ///< halts an endpoint

private:
  struct Waiting {
    std::uint32_t sequence;
    std::uint32_t length;
    Bytes data; ///< received so far, or to be sent
  };

  void submit_in(const Transfer &transfer, Time now, std::vector<Completion> &done);
  void submit_out(const Transfer &transfer, Time now, std::vector<Completion> &done);
  void send_out(Time now, std::vector<Completion> &done);
  Completion control(const Transfer &transfer);
  bool standard_request(const std::array<std::uint8_t, 8> &setup, Bytes &data);
  bool descriptor(int type, int index, Bytes &data) const;
  bool *halt_of(int address) noexcept;

  int number_;
  Firmware firmware_;
  bool plugged_ = true;
  bool attached_ = false;
  std::uint8_t configuration_ = 0;
  bool halted_in_ = false;
  bool halted_out_ = false;
  std::deque<Waiting> waiting_in_;  ///< bulk transfers to the host, oldest first
  std::deque<Waiting> waiting_out_; ///< and from the host, while the firmware refuses them
};

} // namespace emulator
