#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The test of the includes refuses each kind of wrong house, and accepts a right one."""

import shutil
import tempfile
import unittest
from pathlib import Path

from includes import MOST_FILES, PAGE, PICTURE, SCANNED, House

ROOT = Path(__file__).parents[2]
HEAD = "| folder | includes also | rooms | GStreamer, GLib or OpenCV in |\n|---|---|---|---|\n"
VISION = "| `gst-plugins/vision` | `gst-plugins/common` | `pixels` → `tracking` → `elements` | `elements` |\n"
COMMON = "| `gst-plugins/common` | | | |\n"
FILES = {
    PAGE: f"{HEAD}{COMMON}{VISION}| `pipelines/web` | | `player` → `page` | |\n",
    PICTURE: """digraph {
  "gst-plugins/vision/pixels" -> "gst-plugins/vision/tracking" -> "gst-plugins/vision/elements"
  "pipelines/web/player" -> "pipelines/web/page"
  "gst-plugins/vision/elements" -> "pipelines/web/player" [label="what flows"]
}
""",
    "gst-plugins/common/field.hpp": "double at(int x);\n",
    "gst-plugins/common/field.cpp": '#include "field.hpp"\ndouble at(int x)\n{\n}\n',
    "gst-plugins/vision/messages.hpp": "",
    "gst-plugins/vision/pixels/README.md": "* Doors: `tensor.hpp`.\n",
    "gst-plugins/vision/pixels/tensor.hpp": '#include "pixels/rows.hpp"\n',
    "gst-plugins/vision/pixels/rows.hpp": "int rows();\n",
    "gst-plugins/vision/pixels/rows.cpp": '#include "pixels/rows.hpp"\n#include "messages.hpp"\nint rows()\n{\n}\n',
    "gst-plugins/vision/tracking/README.md": "* Doors: `tracker.hpp`.\n",
    "gst-plugins/vision/tracking/tracker.hpp": '#include "field.hpp"\n#include "pixels/tensor.hpp"\n',
    "gst-plugins/vision/elements/README.md": "* Doors: none.\n",
    "gst-plugins/vision/elements/plugin.cpp": '#include <gst/gst.h>\n#include "tracking/tracker.hpp"\n',
    "pipelines/web/player/README.md": "* Doors: `player.js`\n",
    "pipelines/web/player/player.js": "",
    "pipelines/web/page/README.md": "",
    "pipelines/web/page/page.js": "import { attach } from '../player/player.js';\n",
}


class Includes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        for name, text in FILES.items():
            self.write(name, text)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def add(self, name, text):
        self.write(name, FILES[name] + text)

    def replace_in_table(self, old, new):
        self.write(PAGE, FILES[PAGE].replace(old, new))

    def problems(self):
        return House(self.root).problems

    def assert_refused(self, *expected):
        problems = self.problems()
        self.assertEqual(len(problems), len(expected), problems)
        for problem, words in zip(problems, expected):
            self.assertIn(words, problem)

    def test_a_right_house_is_accepted(self):
        self.assertEqual(self.problems(), [])

    def test_an_include_against_the_arrows_is_refused(self):
        self.add("gst-plugins/vision/pixels/rows.hpp", '#include "tracking/tracker.hpp"\n')
        self.assert_refused("no arrow leads from tracking to pixels")

    def test_an_import_against_the_arrows_is_refused(self):
        self.write("pipelines/web/page/README.md", "* Doors: `page.js`\n")
        self.add("pipelines/web/player/player.js", "import { draw } from '../page/page.js';\n")
        self.assert_refused("no arrow leads from page to player")

    def test_an_arrow_that_no_include_needs_is_refused(self):
        self.replace_in_table("`elements` | `elements`", "`elements`<br>`pixels` → `elements` | `elements`")
        self.add(PICTURE, '"gst-plugins/vision/pixels" -> "gst-plugins/vision/elements"\n')
        self.assert_refused("nothing needs the arrow from pixels to elements")

    def test_an_arrow_that_only_the_picture_has_is_refused(self):
        self.add(PICTURE, '"gst-plugins/vision/pixels" -> "gst-plugins/vision/elements"\n')
        self.assert_refused("house.dot alone has an arrow from gst-plugins/vision/pixels")

    def test_arrows_in_a_circle_are_refused(self):
        self.replace_in_table("`elements` | `elements`", "`elements`<br>`tracking` → `pixels` | `elements`")
        self.assertTrue(any("arrows lead from pixels back to pixels" in problem for problem in self.problems()))

    def test_a_folder_that_the_table_does_not_allow_is_refused(self):
        self.add("gst-plugins/common/field.hpp", '#include "pixels/tensor.hpp"\n')
        self.assert_refused("fits none of the files")

    def test_a_folder_that_no_include_needs_is_refused(self):
        self.write("gst-plugins/vision/tracking/tracker.hpp", '#include "pixels/tensor.hpp"\n')
        self.assert_refused("nothing in gst-plugins/vision includes gst-plugins/common")

    def test_a_door_that_the_readme_does_not_name_is_refused(self):
        self.add("gst-plugins/vision/tracking/tracker.hpp", '#include "pixels/rows.hpp"\n')
        self.assert_refused("includes gst-plugins/vision/pixels/rows.hpp, which its room does not name as a door")

    def test_a_door_that_nobody_opens_is_refused(self):
        self.write("gst-plugins/vision/pixels/README.md", "* Doors: `tensor.hpp`,\n  `rows.hpp`.\n")
        self.assert_refused("no other room includes rows.hpp")

    def test_a_room_without_a_readme_is_refused(self):
        (self.root / "gst-plugins/vision/elements/README.md").unlink()
        self.assert_refused("gst-plugins/vision/elements has no README.md")

    def test_the_ground_includes_no_room(self):
        self.add("gst-plugins/vision/messages.hpp", '#include "pixels/tensor.hpp"\n')
        self.assert_refused("lies on the ground")

    def test_an_include_without_its_room_is_refused(self):
        self.add("gst-plugins/vision/pixels/rows.cpp", '#include "tensor.hpp"\n')
        self.assert_refused('should name its room: "pixels/tensor.hpp"')

    def test_a_name_of_two_files_is_refused(self):
        self.write("gst-plugins/common/one/size.hpp", "")
        self.write("gst-plugins/common/two/size.hpp", "")
        self.add("gst-plugins/vision/tracking/tracker.hpp", '#include "size.hpp"\n')
        self.assert_refused("fits 2 of the files")

    def test_a_name_of_no_file_is_refused(self):
        self.add("gst-plugins/vision/tracking/tracker.hpp", '#include "size.hpp"\n')
        self.assert_refused("fits none of the files")

    def test_a_library_that_a_plain_room_reaches_by_a_header_is_refused(self):
        self.add("gst-plugins/common/field.hpp", "#include <glib.h>\n")
        self.replace_in_table(COMMON, COMMON.replace("| | | |", "| | | all |"))
        self.assert_refused("tracking/tracker.hpp reaches GStreamer, GLib or OpenCV by gst-plugins/common/field.hpp")

    def test_a_library_that_nothing_includes_is_refused(self):
        self.replace_in_table("`elements` | `elements`", "`elements` | `tracking`, `elements`")
        self.assert_refused("gst-plugins/vision/tracking reaches none")

    def test_a_header_that_declares_what_another_room_defines_is_refused(self):
        self.add("gst-plugins/vision/pixels/rows.hpp", "int\ncolumns(int first,\n        int last);\n")
        self.write("gst-plugins/vision/tracking/columns.cpp", "int columns(int first, int last)\n{\n}\n")
        self.assert_refused("pixels/rows.hpp declares columns, which gst-plugins/vision/tracking defines")

    def test_a_plugin_starts_in_the_last_room(self):
        self.write("gst-plugins/vision/tracking/plugin.cpp", "")
        self.assert_refused("tracking/plugin.cpp starts a program")

    def test_a_file_outside_the_rooms_is_refused(self):
        self.write("gst-plugins/vision/colour/hue.hpp", "")
        self.assert_refused("gst-plugins/vision/colour/hue.hpp lies in no room")

    def test_a_folder_that_is_not_in_the_table_is_refused(self):
        self.write("gst-plugins/sound/tone.hpp", "")
        self.assert_refused("gst-plugins/sound/tone.hpp lies in no folder of the table")

    def test_one_file_too_many_is_refused(self):
        for number in range(2, MOST_FILES):
            self.write(f"gst-plugins/common/{number}.txt", "")
        self.assertEqual(self.problems(), [])
        self.write("gst-plugins/common/one-more.txt", "")
        self.assert_refused(f"gst-plugins/common holds {MOST_FILES + 1} files")


class ThisHouse(unittest.TestCase):
    def test_one_wrong_include_is_refused(self):
        with tempfile.TemporaryDirectory() as root:
            for name in SCANNED:
                shutil.copytree(ROOT / name, Path(root, name))
            Path(root, PICTURE).parent.mkdir(parents=True)
            for name in (PAGE, PICTURE):
                shutil.copy(ROOT / name, Path(root, name))
            self.assertEqual(House(root).problems, [])
            Path(root, "gst-plugins/common/wrong.hpp").write_text('#include "gsthapticmotionmeta.h"\n', encoding="utf-8")
            self.assertEqual(len(House(root).problems), 1)


if __name__ == "__main__":
    unittest.main()
