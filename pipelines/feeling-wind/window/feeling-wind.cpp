// SPDX-License-Identifier: LGPL-2.1-or-later
// The program for a person: shows a film, a URL or a camera, and lets the hand feel its motion.
//
//   feeling-wind [OPTION…] [FILE | URL | camera | /dev/videoN | test]
//
// main() reads the command line. Window (window.hpp) shows a Player (player.hpp) and records with a
// Recorder; keys.hpp is the table of all actions.
#include "window/keys.hpp"
#include "window/window.hpp"

#include <cstdio>
#include <cstdlib>
#include <glib-unix.h>
#include <gst/gst.h>
#include <gtk/gtk.h>
#include <string>

namespace {

using namespace program;
using haptic::ElementPtr;
using haptic::GCharPtr;

struct CommandLine {
  gchar *device = nullptr;
  gchar **options = nullptr;
  gchar *array = nullptr;
  gchar *array_sink = nullptr;
  gchar *touch = nullptr;
  gchar **inputs = nullptr;
  gboolean verbose = FALSE;
  gboolean version = FALSE;
};

struct Program {
  CommandLine line;
  WindowOptions options;
  Window *window = nullptr;
};

// The properties of hapticsink that the window changes too are its own; the others go on as they
// are. Returns why `sink` does not accept the option, in a sentence, or an empty text.
std::string read_option(WindowOptions &options, GstElement *sink, const std::string &option) {
  if (std::string problem = set_option(sink, option); !problem.empty())
    return problem;
  const std::size_t equal = option.find('=');
  const std::string name = option.substr(0, equal);
  const std::string value = option.substr(equal + 1);
  if (name == "device") {
    options.setup.device = value;
  } else if (name == "alpha") {
    g_object_get(sink, "alpha", &options.setup.alpha, nullptr);
    options.strength_given = true;
  } else if (name == "force-law") {
    options.setup.law = value;
    options.law_given = true;
  } else {
    options.setup.options.push_back(option);
  }
  return "";
}

// Without hapticsink the window says what is missing.
std::string read_options(WindowOptions &options, gchar **given) {
  const ElementPtr sink(gst_element_factory_make("hapticsink", nullptr));
  if (!sink)
    return "";
  gst_object_ref_sink(sink.get());
  for (gchar **option = given; option && *option; ++option)
    if (std::string problem = read_option(options, sink.get(), *option); !problem.empty())
      return problem;
  return "";
}

void activate(GApplication *application, gpointer data) {
  auto &program = *static_cast<Program *>(data);
  set_accelerators(GTK_APPLICATION(application));
  program.options.on_close = [&program] { program.window = nullptr; };
  program.window = new Window(GTK_APPLICATION(application), program.options); // deletes itself
  const GCharPtr folder(g_get_current_dir());
  if (program.line.inputs)
    program.window->open(source_named(program.line.inputs[0], folder.get()));
}

gboolean on_interrupt(gpointer data) noexcept {
  if (Window *window = static_cast<Program *>(data)->window)
    window->quit();
  return G_SOURCE_CONTINUE;
}

// Reads the options. Returns the exit status, or -1 to go on.
int read_line(GApplication *, GVariantDict *, gpointer data) noexcept {
  auto &program = *static_cast<Program *>(data);
  const CommandLine &line = program.line;
  if (line.version) {
    std::printf("feeling-wind %s\n", VERSION);
    return EXIT_SUCCESS;
  }
  if (line.inputs && line.inputs[1]) {
    std::fprintf(stderr, "feeling-wind: one film only; see --help\n");
    return EXIT_FAILURE;
  }
  if (const std::string problem = read_options(program.options, line.options); !problem.empty()) {
    std::fprintf(stderr, "feeling-wind: %s\n", problem.c_str());
    return EXIT_FAILURE;
  }
  if (line.device)
    program.options.setup.device = line.device;
  if (line.array)
    program.options.setup.array.layout = line.array;
  if (line.array_sink)
    program.options.setup.array.sink = line.array_sink;
  if (line.touch)
    program.options.setup.touch = line.touch;
  program.options.verbose = line.verbose;
  if (!gtk_init_check(nullptr, nullptr)) {
    std::fprintf(
        stderr,
        "feeling-wind: there is no display for the window; run it in a graphical session\n");
    return EXIT_FAILURE;
  }
  return -1;
}

} // namespace

int main(int argc, char **argv) {
  Program program;
  program.options.start = std::chrono::steady_clock::now();
  CommandLine &line = program.line;
  const GOptionEntry entries[] = {
      {"device", 0, 0, G_OPTION_ARG_STRING, &line.device,
       "haptic device: sim, usb, usb:ID, evdev, evdev:PATH or auto (default: sim). A real device "
       "begins without force",
       "DEVICE"},
      {"sink", 0, 0, G_OPTION_ARG_STRING_ARRAY, &line.options,
       "a property of hapticsink; may be given more than once", "NAME=VALUE"},
      {"array", 0, 0, G_OPTION_ARG_STRING, &line.array,
       "also drive an array of actuators: a layout of hapticarray, by name or path", "LAYOUT"},
      {"array-sink", 0, 0, G_OPTION_ARG_STRING, &line.array_sink,
       "the sound device of the array, as a sink of gst-launch-1.0 (default: autoaudiosink)",
       "SINK"},
      {"touch", 0, 0, G_OPTION_ARG_STRING, &line.touch,
       "let a hand that has depth touch the colours: a table of reliefmap, by name or path",
       "TABLE"},
      {"verbose", 0, 0, G_OPTION_ARG_NONE, &line.verbose,
       "print when the first frame was shown, and what each key did", nullptr},
      {"version", 0, 0, G_OPTION_ARG_NONE, &line.version, "print the version", nullptr},
      {G_OPTION_REMAINING, 0, 0, G_OPTION_ARG_FILENAME_ARRAY, &line.inputs, nullptr, nullptr},
      {}};
  g_set_prgname("feeling-wind"); // the name of the .desktop file
  GtkApplication *application = gtk_application_new(nullptr, G_APPLICATION_NON_UNIQUE);
  g_application_add_main_option_entries(G_APPLICATION(application), entries);
  g_application_set_option_context_parameter_string(G_APPLICATION(application),
                                                    "[FILE | URL | camera | /dev/videoN | test]");
  g_application_set_option_context_summary(
      G_APPLICATION(application),
      "Shows a film, a URL (http, https, rtsp) or a camera, and lets the hand feel its motion.\n"
      "The mouse points, or a haptic device. \"test\" is a live film that moves to the left.\n\n"
      "Example: feeling-wind --sink max-force=0.5 in.mp4");
  g_application_set_option_context_description(G_APPLICATION(application), keys_as_text().c_str());
  g_signal_connect(application, "handle-local-options", G_CALLBACK(read_line), &program);
  g_signal_connect(application, "activate", G_CALLBACK(activate), &program);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) // its terminal is closed
    g_unix_signal_add(signal, on_interrupt, &program);
  gst_init(nullptr, nullptr);
  const int status = g_application_run(G_APPLICATION(application), argc, argv);
  g_object_unref(application);
  return status;
}
