// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/source.hpp"

#include "glue/content-only.hpp"
#include "glue/gst-raii.hpp"

#include <gio/gio.h>
#include <glib/gstdio.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

namespace program {
namespace {

using haptic::CapsPtr;
using haptic::GCharPtr;

constexpr const char *kNamesOthers = "it lists other files or addresses, which are not opened";

// Cameras offer their largest frames at a few frames a second; the tracker needs at least 15.
constexpr const char *kCameraCaps =
    "video/x-raw,framerate=[15/1,120/1];image/jpeg,framerate=[15/1,120/1]";
constexpr const char *kTestCaps = "video/x-raw,width=352,height=288,framerate=30/1";
constexpr unsigned kVideo4Linux = 81; // device number of every camera

bool is_url(const std::string &text) {
  return text.find("://") != std::string::npos;
}

bool is_file_url(const std::string &text) {
  return g_ascii_strncasecmp(text.c_str(), "file://", 7) == 0;
}

std::string base_name(const std::string &path) {
  const GCharPtr name(g_path_get_basename(path.c_str()));
  const GCharPtr shown(g_filename_display_name(name.get()));
  return shown.get();
}

std::string problem_of_file(const std::string &path, const std::string &title) {
  GStatBuf status{};
  if (g_stat(path.c_str(), &status) != 0)
    return "There is no file “" + title + "”. Check its name, or open another.";
  if (S_ISDIR(status.st_mode))
    return "“" + title + "” is a folder. Open a film in it.";
  if (g_access(path.c_str(), R_OK) != 0)
    return "The file “" + title + "” may not be read by you. Change its permissions.";
  if (S_ISREG(status.st_mode) && status.st_size == 0)
    return "The file “" + title + "” is empty. Open another.";
  return "";
}

std::string problem_of_camera(const std::string &path) {
  GStatBuf status{};
  if (g_stat(path.c_str(), &status) != 0)
    return "There is no camera " + path +
           ". Plug one in, or choose another ("
           "Ctrl+K).";
  if (!S_ISCHR(status.st_mode) || major(status.st_rdev) != kVideo4Linux)
    return path + " is not a camera. Choose another (Ctrl+K).";
  if (g_access(path.c_str(), R_OK | W_OK) != 0)
    return "The camera " + path + " may not be used by you. As root run “usermod -aG video " +
           g_get_user_name() + "”, and log in again.";
  return "";
}

// Whether the user typed the address of a playlist.
bool is_playlist(const Source &source) {
  const std::string path = source.name.substr(0, source.name.find_first_of("?#"));
  return source.kind == SourceKind::url &&
         (g_str_has_suffix(path.c_str(), ".m3u8") || g_str_has_suffix(path.c_str(), ".mpd"));
}

// Of the segments that a playlist of a server lists, none may be a file of this machine.
void close_files(GstBin *, GstBin *, GstElement *element, gpointer) {
  const GstElementFactory *factory = gst_element_get_factory(element);
  if (factory && g_str_equal(GST_OBJECT_NAME(factory), "filesrc"))
    g_object_set(element, "location", nullptr, nullptr);
}

GstElement *add(GstBin *pipeline, const char *factory) {
  GstElement *element = gst_element_factory_make(factory, nullptr);
  if (element)
    gst_bin_add(pipeline, element);
  return element;
}

// The leaky queue drops all but the newest frame.
GstElement *add_live(GstBin *pipeline, const Source &source) {
  const bool test = source.kind == SourceKind::test;
  GstElement *input = add(pipeline, test ? "videotestsrc" : "v4l2src");
  GstElement *filter = add(pipeline, "capsfilter");
  GstElement *queue = add(pipeline, "queue");
  GstElement *decoder = add(pipeline, "decodebin");
  if (!input || !filter || !queue || !decoder)
    return nullptr;
  const CapsPtr caps(gst_caps_from_string(test ? kTestCaps : kCameraCaps));
  g_object_set(filter, "caps", caps.get(), nullptr);
  gst_util_set_object_arg(G_OBJECT(queue), "leaky", "downstream");
  g_object_set(queue, "max-size-buffers", 1, nullptr);
  if (test) {
    gst_util_set_object_arg(G_OBJECT(input), "pattern", "checkers-8");
    g_object_set(input, "is-live", TRUE, "horizontal-speed", 2, nullptr);
  } else {
    g_object_set(input, "device", source.name.c_str(), nullptr);
  }
  gst_element_link_many(input, filter, queue, decoder, nullptr);
  return decoder;
}

} // namespace

Source source_named(const std::string &argument, const std::string &folder) {
  if (argument == "test")
    return {SourceKind::test, "test", "Test film"};
  if (argument == "camera")
    return {SourceKind::camera, "/dev/video0", "Camera"};
  if (g_str_has_prefix(argument.c_str(), "/dev/video"))
    return {SourceKind::camera, argument, argument};
  if (is_url(argument) && !is_file_url(argument))
    return {SourceKind::url, argument, argument};
  // GIO takes the begin of a:b.mp4 for a scheme.
  const GCharPtr full(g_canonicalize_filename(argument.c_str(), folder.c_str()));
  GFile *file = g_file_test(full.get(), G_FILE_TEST_EXISTS)
                    ? g_file_new_for_path(full.get())
                    : g_file_new_for_commandline_arg_and_cwd(argument.c_str(), folder.c_str());
  const GCharPtr path(g_file_get_path(file));
  g_object_unref(file);
  if (!path) // neither a file nor a URL: problem_of() says so
    return {SourceKind::url, argument, argument};
  return {SourceKind::file, path.get(), base_name(path.get())};
}

std::string problem_of(const Source &source) {
  switch (source.kind) {
  case SourceKind::file:
    return problem_of_file(source.name, source.title);
  case SourceKind::camera:
    return problem_of_camera(source.name);
  case SourceKind::url:
    return is_url(source.name) && !is_file_url(source.name)
               ? ""
               : "“" + source.title +
                     "” is neither a file nor a URL. A URL begins with https://, http:// or "
                     "rtsp://.";
  default:
    return "";
  }
}

GstElement *add_source(GstBin *pipeline, const Source &source, bool with_sound) {
  if (source.is_live())
    return add_live(pipeline, source);
  GstElement *decoder = add(pipeline, "uridecodebin");
  if (!decoder)
    return nullptr;
  const GCharPtr uri(source.kind == SourceKind::file
                         ? gst_filename_to_uri(source.name.c_str(), nullptr)
                         : g_strdup(source.name.c_str()));
  const CapsPtr caps(
      gst_caps_from_string(with_sound ? "video/x-raw(ANY);audio/x-raw(ANY)" : "video/x-raw(ANY)"));
  g_object_set(decoder, "uri", uri.get(), "caps", caps.get(), "expose-all-streams", FALSE,
               "use-buffering", static_cast<gboolean>(g_str_has_prefix(uri.get(), "http")),
               nullptr);
  if (is_playlist(source))
    g_signal_connect(decoder, "deep-element-added", G_CALLBACK(close_files), nullptr);
  else
    haptic::open_content_only(decoder, kNamesOthers);
  return decoder;
}

} // namespace program
