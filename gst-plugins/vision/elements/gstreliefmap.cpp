// SPDX-License-Identifier: LGPL-2.1-or-later
// reliefmap makes a relief, a surface to touch, of the colours of frames by a table.
//
//   gst-launch-1.0 videotestsrc ! videoconvert ! reliefmap table=foliage ! fakesink
//
// It reads 25 pixels of each cell.
#include "elements/gstreliefmaker.h"
#include "glue/element-class.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "relief/colour-relief.hpp"

#include <memory>
#include <span>
#include <stdexcept>
#include <string>

G_DECLARE_FINAL_TYPE(GstReliefMap, gst_relief_map, GST, RELIEF_MAP, GstReliefMaker)

namespace {

// State

struct Settings {
  guint columns = haptic::kReliefColumns;
  std::string table = "generic";
};

} // namespace

struct _GstReliefMap {
  GstReliefMaker parent;
};

G_DEFINE_TYPE(GstReliefMap, gst_relief_map, GST_TYPE_RELIEF_MAKER)
GST_ELEMENT_REGISTER_DEFINE(reliefmap, "reliefmap", GST_RANK_NONE, gst_relief_map_get_type())

namespace {

class State final : public haptic::ReliefMaker {
public:
  explicit State(GstElement *element) : element_(element) {}

  bool start() override {
    try {
      Table loaded = load(haptic::locked_copy(element_, settings.table));
      const haptic::ObjectLock lock(element_);
      table_.swap(loaded);
    } catch (const std::runtime_error &error) {
      GST_ELEMENT_ERROR(element_, RESOURCE, SETTINGS, ("%s", error.what()), (nullptr));
      return false;
    }
    return true;
  }

  guint follow_settings() override {
    const haptic::ObjectLock lock(element_);
    in_use_ = table_;
    return settings.columns;
  }

  void make(const GstVideoFrame &mapped) override {
    haptic::ColourView view;
    for (guint i = 0; i < view.components.size(); ++i)
      view.components[i] = static_cast<const std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(&mapped, i));
    view.width = GST_VIDEO_INFO_WIDTH(&frame);
    view.height = GST_VIDEO_INFO_HEIGHT(&frame);
    view.stride = GST_VIDEO_FRAME_PLANE_STRIDE(&mapped, 0);
    view.pixel_size = GST_VIDEO_FRAME_COMP_PSTRIDE(&mapped, 0);
    haptic::make_colour_relief(view, *in_use_, relief);
  }

  Settings settings; // object lock

private:
  using Table = std::shared_ptr<const haptic::TouchTable>;
  static Table load(const std::string &name) {
    return std::make_shared<const haptic::TouchTable>(haptic::load_touch_table(name));
  }

  GstElement *element_;
  Table table_ = load(settings.table); // object lock; as of the last start()
  Table in_use_;                       // streaming thread
};

State &state_of(gpointer element) {
  return *static_cast<State *>(gst_relief_maker_state(GST_RELIEF_MAKER(element)));
}

// Properties

std::span<const haptic::Property<Settings>> properties() {
  static const haptic::Property<Settings> table[] = {
      haptic::relief_columns_row<Settings>(),
      haptic::Rows<Settings>::text<&Settings::table>(
          "table", "Table",
          "What colours feel like: generic, fabric, foliage, or the path of a "
          "table file. Takes effect at the next start"),
  };
  return table;
}

} // namespace

static void gst_relief_map_class_init(GstReliefMapClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "reliefmap", "Relief map", "Filter/Analyzer/Video",
                   "Makes a relief of the colours of frames by a table",
                   GST_VIDEO_CAPS_MAKE("{ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, "
                                       "ABGR }"),
                   HAPTIC_RELIEF_CAPS);
  haptic::install_properties<properties>(G_OBJECT_CLASS(klass), [](GObject *object) -> Settings & {
    return state_of(object).settings;
  });
}

static void gst_relief_map_init(GstReliefMap *self) {
  gst_relief_maker_set_state(GST_RELIEF_MAKER(self), new State(GST_ELEMENT(self)));
}
