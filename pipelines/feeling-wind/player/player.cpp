// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/player.hpp"

#include "glue/display-orientation.hpp"
#include "gsthapticmotionmeta.h"
#include "player/failure.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace program {
namespace {

using haptic::BusPtr;
using haptic::CapsPtr;
using haptic::ElementPtr;
using haptic::ErrorPtr;
using haptic::PadPtr;
using haptic::SamplePtr;
using Clock = std::chrono::steady_clock;

// Each branch of a tee needs a queue; longer ones would delay the hand. A late window must not make
// the decoder skip frames (qos).
constexpr const char *kPipeline =
    "videoconvert name=frames ! deinterlace name=deinterlace ! videoflip name=flip ! "
    "roitracker name=tracker ! tee name=t "
    "t. ! queue max-size-buffers=1 ! videoconvert ! hapticoverlay name=overlay ! "
    "gtksink name=picture qos=false "
    "t. ! queue max-size-buffers=1 ! velocityavg name=motion post-messages=true ! "
    "hapticsink name=force";
// The colours of the film become a surface, which the window shows as light.
constexpr const char *kTouch =
    " t. ! queue max-size-buffers=1 ! videoconvert ! reliefmap name=relief ! tee name=surface "
    "surface. ! queue ! overlay.relief surface. ! queue ! force.relief";
constexpr double kDent = 4; // px per mm under the hand
constexpr const char *kSoundBranch = "queue ! audioconvert ! audioresample ! volume name=volume ! "
                                     "autoaudiosink name=loudspeaker";

constexpr double kLongestGap = 0.5; // s; a longer pause takes no more room on the strip

const char *message_name(GstMessage *message) {
  const GstStructure *structure = gst_message_get_structure(message);
  return structure ? gst_structure_get_name(structure) : "";
}

std::string text_of(const GstStructure *structure, const char *field) {
  const char *text = gst_structure_get_string(structure, field);
  return text ? text : "";
}

// gst_util_set_object_arg() would ignore a value that it cannot convert, and GObject one out of
// range.
bool set_property(GObject *object, const std::string &name, const std::string &value) {
  GParamSpec *property = g_object_class_find_property(G_OBJECT_GET_CLASS(object), name.c_str());
  if (!property || !(property->flags & G_PARAM_WRITABLE))
    return false;
  GValue converted = G_VALUE_INIT;
  g_value_init(&converted, property->value_type);
  const bool valid = gst_value_deserialize_with_pspec(&converted, value.c_str(), property) &&
                     !g_param_value_validate(property, &converted); // true if it was out of range
  if (valid)
    g_object_set_property(object, name.c_str(), &converted);
  g_value_unset(&converted);
  return valid;
}

haptic::HoldState hold_of(const GstStructure *fields) {
  return haptic::hold_state_named(text_of(fields, "held")).value_or(haptic::HoldState::none);
}

} // namespace

std::string set_option(GstElement *sink, const std::string &option) {
  const std::size_t equal = option.find('=');
  if (equal != std::string::npos &&
      set_property(G_OBJECT(sink), option.substr(0, equal), option.substr(equal + 1)))
    return "";
  return "“" + option +
         "” is not a property of hapticsink with a value that it accepts. See "
         "docs/elements/hapticsink.md.";
}

// ---- opening and closing ------------------------------------------------------------------------

void Player::open(const Source &source) {
  close();
  source_ = source;
  start_at_ = 0;
  with_sound_ = true;
  seekable_ = true;
  had_frame_ = false;
  start();
}

void Player::open_again() {
  if (!is_open())
    return;
  const gint64 position = source_.is_live() ? 0 : playback_->position();
  const bool paused = playback_->paused();
  close();
  start_at_ = std::max<gint64>(position, 0);
  start(paused);
}

void Player::begin_again() {
  close();
  start_at_ = 0;
  start();
}

bool Player::can_seek() const {
  return playback_ && seekable_ && playback_->can_seek();
}

void Player::close() {
  if (!pipeline_)
    return;
  if (watch_)
    g_source_remove(watch_);
  watch_ = 0;
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  playback_.reset();
  pipeline_.reset();
}

void Player::fail(const std::string &sentence) {
  close();
  client_.on_failure(sentence);
}

void Player::start(bool paused) {
  has_frame_ = false;
  type_seen_ = false;
  latched_ = false;
  missing_.clear();
  if (const std::string problem = problem_of(source_); !problem.empty())
    return fail(problem);
  if (!build(with_sound_))
    return;
  apply_setup();
  // The device of a person begins without force, until that person asks for it.
  if (setup.is_real() || released_)
    emit("release");
  GtkWidget *video = nullptr;
  g_object_get(element("picture").get(), "widget", &video, nullptr);
  client_.on_widget(video);
  g_signal_connect_after(video, "draw", G_CALLBACK(+[](GtkWidget *, cairo_t *, gpointer self) {
                           static_cast<Player *>(self)->note_frame();
                           return gboolean{FALSE};
                         }),
                         this);
  g_object_unref(video);
  const BusPtr bus(gst_element_get_bus(pipeline_.get()));
  watch_ = gst_bus_add_watch(
      bus.get(),
      [](GstBus *, GstMessage *message, gpointer self) noexcept -> gboolean {
        static_cast<Player *>(self)->handle_message(message);
        return G_SOURCE_CONTINUE;
      },
      this);
  playback_.emplace(pipeline_.get());
  playback_->start(paused); // a failure arrives as a message on the bus
}

bool Player::build(bool with_sound) {
  GError *error = nullptr;
  const std::string line = kPipeline + std::string(setup.touch.empty() ? "" : kTouch);
  pipeline_.reset(
      gst_parse_launch_full(line.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error));
  const ErrorPtr owned(error);
  if (!pipeline_) {
    client_.on_failure(
        std::string(error->message) +
        ". Install the packages feeling-wind and gstreamer1.0-gtk3, or run pipelines/view.sh.");
    return false;
  }
  // That of a sound device stops with the sound, which may be shorter than the film.
  GstClock *clock = gst_system_clock_obtain();
  gst_pipeline_use_clock(GST_PIPELINE(pipeline_.get()), clock);
  gst_object_unref(clock);
  if (!configure_sink())
    return false;
  add_array();
  GstElement *decoder = add_source(GST_BIN(pipeline_.get()), source_, with_sound);
  if (!decoder) {
    fail("An element that reads films is missing. Install the package gstreamer1.0-plugins-good.");
    return false;
  }
  connect_source(decoder);
  return true;
}

// A log of its own for each pipeline: hapticsink begins it anew.
std::string Player::numbered(const std::string &option) const {
  if (pipelines_ == 1 || !option.starts_with("log-location=") ||
      option.starts_with("log-location=/dev/"))
    return option;
  const std::size_t ending = option.rfind('.');
  const std::size_t folders = option.rfind('/');
  const bool has_ending =
      ending != std::string::npos && (folders == std::string::npos || ending > folders + 1);
  std::string other = option;
  return other.insert(has_ending ? ending : other.size(), "-" + std::to_string(pipelines_));
}

bool Player::configure_sink() {
  ++pipelines_;
  const ElementPtr sink = element("force");
  g_object_set(sink.get(), "device", setup.device.c_str(), nullptr);
  if (const ElementPtr relief = element("relief")) {
    g_object_set(relief.get(), "table", setup.touch.c_str(), nullptr);
    g_object_set(element("overlay").get(), "deform", kDent, nullptr);
    gst_util_set_object_arg(G_OBJECT(sink.get()), "touch", "surface+motion");
  }
  for (const std::string &option : setup.options)
    if (const std::string problem = set_option(sink.get(), numbered(option)); !problem.empty()) {
      fail(problem);
      return false;
    }
  gst_util_set_object_arg(G_OBJECT(element("tracker").get()), "pointer-source",
                          setup.has_hand() ? "auto" : "navigation");
  return true;
}

// Without the array the film goes on.
void Player::add_array() {
  array_.remove();
  if (setup.array.layout.empty())
    return;
  const std::string problem = array_.add(GST_BIN(pipeline_.get()), element("t").get(), setup.array);
  if (problem.empty()) {
    g_object_set(element("array").get(), "level", 0.0, nullptr); // until the force is on
    return;
  }
  setup.array.layout.clear();
  client_.on_note(problem + " The film goes on without the array.");
}

// An authored copy has its rotation where GStreamer does not read it.
std::string Player::direction() const {
  return setup.direction == "auto" && source_.kind == SourceKind::file
             ? haptic::direction_of(haptic::orientation_in(source_.name))
             : setup.direction;
}

void Player::apply_setup() {
  if (!pipeline_)
    return;
  const auto set = [this](const char *name, const char *property, const std::string &value) {
    gst_util_set_object_arg(G_OBJECT(element(name).get()), property, value.c_str());
  };
  set("flip", "video-direction", direction());
  set("deinterlace", "mode", setup.deinterlace);
  set("overlay", "style", setup.drawing ? "full" : "none");
  set("force", "force-law", setup.law);
  g_object_set(element("force").get(), "alpha", setup.alpha, nullptr);
  if (const ElementPtr array = element("array"))
    g_object_set(array.get(), "alpha", setup.alpha, nullptr);
  g_object_set(element("tracker").get(), "roi-size", setup.region, nullptr);
  // At another speed sound would have another pitch.
  const bool normal = !playback_ || playback_->rate() == 1;
  if (const ElementPtr volume = element("volume"))
    g_object_set(volume.get(), "volume", setup.volume, "mute",
                 static_cast<gboolean>(setup.muted || !normal), nullptr);
}

// ---- pads of the source -------------------------------------------------------------------------

void Player::connect_source(GstElement *source) {
  g_signal_connect(source, "pad-added",
                   G_CALLBACK(+[](GstElement *, GstPad *pad, gpointer self) noexcept {
                     static_cast<Player *>(self)->on_pad(pad);
                   }),
                   this);
  g_signal_connect(source, "no-more-pads", G_CALLBACK(+[](GstElement *, gpointer self) noexcept {
                     static_cast<Player *>(self)->on_no_more_pads();
                   }),
                   this);
  g_signal_connect(source, "autoplug-continue",
                   G_CALLBACK(+[](GstElement *, GstPad *, GstCaps *caps, gpointer self) noexcept {
                     static_cast<Player *>(self)->on_type(caps);
                     return gboolean{TRUE};
                   }),
                   this);
}

void Player::post(const char *what) {
  gst_element_post_message(
      pipeline_.get(),
      gst_message_new_application(GST_OBJECT(pipeline_.get()), gst_structure_new_empty(what)));
}

// The first type is that of the file.
void Player::on_type(const GstCaps *caps) {
  const bool first = !type_seen_;
  type_seen_ = true;
  const char *name = gst_structure_get_name(gst_caps_get_structure(caps, 0));
  if (first && !source_.is_live() && g_str_has_prefix(name, "image/"))
    post(g_str_equal(name, "image/gif") ? "animation" : "still-picture");
}

// A second film or sound is read and not used: left alone it would stop the others.
void Player::on_pad(GstPad *pad) {
  CapsPtr caps(gst_pad_get_current_caps(pad));
  if (!caps)
    caps.reset(gst_pad_query_caps(pad, nullptr));
  const char *name = gst_structure_get_name(gst_caps_get_structure(caps.get(), 0));
  const ElementPtr frames = element("frames");
  const PadPtr sink(gst_element_get_static_pad(frames.get(), "sink"));
  if (g_str_has_prefix(name, "video/") && !gst_pad_is_linked(sink.get())) {
    gst_pad_link(pad, sink.get());
  } else if (g_str_has_prefix(name, "audio/") && !element("sound")) {
    add_sound(pad);
  } else {
    GstElement *unused = gst_element_factory_make("fakesink", nullptr);
    g_object_set(unused, "async", FALSE, nullptr);
    gst_bin_add(GST_BIN(pipeline_.get()), unused);
    const PadPtr end(gst_element_get_static_pad(unused, "sink"));
    gst_pad_link(pad, end.get());
    gst_element_sync_state_with_parent(unused);
  }
}

void Player::add_sound(GstPad *pad) {
  GstElement *sound = gst_parse_bin_from_description(kSoundBranch, TRUE, nullptr);
  if (!sound)
    return;
  gst_object_set_name(GST_OBJECT(sound), "sound");
  gst_bin_add(GST_BIN(pipeline_.get()), sound);
  const ElementPtr volume(gst_bin_get_by_name(GST_BIN(sound), "volume"));
  g_object_set(volume.get(), "volume", setup.volume, "mute", static_cast<gboolean>(setup.muted),
               nullptr);
  const PadPtr sink(gst_element_get_static_pad(sound, "sink"));
  gst_pad_link(pad, sink.get());
  gst_element_sync_state_with_parent(sound);
}

void Player::on_no_more_pads() {
  const ElementPtr frames = element("frames");
  const PadPtr sink(gst_element_get_static_pad(frames.get(), "sink"));
  if (!gst_pad_is_linked(sink.get()))
    post("no-frames");
}

// ---- messages -----------------------------------------------------------------------------------

bool Player::is_inside(GstMessage *message, const char *name) const {
  const ElementPtr outer = element(name);
  return outer && (GST_MESSAGE_SRC(message) == GST_OBJECT(outer.get()) ||
                   gst_object_has_as_ancestor(GST_MESSAGE_SRC(message), GST_OBJECT(outer.get())));
}

void Player::handle_message(GstMessage *message) {
  switch (GST_MESSAGE_TYPE(message)) {
  case GST_MESSAGE_ERROR:
    handle_error(message);
    break;
  case GST_MESSAGE_WARNING:
    handle_warning(message);
    break;
  case GST_MESSAGE_EOS:
    if (!had_frame_ && !last_frame()) // a hidden window draws none
      return fail("“" + source_.title + "” holds no frames. Open another film.");
    client_.on_end();
    if (!can_seek() || !playback_->restart())
      begin_again();
    break;
  case GST_MESSAGE_ASYNC_DONE:
    playback_->end_seek();
    if (start_at_ > 0 && playback_->seek_to(start_at_))
      start_at_ = 0;
    break;
  case GST_MESSAGE_BUFFERING: {
    int percent = 100;
    gst_message_parse_buffering(message, &percent);
    playback_->set_held(percent < 100);
    client_.on_buffering(percent);
    break;
  }
  case GST_MESSAGE_APPLICATION:
    if (gst_message_has_name(message, "still-picture"))
      return fail("“" + source_.title + "” is a still picture: nothing moves in it. Open a film.");
    if (gst_message_has_name(message, "animation"))
      return fail(
          "“" + source_.title +
          "” is an animation, of which GStreamer reads one picture only. Make a film of it: "
          "ffmpeg -i animation.gif film.mp4");
    if (gst_message_has_name(message, "no-frames"))
      return fail(!missing_.empty() ? missing_
                                    : "“" + source_.title + "” holds sound only. Open a film.");
    break;
  case GST_MESSAGE_ELEMENT:
    handle_element_message(message);
    break;
  default:
    break;
  }
}

void Player::handle_element_message(GstMessage *message) {
  const GstStructure *fields = gst_message_get_structure(message);
  if (const std::string missing = missing_plugin(message); !missing.empty())
    missing_ = missing;
  else if (std::strcmp(message_name(message), "haptic-motion") == 0)
    add_reading(fields);
  else if (std::strcmp(message_name(message), "haptic-session") == 0)
    hear_session(fields);
  else if (std::strcmp(message_name(message), "level") == 0)
    array_.read_levels(fields);
}

// Nothing is felt on the array either while the force is off.
void Player::hear_session(const GstStructure *fields) {
  const Session session{text_of(fields, "state"), text_of(fields, "reason"),
                        text_of(fields, "device")};
  if (const ElementPtr array = element("array"))
    g_object_set(array.get(), "level", session.state == "armed" ? 1.0 : 0.0, nullptr);
  client_.on_session(session);
}

// Sound, array and device are replaced, and the film goes on.
void Player::handle_error(GstMessage *message) {
  GError *error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  const ErrorPtr owned(error);
  if (is_inside(message, "sound")) {
    with_sound_ = false;
    client_.on_note(std::string("The sound cannot be played: ") + error->message +
                    " The film goes on without it.");
    return open_again();
  }
  if (is_inside(message, "array-branch")) {
    setup.array.layout.clear();
    client_.on_note(std::string(error->message) + " The film goes on without the array.");
    return open_again();
  }
  // A server may say so only when it is asked to.
  if (source_.is_remote() && seekable_ &&
      g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_SEEK)) {
    seekable_ = false;
    return begin_again();
  }
  if (is_inside(message, "force") && setup.is_real()) {
    client_.on_note(std::string(error->message) + " The film goes on with a simulated device.");
    setup.device = "sim";
    return open_again();
  }
  if (is_inside(message, "force"))
    return fail(error->message);
  fail(failure_sentence(*error, source_, had_frame_ ? "" : missing_));
}

void Player::handle_warning(GstMessage *message) {
  GError *error = nullptr;
  gst_message_parse_warning(message, &error, nullptr);
  const ErrorPtr owned(error);
  // autoaudiosink goes on without a device.
  if (is_inside(message, "array-branch") && error->domain == GST_RESOURCE_ERROR) {
    client_.on_note("No sound device for the array can be used: it is drawn only.");
  } else if (!is_inside(message, "sound")) {
    // Which codec is missing, missing_plugin() says better.
    if (error->domain != GST_STREAM_ERROR && error->domain != GST_CORE_ERROR)
      client_.on_note(error->message);
  } else if (!sound_noted_) {
    sound_noted_ = true;
    client_.on_note("No device for sound can be used. The film goes on silently.");
  }
}

void Player::note_frame() {
  if (has_frame_ || !last_frame())
    return;
  has_frame_ = had_frame_ = true;
  if (!missing_.empty())
    client_.on_note(missing_);
  client_.on_first_frame();
}

void Player::add_reading(const GstStructure *fields) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto now = Clock::now();
  const double since = std::chrono::duration<double>(now - last_reading_).count();
  last_reading_ = now;
  Reading reading{
      std::min(since, kLongestGap), kUnknown, kUnknown, kUnknown, kUnknown, hold_of(fields)};
  if (latched_ &&
      (reading.hold == haptic::HoldState::lost || reading.hold == haptic::HoldState::refused))
    latch(false);
  double confidence = 0;
  if (gst_structure_get_double(fields, "confidence", &confidence) && confidence > 0)
    gst_structure_get(fields, "vx", G_TYPE_DOUBLE, &reading.vx, "vy", G_TYPE_DOUBLE, &reading.vy,
                      nullptr);
  if (const SamplePtr sample = last_frame())
    if (const auto *motion =
            gst_buffer_get_haptic_motion_meta(gst_sample_get_buffer(sample.get()))) {
      reading.fx = static_cast<double>(motion->force_x);
      reading.fy = static_cast<double>(motion->force_y);
    }
  client_.on_reading(reading);
}

// ---- what is asked of the elements --------------------------------------------------------------

ElementPtr Player::element(const char *name) const {
  return ElementPtr(pipeline_ ? gst_bin_get_by_name(GST_BIN(pipeline_.get()), name) : nullptr);
}

SamplePtr Player::last_frame() const {
  GstSample *sample = nullptr;
  if (const ElementPtr picture = element("picture"))
    g_object_get(picture.get(), "last-sample", &sample, nullptr);
  return SamplePtr(sample);
}

void Player::emit(const char *signal) {
  if (const ElementPtr sink = element("force"))
    g_signal_emit_by_name(sink.get(), signal);
}

void Player::arm() {
  released_ = false;
  emit("arm");
}

void Player::release() {
  released_ = true;
  emit("release");
}

void Player::latch(bool holds) {
  latched_ = holds;
  if (const ElementPtr tracker = element("tracker"))
    gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", holds ? "latched" : "pressed");
}

bool Player::is_armed() const {
  gboolean armed = FALSE;
  if (const ElementPtr sink = element("force"))
    g_object_get(sink.get(), "armed", &armed, nullptr);
  return armed;
}

double Player::max_force() const {
  double newtons = 1;
  if (const ElementPtr sink = element("force"))
    g_object_get(sink.get(), "max-force", &newtons, nullptr);
  return newtons;
}

haptic::StructurePtr Player::statistics() const {
  GstStructure *statistics = nullptr;
  if (const ElementPtr sink = element("force"))
    g_object_get(sink.get(), "stats", &statistics, nullptr);
  return haptic::StructurePtr(statistics);
}

bool Player::has_sound() const {
  const ElementPtr volume = element("volume");
  if (!volume)
    return false;
  const PadPtr pad(gst_element_get_static_pad(volume.get(), "sink"));
  return !haptic::EventPtr(gst_pad_get_sticky_event(pad.get(), GST_EVENT_EOS, 0));
}

// A seek takes the last frame away, and leaves the caps.
int Player::frame_width() const {
  int width = 0;
  if (const ElementPtr tracker = element("tracker")) {
    const haptic::PadPtr pad(gst_element_get_static_pad(tracker.get(), "sink"));
    if (const haptic::CapsPtr caps{gst_pad_get_current_caps(pad.get())})
      gst_structure_get_int(gst_caps_get_structure(caps.get(), 0), "width", &width);
  }
  return width;
}

} // namespace program
