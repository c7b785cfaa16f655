// SPDX-License-Identifier: LGPL-2.1-or-later
// Shared by the tools: options, the device that they name, exit statuses.
#pragma once

#include <cstdio>
#include <glib.h>
#include <memory>
#include <spidar/device.hpp>
#include <spidar/error.hpp>
#include <string>

namespace spidar_tools {

/// 1 is a mistake in the command, as with most programs.
enum ExitStatus {
  kFine = 0,
  kUsage = 1,
  kNotFound = 2,
  kPermission = 3,
  kBusy = 4,
  kNoAnswer = 5,
  kGeometry = 6,
};

inline constexpr const char *kExitStatuses =
    "Exit status: 0 all is well, 1 wrong options or answers, 2 no device, 3 permission missing, 4 "
    "in use by another program, 5 a device that does not answer, 6 an unusable geometry.";

ExitStatus status_of(const spidar::Error &error);

struct Choice {
  std::string device = "usb"; ///< usb, usb:ID or sim
  bool device_named = false;  ///< by the user
  std::string geometry = spidar::kDefaultGeometry;
  std::string sim_hand = "hold:0,0,0";
};

/// Throws spidar::Error.
std::unique_ptr<spidar::Device> open_device(const Choice &choice);
/// Prints what the user should know before a hand holds it.
void print_remark(const spidar::Device &device);

struct Free {
  void operator()(gchar *text) const { g_free(text); }
  void operator()(GOptionContext *context) const { g_option_context_free(context); }
};

/// Options of a tool: its own, and --device, --geometry, --sim-hand.
class Options {
public:
  Options(const char *arguments, const char *summary, const GOptionEntry *own,
          const char *exit_statuses = kExitStatuses);
  /// False for a mistake, which has been reported.
  bool parse(int &argc, char **&argv);
  Choice choice() const;

private:
  gchar *device_ = nullptr;
  gchar *geometry_ = nullptr;
  gchar *sim_hand_ = nullptr;
  std::unique_ptr<GOptionContext, Free> context_;
};

/// Runs `body` and turns what it throws into a message and an exit status.
template <class Body>
int run(Body body) {
  try {
    return body();
  } catch (const spidar::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return status_of(error);
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kNoAnswer;
  }
}

} // namespace spidar_tools
