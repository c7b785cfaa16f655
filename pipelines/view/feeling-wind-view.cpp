// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs a pipeline in a window, draws velocity and force below the video, and handles keys.
// pipelines/view.sh writes the command line:
//
//   feeling-wind-view [--verbose] ELEMENT ! ELEMENT ...
//
// The pipeline has gst-launch-1.0's syntax and contains a roitracker, a velocityavg with
// post-messages=true, a hapticsink and a gtksink. Returns 0 when the user quits, 1 after an error.
#include "gst-raii.hpp"
#include "gsthapticmotionmeta.h"
#include "playback.hpp"
#include "region-size.hpp"
#include "strip-chart.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <glib-unix.h>
#include <gst/video/video.h>
#include <gtk/gtk.h>
#include <limits>
#include <memory>
#include <string>

namespace {

using haptic::ElementPtr;
using haptic::ErrorPtr;
using Clock = std::chrono::steady_clock;

constexpr const char *kKeys =
    "space pause, - slower, + faster, r reverse, [ ] region size, 0 default size, "
    "< weaker, > stronger, l force law, s force off and on, q quit";
constexpr int kWindowWidth = 800;
constexpr int kVideoHeight = 500;
constexpr int kStripHeight = 150;
constexpr double kRegionStep = 1.25;
constexpr double kStrengthStep = 1.5;
constexpr double kWeakest = 1e-4;   // s/px
constexpr double kLongestGap = 0.5; // s; a longer pause takes no more room on the strip

void print_error(const std::string &text) {
  std::fprintf(stderr, "feeling-wind-view: %s\n", text.c_str());
}

// The message when an error comes before the first frame. GStreamer's own text names no cure for
// stream errors.
std::string no_frame_message(const GError &error) {
  const bool of_stream = error.domain == GST_STREAM_ERROR;
  return std::string("no frame can be shown: ") + error.message +
         (of_stream ? " Is it a video, and is its decoder installed (gstreamer1.0-libav)?" : "");
}

// Returns the first element that `factory` made, or nothing.
ElementPtr find(GstElement *pipeline, const char *factory) {
  GstIterator *elements = gst_bin_iterate_recurse(GST_BIN(pipeline));
  GValue item = G_VALUE_INIT;
  GstElement *found = nullptr;
  while (!found && gst_iterator_next(elements, &item) == GST_ITERATOR_OK) {
    auto *element = GST_ELEMENT(g_value_get_object(&item));
    const GstElementFactory *maker = gst_element_get_factory(element);
    if (maker && std::strcmp(GST_OBJECT_NAME(maker), factory) == 0)
      found = GST_ELEMENT(gst_object_ref(element));
    g_value_reset(&item);
  }
  g_value_unset(&item);
  gst_iterator_free(elements);
  return ElementPtr(found);
}

// The window and its pipeline. Main thread only.
class View {
public:
  View(ElementPtr pipeline, bool verbose, Clock::time_point start)
      : pipeline_(std::move(pipeline)), playback_(pipeline_.get()), verbose_(verbose),
        start_(start) {}
  ~View() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  View(const View &) = delete;
  View &operator=(const View &) = delete;

  int run();

private:
  bool find_elements();
  void make_window();
  void connect_bus_and_signals();

  gboolean handle_key(guint key);
  void handle_message(GstMessage *message);
  void add_reading(const GstStructure *fields);
  void note_first_frame();
  void show_note(const std::string &text);
  void fail(const std::string &text);

  int frame_width() const;
  void scale_region(double factor);
  void scale_strength(double factor);
  void next_law();
  void toggle_force();
  std::string law() const;
  std::string caption() const;

  ElementPtr pipeline_;
  ElementPtr tracker_, haptic_, sink_;
  view::Playback playback_;
  view::StripChart chart_;
  GtkWidget *window_ = nullptr;
  GtkWidget *strip_ = nullptr;
  const bool verbose_;
  const Clock::time_point start_;
  Clock::time_point last_reading_{};
  bool has_shown_frame_ = false;
  view::Reading newest_;
  std::string note_ = kKeys;
  int status_ = EXIT_SUCCESS;
};

bool View::find_elements() {
  tracker_ = find(pipeline_.get(), "roitracker");
  haptic_ = find(pipeline_.get(), "hapticsink");
  sink_ = find(pipeline_.get(), "gtksink");
  return tracker_ && haptic_ && sink_;
}

void View::make_window() {
  GtkWidget *video = nullptr;
  g_object_get(sink_.get(), "widget", &video, nullptr);
  window_ = gtk_window_new(GTK_WINDOW_TOPLEVEL);
  gtk_window_set_title(GTK_WINDOW(window_), "Feeling Wind");
  gtk_window_set_default_size(GTK_WINDOW(window_), kWindowWidth, kVideoHeight + kStripHeight);
  GtkWidget *box = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
  strip_ = gtk_drawing_area_new();
  gtk_widget_set_size_request(strip_, -1, kStripHeight);
  gtk_box_pack_start(GTK_BOX(box), video, TRUE, TRUE, 0);
  gtk_box_pack_start(GTK_BOX(box), strip_, FALSE, FALSE, 0);
  gtk_container_add(GTK_CONTAINER(window_), box);
  g_object_unref(video);

  g_signal_connect(window_, "destroy", G_CALLBACK(gtk_main_quit), nullptr);
  g_signal_connect(window_, "key-press-event",
                   G_CALLBACK(+[](GtkWidget *, GdkEventKey *event, gpointer self) noexcept {
                     return static_cast<View *>(self)->handle_key(event->keyval);
                   }),
                   this);
  g_signal_connect(strip_, "draw",
                   G_CALLBACK(+[](GtkWidget *widget, cairo_t *cairo, gpointer data) noexcept {
                     const View &self = *static_cast<View *>(data);
                     self.chart_.draw(cairo, gtk_widget_get_allocated_width(widget),
                                      gtk_widget_get_allocated_height(widget), self.caption());
                     return gboolean{TRUE};
                   }),
                   this);
  g_signal_connect_after(video, "draw",
                         G_CALLBACK(+[](GtkWidget *, cairo_t *, gpointer self) noexcept {
                           static_cast<View *>(self)->note_first_frame();
                           return gboolean{FALSE};
                         }),
                         this);
  gtk_widget_show_all(window_);
}

void View::connect_bus_and_signals() {
  GstBus *bus = gst_element_get_bus(pipeline_.get());
  gst_bus_add_watch(
      bus,
      [](GstBus *, GstMessage *message, gpointer self) noexcept -> gboolean {
        static_cast<View *>(self)->handle_message(message);
        return G_SOURCE_CONTINUE;
      },
      this);
  gst_object_unref(bus);
  for (const int signal : {SIGINT, SIGTERM})
    g_unix_signal_add(
        signal,
        [](gpointer) noexcept -> gboolean {
          gtk_main_quit();
          return G_SOURCE_CONTINUE;
        },
        nullptr);
}

int View::run() {
  if (!find_elements()) {
    print_error(
        "the pipeline needs a roitracker, a hapticsink and a gtksink; view.sh writes such a line");
    return EXIT_FAILURE;
  }
  make_window();
  connect_bus_and_signals();
  playback_.start(); // a failure arrives as a message on the bus
  gtk_main();
  return status_;
}

void View::fail(const std::string &text) {
  print_error(text);
  status_ = EXIT_FAILURE;
  gtk_main_quit();
}

void View::show_note(const std::string &text) {
  note_ = text;
  if (verbose_)
    std::printf("%s\n", text.c_str()), std::fflush(stdout);
  gtk_widget_queue_draw(strip_);
}

void View::note_first_frame() {
  GstSample *sample = nullptr;
  if (has_shown_frame_)
    return;
  g_object_get(sink_.get(), "last-sample", &sample, nullptr);
  if (!sample)
    return;
  gst_sample_unref(sample);
  has_shown_frame_ = true;
  if (verbose_) {
    std::printf("first frame after %.2f s\n",
                std::chrono::duration<double>(Clock::now() - start_).count());
    std::fflush(stdout);
  }
}

void View::handle_message(GstMessage *message) {
  GError *error = nullptr;
  switch (GST_MESSAGE_TYPE(message)) {
  case GST_MESSAGE_ERROR: {
    gst_message_parse_error(message, &error, nullptr);
    const ErrorPtr owned(error);
    fail(has_shown_frame_ ? error->message : no_frame_message(*error));
    break;
  }
  case GST_MESSAGE_WARNING: {
    gst_message_parse_warning(message, &error, nullptr);
    const ErrorPtr owned(error);
    // An error message follows.
    if (g_error_matches(error, GST_PARSE_ERROR, GST_PARSE_ERROR_DELAYED_LINK))
      break;
    print_error(error->message);
    show_note(error->message);
    break;
  }
  case GST_MESSAGE_EOS:
    if (!has_shown_frame_)
      fail("the video holds no frames; try another file");
    else if (!playback_.restart())
      gtk_main_quit();
    break;
  case GST_MESSAGE_ELEMENT:
    if (gst_message_has_name(message, "haptic-motion"))
      add_reading(gst_message_get_structure(message));
    break;
  default:
    break;
  }
}

void View::add_reading(const GstStructure *fields) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto now = Clock::now();
  const double since = std::chrono::duration<double>(now - last_reading_).count();
  last_reading_ = now;
  newest_ = {std::min(since, kLongestGap), kUnknown, kUnknown, kUnknown, kUnknown};
  double confidence = 0;
  if (gst_structure_get_double(fields, "confidence", &confidence) && confidence > 0)
    gst_structure_get(fields, "vx", G_TYPE_DOUBLE, &newest_.vx, "vy", G_TYPE_DOUBLE, &newest_.vy,
                      nullptr);
  GstSample *sample = nullptr;
  g_object_get(sink_.get(), "last-sample", &sample, nullptr);
  if (sample) {
    if (const auto *motion = gst_buffer_get_haptic_motion_meta(gst_sample_get_buffer(sample))) {
      newest_.fx = static_cast<double>(motion->force_x);
      newest_.fy = static_cast<double>(motion->force_y);
    }
    gst_sample_unref(sample);
  }
  chart_.add(newest_);
  gtk_widget_queue_draw(strip_);
}

gboolean View::handle_key(guint key) {
  const auto show_rate = [&](bool done) {
    char text[64];
    std::snprintf(text, sizeof text, "playing at %g times normal speed", playback_.rate());
    show_note(done ? text : "this video cannot be played at that speed or backwards");
  };
  switch (key) {
  case GDK_KEY_space:
    playback_.toggle_pause();
    show_note(playback_.paused() ? "paused" : "playing");
    break;
  case GDK_KEY_minus:
  case GDK_KEY_KP_Subtract:
    show_rate(playback_.slower());
    break;
  case GDK_KEY_plus:
  case GDK_KEY_equal:
  case GDK_KEY_KP_Add:
    show_rate(playback_.faster());
    break;
  case GDK_KEY_r:
    show_rate(playback_.reverse());
    break;
  case GDK_KEY_bracketleft:
    scale_region(1 / kRegionStep);
    break;
  case GDK_KEY_bracketright:
    scale_region(kRegionStep);
    break;
  case GDK_KEY_0:
    g_object_set(tracker_.get(), "roi-size", 0, nullptr);
    show_note("region of the default size");
    break;
  case GDK_KEY_less:
  case GDK_KEY_comma:
    scale_strength(1 / kStrengthStep);
    break;
  case GDK_KEY_greater:
  case GDK_KEY_period:
    scale_strength(kStrengthStep);
    break;
  case GDK_KEY_l:
    next_law();
    break;
  case GDK_KEY_s:
  case GDK_KEY_Escape:
    toggle_force();
    break;
  case GDK_KEY_q:
    gtk_main_quit();
    break;
  default:
    return FALSE;
  }
  return TRUE;
}

int View::frame_width() const {
  GstPad *pad = gst_element_get_static_pad(tracker_.get(), "sink");
  const haptic::CapsPtr caps(gst_pad_get_current_caps(pad));
  gst_object_unref(pad);
  int width = 0;
  if (caps)
    gst_structure_get_int(gst_caps_get_structure(caps.get(), 0), "width", &width);
  return width;
}

void View::scale_region(double factor) {
  const int width = frame_width();
  guint size = 0;
  g_object_get(tracker_.get(), "roi-size", &size, nullptr);
  if (size == 0)
    size = static_cast<guint>(haptic::default_region_side(width));
  constexpr auto kSmallest = static_cast<guint>(haptic::kSmallestRegion);
  size = static_cast<guint>(std::lround(size * factor));
  size = std::clamp(size, kSmallest, std::max(kSmallest, static_cast<guint>(width) / 2));
  g_object_set(tracker_.get(), "roi-size", size, nullptr);
  show_note("region of " + std::to_string(size) + " px");
}

// alpha: how much force a slow motion gives; the greatest force stays.
void View::scale_strength(double factor) {
  double alpha = 0;
  g_object_get(haptic_.get(), "alpha", &alpha, nullptr);
  const auto *range =
      G_PARAM_SPEC_DOUBLE(g_object_class_find_property(G_OBJECT_GET_CLASS(haptic_.get()), "alpha"));
  alpha = std::clamp(alpha * factor, kWeakest, range->maximum);
  g_object_set(haptic_.get(), "alpha", alpha, nullptr);
  char text[64];
  std::snprintf(text, sizeof text, "strength (alpha) %.3g s/px", alpha);
  show_note(text);
}

std::string View::law() const {
  gint value = 0;
  g_object_get(haptic_.get(), "force-law", &value, nullptr);
  const auto *spec = G_PARAM_SPEC_ENUM(
      g_object_class_find_property(G_OBJECT_GET_CLASS(haptic_.get()), "force-law"));
  const GEnumValue *found = g_enum_get_value(spec->enum_class, value);
  return found ? found->value_nick : "";
}

void View::next_law() {
  gint value = 0;
  g_object_get(haptic_.get(), "force-law", &value, nullptr);
  const auto *spec = G_PARAM_SPEC_ENUM(
      g_object_class_find_property(G_OBJECT_GET_CLASS(haptic_.get()), "force-law"));
  const auto next = static_cast<guint>(value + 1) % spec->enum_class->n_values;
  g_object_set(haptic_.get(), "force-law", spec->enum_class->values[next].value, nullptr);
  show_note("force law " + law());
}

void View::toggle_force() {
  gboolean armed = FALSE;
  g_object_get(haptic_.get(), "armed", &armed, nullptr);
  g_signal_emit_by_name(haptic_.get(), armed ? "release" : "arm");
  show_note(armed ? "force off; s brings it back" : "force on");
}

std::string View::caption() const {
  const auto number = [](const char *format, double value) {
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return std::isfinite(value) ? std::string(text) : std::string("–");
  };
  return (playback_.paused() ? "paused  " : "") + number("%g×  ", playback_.rate()) + law() + "  " +
         number("%.0f px/s", std::hypot(newest_.vx, newest_.vy)) + "  " +
         number("%.2f N", std::hypot(newest_.fx, newest_.fy)) + "   " + note_;
}

// Parses the arguments as gst-launch-1.0 does. Returns nothing after an error, which it prints.
ElementPtr parse(char **line) {
  GError *error = nullptr;
  ElementPtr pipeline(gst_parse_launchv_full(const_cast<const gchar **>(line), nullptr,
                                             GST_PARSE_FLAG_FATAL_ERRORS, &error));
  const ErrorPtr owned(error);
  if (error)
    print_error(error->message);
  return error ? nullptr : std::move(pipeline);
}

} // namespace

int main(int argc, char **argv) {
  const auto start = Clock::now();
  gst_init(&argc, &argv);
  bool verbose = false;
  int first = 1;
  for (; first < argc && std::strncmp(argv[first], "--", 2) == 0; ++first) {
    if (std::strcmp(argv[first], "--verbose") == 0) {
      verbose = true;
    } else {
      std::printf("Usage: feeling-wind-view [--verbose] ELEMENT ! ELEMENT ...\n"
                  "pipelines/view.sh writes the pipeline. Keys: %s\n",
                  kKeys);
      return std::strcmp(argv[first], "--help") == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
    }
  }
  if (first == argc) {
    print_error("no pipeline given; see --help");
    return EXIT_FAILURE;
  }
  if (!gtk_init_check(&argc, &argv)) {
    print_error("there is no display for the window; run it in a graphical session");
    return EXIT_FAILURE;
  }
  ElementPtr pipeline = parse(argv + first);
  return pipeline ? View(std::move(pipeline), verbose, start).run() : EXIT_FAILURE;
}
