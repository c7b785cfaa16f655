// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/gstreliefmaker.h"

#include "frames/frame-caps.hpp"
#include "frames/mapped-frame.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/stream-lock.hpp"
#include "messages.hpp"
#include "samples/motion-sample.hpp"

#include <algorithm>

GST_DEBUG_CATEGORY_STATIC(reliefmaker_debug);
#define GST_CAT_DEFAULT reliefmaker_debug

struct GstReliefMakerPrivate {
  haptic::ReliefMaker *state;
};

G_DEFINE_ABSTRACT_TYPE_WITH_CODE(GstReliefMaker, gst_relief_maker, GST_TYPE_BASE_TRANSFORM,
                                 G_ADD_PRIVATE(GstReliefMaker)
                                     GST_DEBUG_CATEGORY_INIT(reliefmaker_debug, "reliefmaker", 0,
                                                             "relief of a frame"))

haptic::ReliefMaker *gst_relief_maker_state(GstReliefMaker *self) {
  return static_cast<GstReliefMakerPrivate *>(gst_relief_maker_get_instance_private(self))->state;
}

void gst_relief_maker_set_state(GstReliefMaker *self, haptic::ReliefMaker *state) {
  static_cast<GstReliefMakerPrivate *>(gst_relief_maker_get_instance_private(self))->state = state;
}

namespace {

using haptic::guarded;
using haptic::kGuarded;
using haptic::ReliefField;
using haptic::ReliefMaker;

ReliefMaker &state_of(GstBaseTransform *trans) {
  return *gst_relief_maker_state(GST_RELIEF_MAKER(trans));
}

GstFlowReturn prepare_output_buffer(GstBaseTransform *trans, GstBuffer *in, GstBuffer **out) {
  ReliefMaker &state = state_of(trans);
  const GstVideoInfo &info = state.frame;
  const haptic::FieldShape shape = haptic::field_shape(
      GST_VIDEO_INFO_WIDTH(&info), GST_VIDEO_INFO_HEIGHT(&info),
      static_cast<double>(GST_VIDEO_INFO_PAR_N(&info)) / GST_VIDEO_INFO_PAR_D(&info),
      static_cast<int>(state.follow_settings()));
  ReliefField &relief = state.relief;
  relief.columns = static_cast<std::uint16_t>(shape.columns);
  relief.rows = static_cast<std::uint16_t>(shape.rows);
  relief.cells.resize(static_cast<std::size_t>(shape.cells()));
  *out = gst_buffer_new_allocate(nullptr, haptic::packed_size(relief), nullptr);
  haptic::copy_timing(in, *out);
  return GST_FLOW_OK;
}

GstFlowReturn transform(GstBaseTransform *trans, GstBuffer *in, GstBuffer *out) {
  ReliefMaker &state = state_of(trans);
  ReliefField &relief = state.relief;
  const haptic::TimeStep step = state.timeline.advance(trans, GST_CAT_DEFAULT, in);
  state.timeline.adopt();
  relief.interval = step.interval;
  relief.flags = step.kind == haptic::TimeStep::Kind::restarts ? haptic::kMotionDiscontinuity : 0;
  const haptic::MappedFrame frame(state.frame, in);
  if (!frame) {
    GST_ELEMENT_ERROR(trans, STREAM, FORMAT, (haptic::messages::kUnreadableFrame),
                      ("%" GST_PTR_FORMAT, static_cast<void *>(in)));
    return GST_FLOW_ERROR;
  }
  state.make(frame.frame());
  GstMapInfo map;
  if (!gst_buffer_map(out, &map, GST_MAP_WRITE))
    return GST_FLOW_ERROR;
  haptic::pack_relief_field(relief, {map.data, map.size});
  gst_buffer_unmap(out, &map);
  if (std::ranges::none_of(relief.cells, [](const auto &cell) { return cell.validity > 0; }))
    GST_BUFFER_FLAG_SET(out, GST_BUFFER_FLAG_GAP);
  return GST_FLOW_OK;
}

gboolean set_caps(GstBaseTransform *trans, GstCaps *in) {
  ReliefMaker &state = state_of(trans);
  state.timeline.forget();
  if (!gst_video_info_from_caps(&state.frame, in))
    return FALSE;
  const GstVideoInfo &info = state.frame;
  ReliefField &relief = state.relief;
  relief.frame_width = static_cast<std::uint32_t>(GST_VIDEO_INFO_WIDTH(&info));
  relief.frame_height = static_cast<std::uint32_t>(GST_VIDEO_INFO_HEIGHT(&info));
  relief.pixel_aspect_n = static_cast<std::uint32_t>(GST_VIDEO_INFO_PAR_N(&info));
  relief.pixel_aspect_d = static_cast<std::uint32_t>(GST_VIDEO_INFO_PAR_D(&info));
  return TRUE;
}

// The stream may have begun: the pad takes events and buffers before this call.
gboolean start(GstBaseTransform *trans) {
  return state_of(trans).start() ? TRUE : FALSE;
}

gboolean stop(GstBaseTransform *trans) {
  const haptic::StreamLock stream(trans);
  ReliefMaker &state = state_of(trans);
  state.timeline.forget();
  state.timeline.report_faults_again();
  state.stop();
  return TRUE;
}

void on_sink_event(ReliefMaker &state, const GstEvent *event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT || GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP)
    state.timeline.forget();
}

} // namespace

static void gst_relief_maker_finalize(GObject *object) {
  delete gst_relief_maker_state(GST_RELIEF_MAKER(object));
  G_OBJECT_CLASS(gst_relief_maker_parent_class)->finalize(object);
}

static void gst_relief_maker_class_init(GstReliefMakerClass *klass) {
  G_OBJECT_CLASS(klass)->finalize = gst_relief_maker_finalize;
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);
  transform_class->transform_caps = kGuarded<haptic::transform_frame_caps>;
  transform_class->set_caps = kGuarded<set_caps>;
  transform_class->prepare_output_buffer = kGuarded<prepare_output_buffer>;
  transform_class->transform = kGuarded<transform>;
  transform_class->sink_event = [](GstBaseTransform *trans, GstEvent *event) {
    guarded(trans, [&] { on_sink_event(state_of(trans), event); });
    return GST_BASE_TRANSFORM_CLASS(gst_relief_maker_parent_class)->sink_event(trans, event);
  };
  transform_class->propose_allocation = kGuarded<haptic::accept_any_strides>;
  transform_class->start = kGuarded<start>;
  transform_class->stop = kGuarded<stop>;
}

static void gst_relief_maker_init(GstReliefMaker *self) {
  haptic::keep_every_frame(GST_BASE_TRANSFORM(self));
}
