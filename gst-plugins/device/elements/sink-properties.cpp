// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/sink-properties.hpp"

#include "glue/gst-raii.hpp"

#include <iterator>
#include <vector>

namespace haptic {
namespace {

// To be called once.
GType force_law_type() {
  static std::vector<GEnumValue> values;
  for (const auto &law : force_laws())
    values.push_back({static_cast<gint>(values.size()), law.description, law.name});
  return register_enum("GstHapticSinkForceLaw", values);
}

} // namespace

std::span<const Property<SinkSettings>> sink_properties() {
  using Rows = Rows<SinkSettings>;
  using S = SinkSettings;
  using C = DeviceChoice;
  using L = LoopSettings;
  using W = LawSettings;
  using F = spidar::ForceLimits;
  static_assert(F::kMostForce == kHighestForce);
  // clang-format off
  static const Property<SinkSettings> table[] = {
      Rows::text<&S::choice, &C::device>("device", "Device",
          "auto, sim, usb, usb:ID (its rotary switch), evdev, evdev:PATH (a joystick or wheel with force "
          "feedback) or none; auto takes the first SPIDAR-G found, else the simulated one"),
      Rows::choice<&S::loop, &L::law>("force-law", "Force Law",
          "How motion becomes force", force_law_type()),
      Rows::number<&S::loop, &L::law_settings, &W::max_force>("max-force", "Maximum Force",
          "The force that no motion exceeds, N", 0, kHighestForce, kControllable),
      Rows::number<&S::loop, &L::law_settings, &W::alpha>("alpha", "Alpha",
          "Steepness of the force law, s/px, at a frame reference-width wide: 1/alpha px/s give half of "
          "max-force", 0, 10, kControllable),
      Rows::number<&S::loop, &L::reference_width>("reference-width", "Reference Width",
          "Frame width, px, that alpha is meant at; velocities are scaled to it (0 = native pixels)",
          0, 65536),
      Rows::choice<&S::latency_mode>("latency-mode", "Latency Mode",
          "When a sample is felt",
          register_enum<LatencyMode>("GstHapticSinkLatencyMode",
              {{LatencyMode::automatic, "Immediate if the source is live, else synchronized", "auto"},
               {LatencyMode::synchronized, "Each sample at its time stamp", "synchronized"},
               {LatencyMode::immediate, "Each sample as soon as it comes", "immediate"}})),
      Rows::number<&S::choice, &C::rate>("rate", "Rate",
          "Force updates per second, Hz", 500, 4000, kReady),
      Rows::number<&S::loop, &L::slew_rate>("slew-rate", "Slew Rate",
          "How fast the force may change, N/s", F::kLeastSlewRate, F::kMostSlewRate),
      Rows::number<&S::loop, &L::law_settings, &W::gain_window>("gain-window", "Gain Window",
          "With force-law=linear: the fastest motion of so many seconds gives max-force", 0.1, 600),
      Rows::number<&S::loop, &L::law_settings, &W::max_torque>("max-torque", "Maximum Torque",
          "The torque that no rotation exceeds, N·m; 0: no torque", 0, F::kMostTorque),
      Rows::number<&S::loop, &L::law_settings, &W::spin_half>("spin-half", "Spin Half",
          "The rotation that gives half of max-torque, rad/s", 0.01, 100),
      Rows::number<&S::loop, &L::law_settings, &W::max_push>("max-push", "Maximum Push",
          "The force towards the user that no approach exceeds, N; 0.5 1/s give half of it, 0: none",
          0, kHighestForce),
      Rows::number<&S::loop, &L::damping>("damping", "Damping",
          "Against the hand's speed above 0.1 m/s, N·s/m; never more than the force itself", 0,
          F::kMostDamping),
      Rows::number<&S::loop, &L::continuous_force>("continuous-force", "Continuous Force",
          "The rms of the force over any 60 s, N; a stronger force fades to what keeps it; 0: any",
          0, kHighestForce),
      Rows::number<&S::loop, &L::smooth_hz>("smooth-hz", "Smooth Hz",
          "Cut-off of an additional low-pass on the motion, Hz; 12 for noisy frames, 0: none", 0, 500),
      Rows::number<&S::loop, &L::wash_out>("wash-out", "Wash-out",
          "How fast the frame moves under a hand that points away from its centre, 1/s, by at most 5 % of "
          "the hand's movement; 0: the workspace is the frame", 0, 10),
      Rows::choice<&S::loop, &L::hold_law>("hold-law", "Hold Law",
          "What a held thing does to the hand",
          register_enum<HoldLaw>("GstHapticSinkHoldLaw",
              {{HoldLaw::motion, "Its motion is felt", "motion"},
               {HoldLaw::carry, "A spring carries the hand along; where it cannot, the motion is felt", "carry"},
               {HoldLaw::both, "The sum of both", "both"}})),
      Rows::choice<&S::loop, &L::touch>("touch", "Touch",
          "What is felt: the motion, the surface of a relief, or both",
          register_enum<TouchMode>("GstHapticSinkTouch",
              {{TouchMode::off, "The motion is felt", "off"},
               {TouchMode::surface, "The surface of the relief is felt", "surface"},
               {TouchMode::surface_and_motion, "Both are felt", "surface+motion"}})),
      Rows::number<&S::loop, &L::region_z>("region-z", "Region Z",
          "With touch, the size of the felt region: that of a hand at this z, in half workspaces", -1, 1),
      Rows::choice<&S::rate_law>("rate-law", "Rate Law",
          "What a film played slower or faster feels like",
          register_enum<RateLaw>("GstHapticSinkRateLaw",
              {{RateLaw::as_seen, "Motion as it is seen: slow motion feels softer", "as-seen"},
               {RateLaw::as_filmed, "Motion as it was filmed, however fast it is played", "as-filmed"}})),
      Rows::text<&S::choice, &C::geometry>("geometry", "Geometry",
          "Name or file of the device's geometry"),
      Rows::text<&S::log_location>("log-location", "Log Location",
          "CSV file that gets one row per force update"),
      Rows::text<&S::fault_location>("fault-location", "Fault Location",
          "Folder that gets the last two seconds before a fault as a CSV log; auto: "
          "~/.local/state/feeling-wind; none: nothing is written"),
      Rows::text<&S::choice, &C::sim_hand>("sim-hand", "Simulated Hand",
          "What holds the simulated grip: hold:X,Y,Z, circle:RADIUS,PERIOD, file:PATH or free; X, Y, Z and "
          "RADIUS in -1..1 of the half workspace, PERIOD in s"),
      Rows::choice<&S::choice, &C::dead_man>("dead-man", "Dead-Man Switch",
          "What a hand must do to feel a force",
          register_enum<DeadMan>("GstHapticSinkDeadMan",
              {{DeadMan::none, "Force whenever there is motion", "none"},
               {DeadMan::button, "Force only while a button of the device is pressed", "button"}}), kReady),
  };
  // clang-format on
  static_assert(std::size(table) == kSinkProperties);
  return table;
}

std::string fault_folder(const std::string &fault_location) {
  if (fault_location == "none")
    return {};
  if (fault_location != "auto")
    return fault_location;
  const GCharPtr path(g_build_filename(g_get_user_state_dir(), "feeling-wind", nullptr));
  return path.get();
}

GType session_state_type() {
  static std::vector<GEnumValue> values;
  values.reserve(std::size(kSessionStates) + 1); // and what ends the list
  for (const auto &state : kSessionStates)
    values.push_back({static_cast<gint>(state.state), state.description, state.name});
  return register_enum("GstHapticSinkSessionState", values);
}

} // namespace haptic
