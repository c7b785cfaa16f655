// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-calibrate: measures a SPIDAR-G with the help of its user, and writes a geometry file.
#include "fail.hpp"
#include "model/gentle-pull.hpp"
#include "tool.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <optional>
#include <spidar/calibration.hpp>
#include <spidar/limited-device.hpp>
#include <thread>
#include <unistd.h>

using namespace spidar_tools;
using namespace std::chrono_literals;
using spidar::Vector3;
namespace messages = spidar::messages;

namespace {

constexpr double kGentle = 0.5; // N
constexpr double kMeasured = 1; // N
constexpr auto kTick = 1ms;

constexpr const char *kDirections[] = {"right", "left", "up", "down", "towards", "away"};

/// Exchanges with the device in a thread while the user answers.
class Session {
public:
  explicit Session(std::unique_ptr<spidar::Device> device) : device_(std::move(device)) {
    thread_ = std::jthread([this](const std::stop_token &stop) { run(stop); });
  }

  void pull(const Vector3 &force) {
    const std::lock_guard lock(mutex_);
    limited_.arm(); // the person has answered
    pull_.want(force);
  }
  /// The geometry has this axis the other way round: pulls the other way from now on.
  void mirror(int axis) {
    const std::lock_guard lock(mutex_);
    pull_.mirror(axis);
  }
  void calibrate() {
    const std::lock_guard lock(mutex_);
    device_->calibrate();
  }
  /// Whether it has stopped pulling by itself. Throws Error (io) when the device is silent or a
  /// string has slipped: then no answer comes from a force.
  bool pull_ended() {
    const std::lock_guard lock(mutex_);
    check_answers();
    if (device_->state().slipped)
      spidar::fail(spidar::Cause::io, messages::kToolSlipped);
    return pull_.ended();
  }
  /// Throws Error (io) when the device is silent.
  spidar::Counts counts() {
    const std::lock_guard lock(mutex_);
    check_answers();
    return device_->state().counts;
  }

private:
  void check_answers() const {
    if (silent_ > 100)
      spidar::fail(spidar::Cause::io, messages::kToolSilent);
  }
  void run(const std::stop_token &stop) {
    auto next = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      next += kTick;
      std::this_thread::sleep_until(next);
      const std::lock_guard lock(mutex_);
      silent_ = limited_.exchange(spidar::monotonic_time()) ? 0 : silent_ + 1;
      pull_.release_if_unsafe(device_->state(), limited_.armed());
      limited_.command({pull_.step(1e-3), Vector3::Zero()});
    }
  }

  std::mutex mutex_;
  std::unique_ptr<spidar::Device> device_;
  spidar::LimitedDevice limited_{*device_};
  spidar::GentlePull pull_;
  int silent_ = 0;
  std::jthread thread_;
};

std::string ask(const std::string &question) {
  std::cout << question << '\n' << std::flush;
  std::string answer;
  if (!std::getline(std::cin, answer))
    spidar::fail(spidar::Cause::argument, messages::kToolNoAnswer);
  answer.erase(0, answer.find_first_not_of(" \t"));
  answer.erase(answer.find_last_not_of(" \t\r") + 1);
  return answer;
}

double ask_number(const std::string &question) {
  for (;;) {
    const std::string answer = ask(question);
    char *end = nullptr;
    const double number = std::strtod(answer.c_str(), &end);
    if (end != answer.c_str() && *end == '\0' && std::isfinite(number))
      return number;
    std::cout << spidar::formatted(messages::kToolNumber, answer.c_str()) << '\n' << std::flush;
  }
}

/// Index into kDirections; nothing for "none".
std::optional<std::size_t> ask_direction() {
  for (;;) {
    const std::string answer =
        ask("  Which way does it pull? (right, left, up, down, towards you, away, none)");
    for (std::size_t i = 0; i < std::size(kDirections); ++i)
      if (answer == kDirections[i] || answer == std::string(kDirections[i]) + " you")
        return i;
    if (answer == "none")
      return std::nullopt;
    std::cout << spidar::formatted(messages::kToolDirection, answer.c_str()) << '\n' << std::flush;
  }
}

/// The answer to a question about the pull. Where the pull ended before the answer, it says so and
/// asks again.
template <class Ask>
auto ask_while_pulling(Session &session, const Vector3 &force, Ask ask) {
  for (;;) {
    session.pull(force);
    const auto answer = ask();
    const bool ended = session.pull_ended();
    session.pull(Vector3::Zero());
    if (!ended)
      return answer;
    std::cout << messages::kToolPullEnded << '\n' << std::flush;
  }
}

/// True when the geometry has the axis the right way round.
bool check_axis(Session &session, int axis) {
  const auto forwards = 2 * static_cast<std::size_t>(axis);
  Vector3 force = Vector3::Zero();
  force[axis] = kGentle;
  const std::optional<std::size_t> seen = ask_while_pulling(session, force, ask_direction);
  if (!seen)
    spidar::fail(spidar::Cause::argument, messages::kToolNoPull);
  if (*seen / 2 != forwards / 2)
    spidar::fail(spidar::Cause::argument, messages::kToolOtherPull, kDirections[forwards],
                 kDirections[forwards + 1]);
  return *seen == forwards;
}

spidar::Geometry dialogue(Session &session, spidar::Geometry geometry) {
  ask("Hold the grip upright in the centre of the frame, and press Enter.");
  session.calibrate();
  const spidar::Counts centre = session.counts();

  for (int axis = 0; axis < 3; ++axis) {
    std::cout << "Now it pulls gently along axis " << axis + 1 << " of 3.\n" << std::flush;
    if (check_axis(session, axis))
      continue;
    std::cout << "  The geometry has it the other way round; it is turned over.\n" << std::flush;
    geometry = spidar::mirrored(std::move(geometry), axis);
    session.mirror(axis);
  }

  ask("Move the grip straight to the right, without turning it, hold it there, and press Enter.");
  const spidar::Counts there = session.counts();
  const double millimetres = ask_number("  How many millimetres is that from the centre?");
  geometry = spidar::with_measured_counts(std::move(geometry), centre, there, 0, millimetres / 1e3);

  if (ask("Hold the grip in the centre with a spring balance on its left, and press Enter; or type "
          "skip.") != "skip") {
    session.calibrate();
    const double newtons = ask_while_pulling(session, {kMeasured, 0, 0}, [] {
      return ask_number("  It pulls to the right. How many newtons does the balance show?");
    });
    geometry = spidar::with_measured_force(std::move(geometry), kMeasured, newtons);
  }
  return geometry;
}

} // namespace

int main(int argc, char **argv) {
  const char *output = nullptr;
  gboolean overwrite = FALSE;
  const GOptionEntry own[] = {
      {"output", 'o', 0, G_OPTION_ARG_FILENAME, &output, "the geometry file that is written",
       "FILE.ini"},
      {"force", 'f', 0, G_OPTION_ARG_NONE, &overwrite, "overwrite the geometry file", nullptr},
      {}};
  Options options("",
                  "Measures a SPIDAR-G together with the person who holds it, and writes a "
                  "geometry file.\n\nExample: spidar-calibrate --device usb --output mine.ini",
                  own);
  if (!options.parse(argc, argv))
    return kUsage;
  return run([&] {
    if (!output)
      spidar::fail(spidar::Cause::argument, messages::kToolNoOutput);
    if (!overwrite && std::filesystem::exists(output))
      spidar::fail(spidar::Cause::argument, messages::kToolExists, output);
    const std::string folder = std::filesystem::absolute(output).parent_path();
    if (access(folder.c_str(), W_OK) != 0) // nobody measures for nothing
      spidar::fail(spidar::Cause::not_found, messages::kGeometryUnwritable, output,
                   std::strerror(errno));
    const Choice choice = options.choice();
    const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
    auto device = open_device(choice);
    print_remark(*device);
    Session session(std::move(device));
    spidar::save_geometry(dialogue(session, geometry), output);
    std::cout << "Written. Use it with: geometry=" << std::filesystem::absolute(output).string()
              << '\n'
              << std::flush;
    return kFine;
  });
}
