// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/sink-properties.hpp"

#include "glue/property-table.hpp"

#include <iterator>
#include <type_traits>
#include <variant>
#include <vector>

namespace haptic {
namespace {

// ---- enumerations -------------------------------------------------------------------------------

GType force_law_type() {
  static const GType type = [] {
    static std::vector<GEnumValue> values;
    for (const auto &law : force_laws())
      values.push_back({static_cast<gint>(values.size()), law.description, law.name});
    values.push_back({0, nullptr, nullptr});
    return g_enum_register_static("GstHapticSinkForceLaw", values.data());
  }();
  return type;
}

GType latency_mode_type() {
  static const GEnumValue values[] = {
      {static_cast<gint>(LatencyMode::automatic),
       "Immediate if the source is live, else synchronized", "auto"},
      {static_cast<gint>(LatencyMode::synchronized), "Each sample at its time stamp",
       "synchronized"},
      {static_cast<gint>(LatencyMode::immediate), "Each sample as soon as it comes", "immediate"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstHapticSinkLatencyMode", values);
  return type;
}

GType rate_law_type() {
  static const GEnumValue values[] = {{static_cast<gint>(RateLaw::as_seen),
                                       "Motion as it is seen: slow motion feels softer", "as-seen"},
                                      {static_cast<gint>(RateLaw::as_filmed),
                                       "Motion as it was filmed, however fast it is played",
                                       "as-filmed"},
                                      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstHapticSinkRateLaw", values);
  return type;
}

GType dead_man_type() {
  static const GEnumValue values[] = {
      {static_cast<gint>(DeadMan::none), "Force whenever there is motion", "none"},
      {static_cast<gint>(DeadMan::button), "Force only while a button of the device is pressed",
       "button"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstHapticSinkDeadMan", values);
  return type;
}

GType touch_type() {
  static const GEnumValue values[] = {
      {static_cast<gint>(TouchMode::off), "The motion is felt", "off"},
      {static_cast<gint>(TouchMode::surface), "The surface of the relief is felt", "surface"},
      {static_cast<gint>(TouchMode::surface_and_motion), "Both are felt", "surface+motion"},
      {0, nullptr, nullptr}};
  static const GType type = g_enum_register_static("GstHapticSinkTouch", values);
  return type;
}

// ---- the table ----------------------------------------------------------------------------------

using Text = std::string &(*)(SinkSettings &);
using Number = double &(*)(SinkSettings &);
using Count = unsigned &(*)(SinkSettings &);

struct EnumMember {
  GType (*type)();
  gint (*get)(SinkSettings &);
  void (*set)(SinkSettings &, gint);
};

template <auto member>
constexpr EnumMember enumeration(GType (*type)()) {
  return {type, [](SinkSettings &settings) { return static_cast<gint>(member(settings)); },
          [](SinkSettings &settings, gint value) {
            auto &place = member(settings);
            place = static_cast<std::remove_reference_t<decltype(place)>>(value);
          }};
}

constexpr auto kParameter = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS);
constexpr auto kReady = static_cast<GParamFlags>(kParameter | GST_PARAM_MUTABLE_READY);
constexpr auto kPlaying = static_cast<GParamFlags>(kParameter | GST_PARAM_MUTABLE_PLAYING);

constexpr auto kControllable = static_cast<GParamFlags>(kPlaying | GST_PARAM_CONTROLLABLE);

struct Range {
  double lowest = 0;
  double highest = 0;
};

struct SinkProperty {
  const char *name;
  const char *nick;
  GParamFlags flags;
  std::variant<Text, Number, Count, EnumMember> member; // its default is that of SinkSettings
  Range range;                                          // of numbers and counts
  const char *blurb;
};

// clang-format off
#define AT(MEMBER) ([](SinkSettings &s) -> auto & { return s.MEMBER; })

const SinkProperty kProperties[] = {
    {"device", "Device", kReady, Text(AT(choice.device)), {},
     "auto, sim, usb, usb:ID (its rotary switch), evdev, evdev:PATH (a joystick or wheel with "
     "force feedback) or none; auto takes the first SPIDAR-G found, else the simulated one"},
    {"force-law", "Force Law", kPlaying, enumeration<AT(loop.law)>(force_law_type), {},
     "How motion becomes force"},
    {"max-force", "Maximum Force", kControllable, Number(AT(loop.law_settings.max_force)), {0, kHighestForce},
     "The force that no motion exceeds, N"},
    {"alpha", "Alpha", kControllable, Number(AT(loop.law_settings.alpha)), {0, 10},
     "Steepness of the force law, s/px, at a frame reference-width wide: 1/alpha px/s give half of "
     "max-force"},
    {"reference-width", "Reference Width", kPlaying, Count(AT(loop.reference_width)), {0, 65536},
     "Frame width, px, that alpha is meant at; velocities are scaled to it (0 = native pixels)"},
    {"latency-mode", "Latency Mode", kPlaying, enumeration<AT(latency_mode)>(latency_mode_type), {},
     "When a sample is felt"},
    {"rate", "Rate", kReady, Count(AT(choice.rate)), {500, 4000},
     "Force updates per second, Hz"},
    {"slew-rate", "Slew Rate", kPlaying, Number(AT(loop.slew_rate)), {0.1, 1000},
     "How fast the force may change, N/s"},
    {"gain-window", "Gain Window", kPlaying, Number(AT(loop.law_settings.gain_window)), {0.1, 600},
     "With force-law=linear: the fastest motion of so many seconds gives max-force"},
    {"max-torque", "Maximum Torque", kPlaying, Number(AT(loop.law_settings.max_torque)), {0, 0.1},
     "The torque that no rotation exceeds, N·m; 0: no torque"},
    {"spin-half", "Spin Half", kPlaying, Number(AT(loop.law_settings.spin_half)), {0.01, 100},
     "The rotation that gives half of max-torque, rad/s"},
    {"max-push", "Maximum Push", kPlaying, Number(AT(loop.law_settings.max_push)), {0, kHighestForce},
     "The force towards the user that no approach exceeds, N; 0.5 1/s give half of it, 0: none"},
    {"damping", "Damping", kPlaying, Number(AT(loop.damping)), {0, 10},
     "Against the hand's speed above 0.1 m/s, N·s/m; never more than the force itself"},
    {"continuous-force", "Continuous Force", kPlaying, Number(AT(loop.continuous_force)), {0, kHighestForce},
     "The rms of the force over any 60 s, N; a stronger force fades to what keeps it; 0: any"},
    {"smooth-hz", "Smooth Hz", kPlaying, Number(AT(loop.smooth_hz)), {0, 500},
     "Cut-off of an additional low-pass on the motion, Hz; 12 for noisy frames, 0: none"},
    {"wash-out", "Wash-out", kPlaying, Number(AT(loop.wash_out)), {0, 10},
     "How fast the frame moves under a hand that points away from its centre, 1/s, by at most 5 % of "
     "the hand's movement; 0: the workspace is the frame"},
    {"touch", "Touch", kPlaying, enumeration<AT(loop.touch)>(touch_type), {},
     "What is felt: the motion, the surface of a relief, or both"},
    {"region-z", "Region Z", kPlaying, Number(AT(loop.region_z)), {-1, 1},
     "With touch, the size of the felt region: that of a hand at this z, in half workspaces"},
    {"rate-law", "Rate Law", kPlaying, enumeration<AT(rate_law)>(rate_law_type), {},
     "What a film played slower or faster feels like"},
    {"geometry", "Geometry", kReady, Text(AT(choice.geometry)), {},
     "Name or file of the device's geometry"},
    {"log-location", "Log Location", kReady, Text(AT(log_location)), {},
     "CSV file that gets one row per force update"},
    {"sim-hand", "Simulated Hand", kReady, Text(AT(choice.sim_hand)), {},
     "What holds the simulated grip: hold:X,Y,Z, circle:RADIUS,PERIOD, file:PATH or free; X, Y, Z "
     "and RADIUS in -1..1 of the half workspace, PERIOD in s"},
    {"dead-man", "Dead-Man Switch", kReady, enumeration<AT(choice.dead_man)>(dead_man_type), {},
     "What a hand must do to feel a force"},
};
#undef AT
// clang-format on
static_assert(std::size(kProperties) == kSinkProperties);

template <typename... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <typename... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

GParamSpec *make_spec(const SinkProperty &p) {
  SinkSettings defaults;
  const double lowest = p.range.lowest;
  const double highest = p.range.highest;
  const auto text_spec = [&](Text member) {
    const std::string &text = member(defaults);
    return g_param_spec_string(p.name, p.nick, p.blurb, text.empty() ? nullptr : text.c_str(),
                               p.flags);
  };
  const auto number_spec = [&](Number member) {
    return g_param_spec_double(p.name, p.nick, p.blurb, lowest, highest, member(defaults), p.flags);
  };
  const auto count_spec = [&](Count member) {
    return g_param_spec_uint(p.name, p.nick, p.blurb, static_cast<guint>(lowest),
                             static_cast<guint>(highest), member(defaults), p.flags);
  };
  const auto enum_spec = [&](EnumMember member) {
    return g_param_spec_enum(p.name, p.nick, p.blurb, member.type(), member.get(defaults), p.flags);
  };
  return std::visit(Overloaded{text_spec, number_spec, count_spec, enum_spec}, p.member);
}

} // namespace

GType session_state_type() {
  static const GType type = [] {
    static std::vector<GEnumValue> values;
    values.reserve(std::size(kSessionStates) + 1);
    for (const auto &state : kSessionStates)
      values.push_back({static_cast<gint>(state.state), state.description, state.name});
    values.push_back({0, nullptr, nullptr});
    return g_enum_register_static("GstHapticSinkSessionState", values.data());
  }();
  return type;
}

void install_sink_properties(GObjectClass *klass) {
  guint id = 0;
  for (const SinkProperty &property : kProperties)
    g_object_class_install_property(klass, ++id, make_spec(property));
  for (const GType type : {force_law_type(), latency_mode_type(), rate_law_type(), dead_man_type(),
                           touch_type(), session_state_type()})
    gst_type_mark_as_plugin_api(type, static_cast<GstPluginAPIFlags>(0));
}

void set_sink_property(guint id, const GValue *value, SinkSettings &settings) {
  const auto set_text = [&](Text member) {
    const gchar *text = g_value_get_string(value);
    member(settings) = text ? text : "";
  };
  std::visit(Overloaded{set_text, [&](Number member) { read_value(value, member(settings)); },
                        [&](Count member) { member(settings) = g_value_get_uint(value); },
                        [&](EnumMember member) { member.set(settings, g_value_get_enum(value)); }},
             kProperties[id - 1].member);
}

void get_sink_property(guint id, GValue *value, SinkSettings &settings) {
  const auto get_text = [&](Text member) {
    const std::string &text = member(settings);
    g_value_set_string(value, text.empty() ? nullptr : text.c_str());
  };
  std::visit(Overloaded{get_text,
                        [&](Number member) { g_value_set_double(value, member(settings)); },
                        [&](Count member) { g_value_set_uint(value, member(settings)); },
                        [&](EnumMember member) { g_value_set_enum(value, member.get(settings)); }},
             kProperties[id - 1].member);
}

} // namespace haptic
