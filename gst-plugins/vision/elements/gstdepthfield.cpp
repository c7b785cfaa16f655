// SPDX-License-Identifier: LGPL-2.1-or-later
// depthfield makes a relief, a surface to touch, of frames of depth or disparity.
//
//   gst-launch-1.0 filesrc location=depth.mkv ! matroskademux ! avdec_ffv1 ! depthfield ! fakesink
//
// It reads 25 pixels of each cell.
#include "elements/gstreliefmaker.h"
#include "glue/element-class.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "messages.hpp"
#include "relief/depth-relief.hpp"

#include <span>
#include <utility>

G_DECLARE_FINAL_TYPE(GstDepthField, gst_depth_field, GST, DEPTH_FIELD, GstReliefMaker)

namespace {

using haptic::CellHeight;
using haptic::DepthKind;
using haptic::ObjectLock;

// State

struct Settings : haptic::DepthScale {
  guint columns = haptic::kReliefColumns;
};

} // namespace

struct _GstDepthField {
  GstReliefMaker parent;
};

G_DEFINE_TYPE(GstDepthField, gst_depth_field, GST_TYPE_RELIEF_MAKER)
GST_ELEMENT_REGISTER_DEFINE(depthfield, "depthfield", GST_RANK_NONE, gst_depth_field_get_type())

namespace {

class State final : public haptic::ReliefMaker {
public:
  explicit State(GstElement *element) : element_(element) {}

  void stop() override { is_told_ = false; }

  guint follow_settings() override {
    const ObjectLock lock(element_);
    current_ = settings;
    return current_.columns;
  }

  void make(const GstVideoFrame &mapped) override {
    const haptic::DepthView view = {
        static_cast<const std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&mapped, 0)),
        GST_VIDEO_INFO_WIDTH(&frame), GST_VIDEO_INFO_HEIGHT(&frame),
        GST_VIDEO_FRAME_PLANE_STRIDE(&mapped, 0), GST_VIDEO_FRAME_COMP_PSTRIDE(&mapped, 0)};
    if (depth_.make(view, current_, relief))
      is_told_ = true; // a later hole is no mistake of a property
    else if (!std::exchange(is_told_, true))
      GST_ELEMENT_WARNING(element_, STREAM, FAILED,
                          (haptic::messages::kNoDepth, current_.near, current_.far), (nullptr));
  }

  Settings settings; // object lock

private:
  GstElement *element_;
  Settings current_; // for this frame
  haptic::DepthRelief depth_;
  bool is_told_ = false;
};

State &state_of(gpointer element) {
  return *static_cast<State *>(gst_relief_maker_state(GST_RELIEF_MAKER(element)));
}

// Properties

std::span<const haptic::Property<Settings>> properties() {
  using Rows = haptic::Rows<Settings>;
  constexpr double kLargest = 1e9;
  constexpr double kLeast = 1e-9;
  constexpr double kFarthest = 1e4; // m
  static const haptic::Property<Settings> table[] = {
      haptic::relief_columns_row<Settings>(),
      Rows::choice<&Settings::kind>(
          "kind", "Kind", "What the pixels hold",
          haptic::register_enum<DepthKind>(
              "GstDepthFieldKind",
              {{DepthKind::depth, "Distance from the camera", "depth"},
               {DepthKind::disparity, "Proportional to 1 / distance", "disparity"}})),
      Rows::number<&Settings::scale>(
          "scale", "Scale",
          "Metres that are one unit of depth; of disparity, metres times the value of a pixel",
          kLeast, kLargest),
      Rows::number<&Settings::near>(
          "near", "Near", "Metres from the camera that are the highest place of the relief", kLeast,
          kFarthest),
      Rows::number<&Settings::far>("far", "Far",
                                   "Metres from the camera that are the lowest place of the relief",
                                   kLeast, kFarthest),
      Rows::number<&Settings::range>(
          "range", "Range", "Metres between the lowest and the highest place of the relief", 0,
          2 * haptic::kMostReliefHeight),
      Rows::choice<&Settings::cell_height>(
          "cell-height", "Cell Height", "Which pixels give the height of a cell",
          haptic::register_enum<CellHeight>(
              "GstDepthFieldCellHeight",
              {{CellHeight::median, "The median of the pixels", "median"},
               {CellHeight::nearest, "The nearest tenth of the pixels", "nearest"}})),
      Rows::number<&Settings::stiffness>("stiffness", "Stiffness",
                                         "Stiffness of the surface in N/m", 0,
                                         haptic::kMostReliefStiffness),
      Rows::number<&Settings::friction>("friction", "Friction",
                                        "Coulomb coefficient of the surface", 0,
                                        haptic::kMostReliefFriction),
  };
  return table;
}

} // namespace

static void gst_depth_field_class_init(GstDepthFieldClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "depthfield", "Depth field", "Filter/Analyzer/Video",
                   "Makes a relief of frames of depth or disparity",
                   GST_VIDEO_CAPS_MAKE("{ GRAY16_LE, GRAY8 }"), HAPTIC_RELIEF_CAPS);
  haptic::install_properties<properties>(G_OBJECT_CLASS(klass), [](GObject *object) -> Settings & {
    return state_of(object).settings;
  });
}

static void gst_depth_field_init(GstDepthField *self) {
  gst_relief_maker_set_state(GST_RELIEF_MAKER(self), new State(GST_ELEMENT(self)));
}
