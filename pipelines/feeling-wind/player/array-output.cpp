// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/array-output.hpp"

#include "glue/gst-raii.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>

namespace program {
namespace {

constexpr const char *kBranch = "queue max-size-buffers=1 ! velocityavg ! hapticarray name=array ! "
                                "level interval=40000000 ! audioconvert ! ";
// The usual 200 ms would delay the hand and the picture of a camera, too.
constexpr gint64 kBuffer = 20'000; // us
constexpr gint64 kPeriod = 5'000;  // us

constexpr double kPanel = 150; // px, the longer side of the array
constexpr double kPictureMargin = 14;
constexpr double kPictureTextSize = 12;
constexpr double kLargestDot = 18;
constexpr double kRest = 0.16; // of the largest dot, an actuator at rest

// The sink of autoaudiosink appears when it starts.
void shorten_buffer(GstBin *, GstBin *, GstElement *element, gpointer) noexcept {
  GObjectClass *klass = G_OBJECT_GET_CLASS(element);
  if (g_object_class_find_property(klass, "buffer-time") &&
      g_object_class_find_property(klass, "latency-time"))
    g_object_set(element, "buffer-time", kBuffer, "latency-time", kPeriod, nullptr);
}

// The box about all actuators, m.
struct Box {
  double left = std::numeric_limits<double>::infinity();
  double right = -left;
  double bottom = left;
  double top = -left;

  explicit Box(const std::vector<haptic::Actuator> &actuators) {
    for (const haptic::Actuator &actuator : actuators) {
      left = std::min(left, actuator.x);
      right = std::max(right, actuator.x);
      bottom = std::min(bottom, actuator.y);
      top = std::max(top, actuator.y);
    }
  }
  double side() const { return std::max(right - left, top - bottom); }
};

// Distance of the two actuators that are closest, m.
double closest(const std::vector<haptic::Actuator> &actuators) {
  double found = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < actuators.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      found = std::min(
          found, std::hypot(actuators[i].x - actuators[j].x, actuators[i].y - actuators[j].y));
  return found;
}

} // namespace

std::string ArrayOutput::add(GstBin *pipeline, GstElement *tee, const ArraySetup &setup) {
  remove();
  try {
    actuators_ = haptic::load_array_layout(setup.layout).actuators;
  } catch (const std::exception &error) {
    return error.what();
  }
  GError *error = nullptr;
  GstElement *branch = gst_parse_bin_from_description((kBranch + setup.sink).c_str(), TRUE, &error);
  const haptic::ErrorPtr owned(error);
  if (!branch || error) {
    if (branch)
      gst_object_unref(gst_object_ref_sink(branch));
    remove();
    return std::string(error->message) + ". Check --array-sink.";
  }
  gst_object_set_name(GST_OBJECT(branch), "array-branch");
  g_signal_connect(branch, "deep-element-added", G_CALLBACK(shorten_buffer), nullptr);
  const haptic::ElementPtr array(gst_bin_get_by_name(GST_BIN(branch), "array"));
  g_object_set(array.get(), "layout", setup.layout.c_str(), nullptr);
  gst_bin_add(pipeline, branch);
  if (!gst_element_link(tee, branch)) {
    gst_bin_remove(pipeline, branch);
    remove();
    return "The film cannot be felt on an array. Check --array-sink.";
  }
  const haptic::GCharPtr name(g_path_get_basename(setup.layout.c_str()));
  name_ = name.get();
  return "";
}

void ArrayOutput::remove() {
  actuators_.clear();
  levels_.clear();
}

// Its values are a GValueArray, for which there is nothing newer in this message.
void ArrayOutput::read_levels(const GstStructure *message) {
  const GValue *value = gst_structure_get_value(message, "peak");
  if (!value)
    return;
  G_GNUC_BEGIN_IGNORE_DEPRECATIONS
  const auto *peaks = static_cast<const GValueArray *>(g_value_get_boxed(value));
  levels_.clear();
  for (guint i = 0; i < peaks->n_values; ++i)
    levels_.push_back(std::pow(10, g_value_get_double(&peaks->values[i]) / 20)); // of dB
  G_GNUC_END_IGNORE_DEPRECATIONS
}

void ArrayOutput::draw(cairo_t *cairo, double width, double height) const {
  if (actuators_.empty())
    return;
  const Box box(actuators_);
  const double scale = std::min(kPanel, 0.4 * std::min(width, height)) / box.side();
  const double largest = std::min(kLargestDot, 0.45 * scale * closest(actuators_));
  const double rim = largest + 4;
  const double panel_width = scale * (box.right - box.left) + 2 * rim;
  const double panel_height = scale * (box.top - box.bottom) + 2 * rim + kPictureTextSize + 4;
  const double left = width - kPictureMargin - panel_width;
  const double top = height - kPictureMargin - panel_height;

  cairo_new_path(cairo); // the film left one
  cairo_set_source_rgba(cairo, 0, 0, 0, 0.6);
  cairo_rectangle(cairo, left, top, panel_width, panel_height);
  cairo_fill(cairo);
  cairo_set_line_width(cairo, 1);
  for (std::size_t i = 0; i < actuators_.size(); ++i) {
    const double x = left + rim + scale * (actuators_[i].x - box.left);
    const double y = top + rim + scale * (box.top - actuators_[i].y);
    const double level = i < levels_.size() ? std::clamp(levels_[i], 0.0, 1.0) : 0;
    cairo_set_source_rgba(cairo, 1, 1, 1, 0.5);
    cairo_arc(cairo, x, y, largest, 0, 2 * std::numbers::pi);
    cairo_stroke(cairo);
    cairo_set_source_rgb(cairo, 0.34, 0.71, 0.91); // the blue of the force
    cairo_arc(cairo, x, y, largest * (kRest + (1 - kRest) * level), 0, 2 * std::numbers::pi);
    cairo_fill(cairo);
  }
  cairo_set_source_rgb(cairo, 1, 1, 1);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, kPictureTextSize);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, name_.c_str(), &extents);
  cairo_move_to(cairo, left + std::max(2.0, (panel_width - extents.width) / 2),
                top + panel_height - 6);
  cairo_show_text(cairo, name_.c_str());
}

} // namespace program
