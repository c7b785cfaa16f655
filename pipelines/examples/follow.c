/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Prints the motion under a pointer, frame by frame.
 *
 *   cc follow.c $(pkg-config --cflags --libs gstreamer-video-1.0) -o follow
 *   ./follow VIDEO [X Y]    (X and Y: 0..1 from the top left; 0.5 0.5) */
#include <gst/video/gstvideometa.h>

/* Runs in the streaming thread, once per frame that left roitracker. */
static GstPadProbeReturn print_motion(GstPad *pad, GstPadProbeInfo *info, gpointer unused) {
  GstBuffer *frame = GST_PAD_PROBE_INFO_BUFFER(info);
  GstVideoRegionOfInterestMeta *region = gst_buffer_get_video_region_of_interest_meta_id(frame, 0);
  const GstStructure *motion =
      region ? gst_video_region_of_interest_meta_get_param(region, "haptic-motion") : NULL;
  gdouble vx = 0;
  gdouble vy = 0;
  gdouble confidence = 0;
  if (motion &&
      gst_structure_get(motion, "vx", G_TYPE_DOUBLE, &vx, "vy", G_TYPE_DOUBLE, &vy, "confidence",
                        G_TYPE_DOUBLE, &confidence, NULL) &&
      confidence > 0)
    g_print("%" GST_TIME_FORMAT "  %7.1f %7.1f px/s  %s\n", GST_TIME_ARGS(GST_BUFFER_PTS(frame)),
            vx, vy, gst_structure_get_string(motion, "model"));
  (void)pad;
  (void)unused;
  return GST_PAD_PROBE_OK;
}

static GstElement *make_pipeline(const char *video, double x, double y, GError **error) {
  GstElement *pipeline = gst_parse_launch("filesrc name=file ! decodebin ! videoconvert "
                                          "! roitracker name=tracker ! fakesink",
                                          error);
  if (*error)
    return pipeline;
  GstElement *file = gst_bin_get_by_name(GST_BIN(pipeline), "file");
  GstElement *tracker = gst_bin_get_by_name(GST_BIN(pipeline), "tracker");
  GstPad *frames = gst_element_get_static_pad(tracker, "src");
  g_object_set(file, "location", video, NULL);
  g_object_set(tracker, "pointer-x", x, "pointer-y", y, NULL);
  gst_pad_add_probe(frames, GST_PAD_PROBE_TYPE_BUFFER, print_motion, NULL, NULL);
  gst_object_unref(frames);
  gst_object_unref(tracker);
  gst_object_unref(file);
  return pipeline;
}

/* Waits for the end of the video. */
static void play(GstElement *pipeline, GError **error) {
  GstBus *bus = gst_element_get_bus(pipeline);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstMessage *last =
      gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE, GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
  if (GST_MESSAGE_TYPE(last) == GST_MESSAGE_ERROR)
    gst_message_parse_error(last, error, NULL);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_message_unref(last);
  gst_object_unref(bus);
}

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  if (argc != 2 && argc != 4) {
    g_printerr("usage: follow VIDEO [X Y]\n");
    return 1;
  }
  GError *error = NULL;
  GstElement *pipeline = make_pipeline(argv[1], argc == 4 ? g_ascii_strtod(argv[2], NULL) : 0.5,
                                       argc == 4 ? g_ascii_strtod(argv[3], NULL) : 0.5, &error);
  if (!error)
    play(pipeline, &error);
  if (error)
    g_printerr("%s\n", error->message);
  const int status = error ? 1 : 0;
  g_clear_error(&error);
  if (pipeline)
    gst_object_unref(pipeline);
  return status;
}
