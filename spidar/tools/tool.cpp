// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tool.hpp"

#include "device-name.hpp"
#include "fail.hpp"

#include <clocale>

namespace spidar_tools {

namespace messages = spidar::messages;

namespace {

void print_error(const char *format, const char *argument) {
  std::fprintf(stderr, "%s\n", spidar::formatted(format, argument).c_str());
}

} // namespace

ExitStatus status_of(const spidar::Error &error) {
  switch (error.cause()) {
  case spidar::Cause::not_found:
    return kNotFound;
  case spidar::Cause::permission:
    return kPermission;
  case spidar::Cause::busy:
    return kBusy;
  case spidar::Cause::geometry:
    return kGeometry;
  case spidar::Cause::argument:
    return kUsage;
  case spidar::Cause::io:
    break;
  }
  return kNoAnswer;
}

std::unique_ptr<spidar::Device> open_device(const Choice &choice) {
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  auto controller = spidar::open_controller(choice.device, geometry, choice.sim_hand);
  return std::make_unique<spidar::Device>(std::move(controller), geometry);
}

void print_remark(const spidar::Device &device) {
  if (const std::string remark = device.remark(); !remark.empty())
    std::printf("%s\n", remark.c_str());
}

Options::Options(const char *arguments, const char *summary, const GOptionEntry *own,
                 const char *exit_statuses)
    : context_(g_option_context_new(arguments)) {
  std::setlocale(LC_ALL, "");
  std::setlocale(LC_NUMERIC, "C"); // numbers look the same everywhere
  const GOptionEntry common[] = {
      {"device", 'd', 0, G_OPTION_ARG_STRING, &device_,
       "which device: usb (the first one found), usb:ID (the number of its rotary switch) or sim "
       "(default: usb)",
       "DEVICE"},
      {"geometry", 'g', 0, G_OPTION_ARG_STRING, &geometry_,
       "geometry of the device: a name or a file (default: spidar-g6x3r)", "GEOMETRY"},
      {"sim-hand", 0, 0, G_OPTION_ARG_STRING, &sim_hand_,
       "for sim, who holds the grip: hold:X,Y,Z, circle:RADIUS,PERIOD, file:PATH or free. Lengths "
       "are -1 to 1 of the half workspace, PERIOD is in seconds",
       "HAND"},
      {}};
  g_option_context_set_summary(context_.get(), summary);
  g_option_context_set_description(context_.get(), exit_statuses);
  g_option_context_add_main_entries(context_.get(), own, nullptr);
  g_option_context_add_main_entries(context_.get(), common, nullptr);
}

bool Options::parse(int &argc, char **&argv) {
  GError *error = nullptr;
  const bool parsed = g_option_context_parse(context_.get(), &argc, &argv, &error);
  if (!parsed)
    print_error(messages::kToolOption, error->message);
  else if (argc > 1)
    print_error(messages::kToolArgument, argv[1]);
  g_clear_error(&error);
  return parsed && argc == 1;
}

Choice Options::choice() const {
  Choice choice;
  if (device_) {
    choice.device = device_;
    choice.device_named = true;
  }
  if (geometry_)
    choice.geometry = geometry_;
  if (sim_hand_)
    choice.sim_hand = sim_hand_;
  return choice;
}

} // namespace spidar_tools
