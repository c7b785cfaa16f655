// SPDX-License-Identifier: LGPL-2.1-or-later
// The CSV log: rows come from the real-time thread, a thread of normal priority writes them.
#pragma once

#include "share/loop-clock.hpp"
#include "share/non-blocking.hpp"

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace haptic {

/// One row; the members are the columns in their order (docs/formats/csv-log.md). SI units. New
/// columns go to the end.
struct TickRow {
  double time = 0;                  ///< s, running time
  std::array<double, 3> position{}; ///< m, grip
  std::array<double, 2> velocity{}; ///< px/s of the frame, y down
  double spin = 0;                  ///< rad/s
  std::array<double, 3> force{};    ///< N, commanded
  std::array<double, 3> torque{};   ///< N·m, commanded
  double confidence = 0;            ///< 0..1
  std::array<double, 8> tension{};  ///< N
  double mono = 0;                  ///< s of the monotonic clock since the first row
  std::uint32_t hold = 0;           ///< Hold (safety-chain.hpp): the reasons why the force is held
  std::array<double, 4> orientation{0, 0, 0,
                                    1};   ///< quaternion x, y, z, w: grip frame to workspace frame
  double energy = 0;                      ///< share of the budget for continuous force that is used
  std::array<double, 3> turning{};        ///< rad/s, of the grip
  std::array<double, 3> realised_force{}; ///< N, what the tensions exert
  std::array<double, 3> realised_torque{}; ///< N·m
  std::array<double, 3> proxy{};           ///< m; where the hand touches the surface
  bool touches = false;
};

inline constexpr const char *kTickLogHeader =
    "time,x,y,z,vx,vy,spin,fx,fy,fz,tx,ty,tz,confidence,t0,t1,t2,t3,t4,t5,t6,t7,mono,hold"
    ",qx,qy,qz,qw,energy,wx,wy,wz,rfx,rfy,rfz,rtx,rty,rtz,px,py,pz,touch";

/// Appends one line with its line feed: nine significant digits, "." in every locale. A number that
/// is not finite is written as 0.
void append_row(std::string &text, const TickRow &row);

class TickLog {
public:
  /// Creates the file and writes the header. `clock` outlives the log. Throws std::system_error.
  explicit TickLog(const std::string &path, LoopClock &clock = machine_clock());
  /// Writes the rows that are left and closes the file.
  ~TickLog();
  TickLog(const TickLog &) = delete;
  TickLog &operator=(const TickLog &) = delete;

  /// Returns false if the row is lost because the writer is too far behind. One thread; real-time
  /// safe.
  bool write(const TickRow &row) noexcept HAPTIC_NONBLOCKING;

  /// Returns the errno of the first write that failed (nothing is written after it), or 0.
  int error() const noexcept { return error_.load(std::memory_order_relaxed); }

private:
  // At the highest rate, 4 kHz, this is two seconds of a stuck disk.
  static constexpr std::size_t kRows = 8192;

  struct CloseFile {
    void operator()(std::FILE *file) const noexcept { std::fclose(file); }
  };

  void run(const std::stop_token &stop);
  void drain(std::string &text);
  void put(const std::string &text);

  std::unique_ptr<std::FILE, CloseFile> file_;       // writer thread after construction
  std::vector<TickRow> rows_;                        // ring; a row belongs to one side at a time
  alignas(64) std::atomic<std::size_t> written_ = 0; // rows ever put in, by write()
  alignas(64) std::atomic<std::size_t> read_ = 0;    // rows ever taken out, by the writer thread
  std::atomic<int> error_ = 0;
  LoopClock &clock_;
  std::jthread thread_;
};

} // namespace haptic
