#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Finds numbers of one device in what every device passes: the loop, the laws, touch, the safety chain and the properties.

Usage: device-numbers.py [ROOT]

* None of their files includes a header of libspidar that knows the SPIDAR-G. They have its limits from DeviceLimits.
* No constant of theirs has value and unit of a constant of the SPIDAR-G. Those stand in its driver (the comment behind a
  constant begins with the unit) and in the geometry files. Times are not compared: they belong to software and hands.

A number that was computed from one of the SPIDAR-G is not found. The tests on the arm of tests/support/device-limits.hpp
find it if it matters. The ranges of properties are no constants: a device limits what is set when it is opened.
"""

import re
import sys
from pathlib import Path

PASSED = ("gst-plugins/device/loop", "gst-plugins/device/force", "gst-plugins/device/touch", "gst-plugins/device/motion",
          "gst-plugins/device/session", "gst-plugins/device/elements", "spidar/src/safety",
          "spidar/include/spidar/device-limits.hpp", "spidar/src/machine.cpp")
KNOWS_NO_DEVICE = {"device-limits", "error", "export", "haptic-device", "limited-device", "machine", "types"}
DRIVER = "spidar/src/model/device.cpp"
GEOMETRIES = "spidar/geometry/*.ini"
MECHANICAL = {"N", "N·m", "N/m", "N·s/m", "N·m·s", "kg", "m", "W/N"}
OF_KEYS = {"tension-max": "N", "tension-min": "N", "grip-radius": "m", "metres-per-count": "m"}
INCLUDED = re.compile(r'^#include [<"]spidar/([\w-]+)\.hpp', re.MULTILINE)
CONSTANT = re.compile(r"\b(\w+) = (-?[\d.']+(?:e-?\d+)?);\s*//+<?\s*([^\s,;.:]+)")
KEY = re.compile(r"^([\w-]+)=(-?[\d.]+(?:e-?\d+)?)$", re.MULTILINE)


def constants(path):
    for name, value, unit in CONSTANT.findall(path.read_text(encoding="utf-8")):
        if unit in MECHANICAL and float(value.replace("'", "")) != 0:
            yield name, (float(value.replace("'", "")), unit)


def numbers_of_the_spidar(root):
    found = {number: name for name, number in constants(root / DRIVER)}
    for path in root.glob(GEOMETRIES):
        for key, value in KEY.findall(path.read_text(encoding="utf-8")):
            if key in OF_KEYS:
                found[abs(float(value)), OF_KEYS[key]] = key
    return found


def problems(root):
    of_spidar = numbers_of_the_spidar(root)
    if not of_spidar:
        yield f"{DRIVER}: no constant was found"
    files = [path for name in PASSED for path in ([root / name] if (root / name).is_file() else (root / name).glob("*.?pp"))]
    for path in sorted(files):
        where = path.relative_to(root)
        for header in INCLUDED.findall(path.read_text(encoding="utf-8")):
            if header not in KNOWS_NO_DEVICE:
                yield f"{where} includes spidar/{header}.hpp, which knows the SPIDAR-G"
        for name, number in constants(path):
            if number in of_spidar:
                yield f"{where}: {name} is {of_spidar[number]} of the SPIDAR-G, {number[0]:g} {number[1]}"


def main(root):
    found = list(problems(root))
    for problem in found:
        print(problem)
    print(f"{len(found)} numbers of one device")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2]))
