// SPDX-License-Identifier: LGPL-2.1-or-later
#include "window/session-text.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace program {
namespace {

struct Words {
  const char *reason; // a name of docs/formats/csv-log.md
  const char *text;
};
// The first that applies is shown.
constexpr std::array kHeld = {
    Words{"paused", "Force off: the film is paused"},
    Words{"no-pose", "Force off: the position of the grip is not known"},
    Words{"slipped", "Force off: a string slipped. Hold the grip in the centre and press Ctrl+C"},
    Words{"dead-man", "Force off: press the button of the device"},
    Words{"flushing", "Force off: seeking"},
    Words{"ended", "Force off: the film has ended"},
    Words{"cut", "Force off: another scene began"},
    Words{"stale", "Force off: no new frame"},
    Words{"gap", "Force off: nothing can be measured here"},
    Words{"late", "Force off: this machine is too busy"},
    Words{"non-finite", "Force off: a number was out of range"},
};
constexpr std::array kFaults = {
    Words{"overspeed", "Force off: the grip was let go. Take it and press s"},
    Words{"shaking", "Force off: it shook the hand. Hold the grip firmly and press s"},
    Words{"suspended", "Force off: the machine slept. Take the grip and press s"},
    Words{"faulted", "Force off: the device does not answer. Check its cable and press s"},
};

// `reason`: of the statistics, after "limited-by-".
constexpr std::array kLimited = {
    Words{"work", "the work on the hand"},
    Words{"budget", "the continuous force"},
    Words{"energy", "the energy of the hand"},
    Words{"force", "the maximum force"},
    Words{"torque", "the maximum torque"},
    Words{"slew", "the slew rate"},
    Words{"confidence", "the confidence of the motion"},
    Words{"fade", "a fade"},
};

template <std::size_t N>
std::string first_of(const std::array<Words, N> &table, const std::string &reasons,
                     const char *otherwise) {
  const std::string list = "," + reasons + ",";
  for (const Words &words : table)
    if (list.find(std::string(",") + words.reason + ",") != std::string::npos)
      return words.text;
  return otherwise;
}

struct Color {
  double r, g, b;
};
// Okabe and Ito's palette, which the colour-blind can tell apart.
constexpr Color kGreen{0, 0.62, 0.45};
constexpr Color kOrange{0.84, 0.37, 0};
constexpr Color kGrey{0.5, 0.5, 0.5};
constexpr Color kBlue{0.34, 0.71, 0.91};

void set(cairo_t *cairo, const Color &color) {
  cairo_set_source_rgb(cairo, color.r, color.g, color.b);
}

} // namespace

Light light_of(const Session &session, bool armed) {
  if (session.state == "armed")
    return Light::on;
  if (session.state == "held" || (session.state == "open" && armed))
    return Light::waiting;
  return session.state == "faulted" ? Light::fault : Light::off;
}

std::string session_sentence(const Session &session, bool armed) {
  if (session.state == "armed")
    return "Force on";
  if (session.state == "held")
    return first_of(kHeld, session.reason, "Force off for a moment");
  if (session.state == "open")
    return armed ? "Force off: the position of the grip is not known"
                 : "Force off: hold the grip in the centre and press s";
  if (session.state == "homed")
    return "Force off: press s to switch it on";
  if (session.state == "faulted")
    return first_of(kFaults, session.reason, "Force off after a fault: press s");
  return "Force off: no device is open";
}

std::string LimitWatch::update(const GstStructure *statistics) {
  static_assert(kLimits == kLimited.size());
  Ticks now;
  if (statistics) {
    gst_structure_get_uint64(statistics, "ticks", &now.all);
    for (std::size_t i = 0; i < kLimits; ++i)
      gst_structure_get_uint64(
          statistics, (std::string("limited-by-") + kLimited[i].reason).c_str(), &now.limited[i]);
  }
  const Ticks before = std::exchange(before_, now);
  if (now.all <= before.all) // another run
    return {};
  for (std::size_t i = 0; i < kLimits; ++i)
    if (2 * (now.limited[i] - before.limited[i]) > now.all - before.all)
      return kLimited[i].text;
  return {};
}

// On: a disc. Waiting: a disc half full. Off: a ring. Fault: a triangle.
void draw_light(cairo_t *cairo, double size, Light light) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double middle = size / 2;
  const double radius = 0.36 * size;
  cairo_set_line_width(cairo, size / 9);
  switch (light) {
  case Light::on:
    set(cairo, kGreen);
    cairo_arc(cairo, middle, middle, radius, 0, kTurn);
    cairo_fill(cairo);
    break;
  case Light::waiting:
    set(cairo, kBlue);
    cairo_arc(cairo, middle, middle, radius, 0, kTurn);
    cairo_stroke(cairo);
    cairo_arc(cairo, middle, middle, radius, kTurn / 4, 3 * kTurn / 4);
    cairo_fill(cairo);
    break;
  case Light::off:
    set(cairo, kGrey);
    cairo_arc(cairo, middle, middle, radius, 0, kTurn);
    cairo_stroke(cairo);
    break;
  case Light::fault:
    set(cairo, kOrange);
    cairo_move_to(cairo, middle, middle - radius);
    cairo_line_to(cairo, middle + radius, middle + radius);
    cairo_line_to(cairo, middle - radius, middle + radius);
    cairo_close_path(cairo);
    cairo_fill(cairo);
    break;
  }
}

} // namespace program
