// SPDX-License-Identifier: LGPL-2.1-or-later
// One USB device on the virtual bus: descriptors, control requests, two bulk endpoints with the
// board behind them. Knows nothing of the network.
#pragma once

#include "board.hpp"

namespace emulator {

/// What the host wants transferred. `setup` counts for endpoint 0, `data` when going out.
struct Transfer {
  std::uint32_t sequence = 0;
  bool in = false;
  std::uint8_t endpoint = 0;
  std::uint32_t length = 0;
  std::array<std::uint8_t, 8> setup{};
  std::span<const std::uint8_t> data;
};

struct Completion {
  std::uint32_t sequence = 0;
  std::int32_t status = 0; ///< 0 or a negative errno
  std::uint32_t actual = 0;
  std::vector<std::uint8_t> data; ///< of a transfer to the host
};

class Unit {
public:
  /// `number` from 1.
  Unit(int number, Board board);

  std::string bus_id() const { return "1-" + std::to_string(number_); }
  int number() const noexcept { return number_; }
  std::uint16_t product() const noexcept;
  Board &board() noexcept { return board_; }
  std::string description() const;

  bool plugged() const noexcept { return plugged_; }
  bool attached() const noexcept { return attached_; }

  /// A host has the unit, or no longer. Transfers it waited for are forgotten; what the board holds
  /// stays, as with a program that ended in the middle.
  void attach(Time now);
  void detach(Time now);

  /// Completions of this and of other transfers go to `done`.
  void submit(const Transfer &transfer, Time now, std::vector<Completion> &done);
  /// False when it has been completed before.
  bool unlink(std::uint32_t sequence);
  /// Completes what became possible with time.
  void collect(Time now, std::vector<Completion> &done);
  /// When collect() has something to do.
  std::optional<Time> due() const;

  // Faults.
  void unplug() noexcept { plugged_ = false; } ///< the host finds the unit gone
  void plug(Time now);                         ///< switched on anew
  void stall(bool in, std::vector<Completion> &done);

private:
  struct Waiting {
    std::uint32_t sequence;
    std::uint32_t length;
    std::vector<std::uint8_t> data;
  };

  Completion control(const Transfer &transfer);
  bool standard_request(const std::array<std::uint8_t, 8> &setup, std::vector<std::uint8_t> &data);
  bool descriptor(int type, int index, std::vector<std::uint8_t> &data) const;
  bool *halt_of(int address) noexcept;

  int number_;
  Board board_;
  bool plugged_ = true;
  bool attached_ = false;
  std::uint8_t configuration_ = 0;
  bool halted_in_ = false;
  bool halted_out_ = false;
  std::deque<Waiting> waiting_; ///< transfers from the bulk endpoint to the host, oldest first
};

} // namespace emulator
