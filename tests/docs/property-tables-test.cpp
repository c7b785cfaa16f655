// SPDX-License-Identifier: LGPL-2.1-or-later
// The property tables in docs/elements/ match the elements, and each element names its page. The
// program has words for each reason that the page of the log names.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <gst/gst.h>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {

// Name and default of each property of the element itself, without its parents' properties.
using Properties = std::map<std::string, std::string>;

std::string number_text(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

std::string text_of(const GValue &value) {
  if (G_VALUE_HOLDS_BOOLEAN(&value)) {
    return g_value_get_boolean(&value) ? "true" : "false";
  }
  if (G_VALUE_HOLDS_ENUM(&value)) {
    auto *type = static_cast<GEnumClass *>(g_type_class_ref(G_VALUE_TYPE(&value)));
    const GEnumValue *entry = g_enum_get_value(type, g_value_get_enum(&value));
    std::string nick = entry != nullptr ? entry->value_nick : "";
    g_type_class_unref(type);
    return nick;
  }
  if (G_VALUE_HOLDS_STRING(&value)) {
    const gchar *text = g_value_get_string(&value);
    return text != nullptr ? text : "";
  }
  GValue number = G_VALUE_INIT;
  g_value_init(&number, G_TYPE_DOUBLE);
  const bool is_number = g_value_transform(&value, &number);
  return is_number ? number_text(g_value_get_double(&number)) : "";
}

Properties properties_of_element(const std::string &name) {
  Properties properties;
  GstElement *element = gst_element_factory_make(name.c_str(), nullptr);
  EXPECT_NE(element, nullptr) << name;
  if (element == nullptr) {
    return properties;
  }
  guint count = 0;
  GParamSpec **list = g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count);
  for (guint i = 0; i < count; ++i) {
    if (list[i]->owner_type == G_OBJECT_TYPE(element)) {
      properties[list[i]->name] = text_of(*g_param_spec_get_default_value(list[i]));
    }
  }
  g_free(list);
  gst_object_unref(element);
  return properties;
}

std::string without(std::string text, const std::string &characters) {
  std::erase_if(text, [&](char c) { return characters.find(c) != std::string::npos; });
  return text;
}

std::vector<std::string> cells_of(const std::string &line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  std::string cell;
  std::getline(stream, cell, '|'); // text before the first bar
  while (std::getline(stream, cell, '|')) {
    const auto first = cell.find_first_not_of(' ');
    const auto last = cell.find_last_not_of(' ');
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

// Normalises a default from a page: `20`, 1.0, `"sim"`, NULL or a dash for none.
std::string default_of_cell(const std::string &cell) {
  const std::string text = without(cell, "`\"");
  if (text == "NULL" || text == "-" || text == "–" || text == "—") {
    return "";
  }
  char *end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' ? number_text(number) : text;
}

// Reads the table with the head `| property | type | range/unit | default | meaning |`.
Properties properties_of_page(const std::string &name) {
  Properties properties;
  std::ifstream page(std::string(SOURCE_ROOT "/docs/elements/") + name + ".md");
  EXPECT_TRUE(page.is_open()) << name;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    const auto cells = cells_of(line);
    if (cells.size() < 5) {
      inside = false;
    } else if (without(cells[0], "`*") == "property" || without(cells[0], "`*") == "Property") {
      inside = true;
    } else if (inside && !cells[0].starts_with("-") && !cells[0].starts_with(":")) {
      properties[without(cells[0], "`")] = default_of_cell(cells[3]);
    }
  }
  return properties;
}

class PropertyTable : public testing::TestWithParam<const char *> {};

TEST_P(PropertyTable, ListsEveryPropertyOfTheElementWithItsDefaultAndNoOther) {
  const Properties element = properties_of_element(GetParam());
  EXPECT_FALSE(element.empty());
  EXPECT_EQ(properties_of_page(GetParam()), element);
}

TEST(Pages, EachElementNamesItsPage) {
  const std::string base = DOCUMENTATION_URI;
  for (const char *plugin : {"hapticvision", "haptictrack", "hapticdevice"}) {
    GList *features = gst_registry_get_feature_list_by_plugin(gst_registry_get(), plugin);
    for (GList *at = features; at != nullptr; at = at->next) {
      if (!GST_IS_ELEMENT_FACTORY(at->data)) {
        continue;
      }
      const std::string name = GST_OBJECT_NAME(at->data);
      EXPECT_TRUE(std::ifstream(std::string(SOURCE_ROOT "/docs/elements/") + name + ".md")) << name;
      const gchar *address = gst_element_factory_get_metadata(GST_ELEMENT_FACTORY(at->data),
                                                              GST_ELEMENT_METADATA_DOC_URI);
      EXPECT_EQ(address != nullptr ? address : "",
                base.empty() ? "" : base + "/elements/" + name + ".html");
    }
    gst_plugin_feature_list_free(features);
  }
}

TEST(Pages, TheProgramHasWordsForEachReasonThatHoldsTheForce) {
  std::ifstream words_file(SOURCE_ROOT "/pipelines/feeling-wind/window/session-text.cpp");
  const std::string words(std::istreambuf_iterator<char>(words_file), {});
  std::ifstream page(SOURCE_ROOT "/docs/formats/csv-log.md");
  std::size_t reasons = 0;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("## "))
      inside = line == "## The reasons in `hold`";
    const auto cells = cells_of(line);
    if (!inside || cells.size() != 3 || cells[0].empty() || !g_ascii_isdigit(cells[0][0])) {
      continue;
    }
    ++reasons;
    const std::string &name = cells[1];
    // The first two are states of their own. The last one holds nothing.
    if (name != "closed" && name != "released" && name != "spent") {
      EXPECT_NE(words.find("Words{\"" + name + "\""), std::string::npos) << name;
    }
  }
  EXPECT_GT(reasons, 10U);
}

INSTANTIATE_TEST_SUITE_P(Elements, PropertyTable,
                         testing::Values("roitracker", "velocityavg", "motionfield", "depthfield",
                                         "reliefmap", "hapticsink", "hapticconvert", "rtphmpgpay",
                                         "rtponesender", "hapticarray", "hapticoverlay"),
                         [](const auto &element) { return std::string(element.param); });

} // namespace

int main(int argc, char **argv) {
  testing::InitGoogleTest(&argc, argv);
  gst_init(&argc, &argv);
  return RUN_ALL_TESTS();
}
