// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-emulator: a USB/IP server with emulated SPIDAR-Gs. Example:
//   spidar-emulator --controller simple --controller sh4:10 --log words.csv
#include "commands.hpp"
#include "fail.hpp"
#include "server.hpp"
#include "spidar/geometry.hpp"
#include "word-log.hpp"

#include <charconv>
#include <clocale>
#include <cstdio>
#include <glib.h>

namespace {

using emulator::Model;
using spidar::Cause;
using spidar::fail;
namespace messages = spidar::messages;

constexpr int kMostUnits = 8; // the ports of one virtual hub

struct Options {
  std::vector<std::string> controllers;
  std::vector<std::string> commands;
  std::string hand = "hold:0,0,0";
  std::string geometry = spidar::kDefaultGeometry;
  std::string log;
  emulator::ServerOptions server;
};

struct FreeDeleter {
  void operator()(char *text) const { g_free(text); }
  void operator()(char **texts) const { g_strfreev(texts); }
  void operator()(GOptionContext *context) const { g_option_context_free(context); }
  void operator()(GError *error) const { g_error_free(error); }
};

/// Moves a text that GOption allocated to a string.
void move_to(std::string &to, char *text) {
  const std::unique_ptr<char, FreeDeleter> owned(text);
  if (owned)
    to = owned.get();
}

std::vector<std::string> list(char **texts) {
  const std::unique_ptr<char *, FreeDeleter> owned(texts);
  std::vector<std::string> result;
  for (char **text = texts; text && *text; ++text)
    result.emplace_back(*text);
  return result;
}

Options parse(int argc, char **argv) {
  char **controllers = nullptr;
  char **commands = nullptr;
  char *hand = nullptr;
  char *geometry = nullptr;
  char *log = nullptr;
  char *listen = nullptr;
  char *control = nullptr;
  int port = 3240;
  const GOptionEntry entries[] = {
      {"controller", 'c', 0, G_OPTION_ARG_STRING_ARRAY, &controllers,
       "simple or sh4, with :ID for the rotary switch (0 to 15). Give it once for each unit "
       "(default: one simple)",
       "MODEL[:ID]"},
      {"hand", 'H', 0, G_OPTION_ARG_STRING, &hand,
       "who holds the grips: hold:X,Y,Z, circle:RADIUS,PERIOD, file:PATH or free. Lengths are -1 "
       "to 1 of the half workspace, PERIOD is in seconds",
       "SCRIPT"},
      {"geometry", 'g', 0, G_OPTION_ARG_STRING, &geometry,
       "geometry of the units, a name or a file", "GEOMETRY"},
      {"log", 'l', 0, G_OPTION_ARG_FILENAME, &log,
       "write every D/A word and event with its time as CSV", "FILE"},
      {"do", 'd', 0, G_OPTION_ARG_STRING_ARRAY, &commands,
       "run a command at the start; the commands are below", "COMMAND"},
      {"control", 0, 0, G_OPTION_ARG_FILENAME, &control, "also take commands from a local socket",
       "PATH"},
      {"listen", 0, 0, G_OPTION_ARG_STRING, &listen,
       "address to listen on (default: only this machine can connect)", "ADDRESS"},
      {"port", 'p', 0, G_OPTION_ARG_INT, &port, "TCP port; 0 takes a free one (default: 3240)",
       "PORT"},
      {nullptr, 0, 0, G_OPTION_ARG_NONE, nullptr, nullptr, nullptr}};
  const std::unique_ptr<GOptionContext, FreeDeleter> context(g_option_context_new(nullptr));
  g_option_context_set_summary(
      context.get(), "Emulates SPIDAR-G controllers, which a machine attaches over USB/IP.\n\n"
                     "Example: spidar-emulator --controller simple --hand circle:0.5,4");
  g_option_context_add_main_entries(context.get(), entries, nullptr);
  g_option_context_set_description(
      context.get(),
      (std::string(
           "Commands come from standard input, the control socket or --do. @UNIT at the end\n"
           "sends a command to one unit only, counted from 1:\n") +
       emulator::kCommandHelp)
          .c_str());
  GError *raw = nullptr;
  const bool parsed = g_option_context_parse(context.get(), &argc, &argv, &raw) != 0;
  const std::unique_ptr<GError, FreeDeleter> error(raw);
  Options options;
  options.controllers = list(controllers);
  options.commands = list(commands);
  move_to(options.hand, hand);
  move_to(options.geometry, geometry);
  move_to(options.log, log);
  move_to(options.server.address, listen);
  move_to(options.server.control, control);
  if (!parsed)
    fail(Cause::argument, messages::kEmulatorOption, error->message);
  if (argc > 1)
    fail(Cause::argument, messages::kEmulatorArgument, argv[1]);
  if (port < 0 || port > 65535)
    fail(Cause::argument, messages::kEmulatorPort);
  options.server.port = static_cast<std::uint16_t>(port);
  if (options.controllers.empty())
    options.controllers = {"simple"};
  if (options.controllers.size() > kMostUnits)
    fail(Cause::argument, messages::kEmulatorUnits);
  return options;
}

/// Parses `simple` or `sh4` with an optional rotary switch, `number` - 1 by default.
std::pair<Model, int> parse_controller(const std::string &text, int number) {
  const std::size_t colon = text.find(':');
  const std::string model = text.substr(0, colon);
  int id = number - 1;
  if (colon != std::string::npos) {
    const char *last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data() + colon + 1, last, id);
    if (error != std::errc() || end != last || id < 0 || id > 15)
      fail(Cause::argument, messages::kEmulatorSwitch, text.c_str());
  }
  if (model != "simple" && model != "sh4")
    fail(Cause::argument, messages::kEmulatorModel, text.c_str());
  return {model == "simple" ? Model::simple : Model::sh4, id};
}

void run(int argc, char **argv) {
  const Options options = parse(argc, argv);
  const spidar::Geometry geometry = spidar::load_geometry(options.geometry);
  std::unique_ptr<emulator::WordLog> log;
  if (!options.log.empty())
    log = std::make_unique<emulator::WordLog>(options.log);
  emulator::Units units;
  for (const std::string &controller : options.controllers) {
    const int number = static_cast<int>(units.size()) + 1;
    const auto [model, id] = parse_controller(controller, number);
    emulator::Plant plant(geometry, spidar::parse_hand_script(options.hand));
    emulator::Firmware::Listener listener;
    if (log)
      listener = [&log, number](emulator::Time time, const std::string &event,
                                const spidar::DacWords &words) {
        log->add(time, number, event, words);
      };
    emulator::Firmware firmware(model, id, std::move(plant), static_cast<unsigned>(number),
                                std::move(listener));
    units.push_back(std::make_unique<emulator::Unit>(number, std::move(firmware)));
    units.back()->plug(emulator::Clock::now());
  }
  for (const std::string &command : options.commands) {
    std::vector<std::vector<emulator::Completion>> done;
    emulator::obey(command, units, emulator::Clock::now(), done);
  }
  emulator::serve(options.server, units, log.get());
}

} // namespace

int main(int argc, char **argv) {
  std::setlocale(LC_CTYPE, ""); // of what --help prints
  try {
    run(argc, argv);
    return 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "spidar-emulator: %s\n", error.what());
    return 1;
  }
}
