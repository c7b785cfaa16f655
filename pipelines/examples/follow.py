#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Moves the pointer over a video from left to right and back, and prints the motion under it.

Shows how the elements, their properties and their messages are used from Python (package python3-gi).

Usage: pipelines/examples/follow.py VIDEO
  VIDEO  a file or URL
"""

import math
import os
import pathlib
import signal
import sys

import gi

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

PERIOD = 4  # s, there and back


def find_build():
    """Lets GStreamer find the elements of the build folder, as the scripts beside this one do."""
    root = pathlib.Path(__file__).resolve().parent.parent
    plugins = pathlib.Path(os.environ.get("FEELING_WIND_BUILD", root / "build")) / "gst-plugins"
    if plugins.is_dir():
        paths = [str(plugins), os.environ.get("GST_PLUGIN_PATH", "")]
        os.environ["GST_PLUGIN_PATH"] = os.pathsep.join(filter(None, paths))


def main(arguments):
    if len(arguments) != 2 or arguments[1].startswith("-"):
        return __doc__
    video = arguments[1]
    if "://" not in video and not pathlib.Path(video).is_file():
        return f"there is no file '{video}'; check the name"

    find_build()
    Gst.init(None)
    try:
        pipeline = Gst.parse_launch(
            'uridecodebin name=film caps="video/x-raw(ANY)" expose-all-streams=false ! videoconvert ! clocksync'
            " ! roitracker name=tracker pointer-source=property ! velocityavg post-messages=true"
            " ! hapticsink name=sink device=sim"
        )
    except GLib.Error as error:
        return f"{error.message}; run ./pipelines/demo.sh, which installs and builds everything"
    pipeline.get_by_name("film").set_property("uri", video if "://" in video else Gst.filename_to_uri(video))
    tracker = pipeline.get_by_name("tracker")
    loop = GLib.MainLoop()
    wrong = []

    def on_message(_bus, message):
        if message.type == Gst.MessageType.ERROR:
            wrong.append(message.parse_error().gerror.message)
            loop.quit()
        elif message.type == Gst.MessageType.EOS:
            loop.quit()
        elif message.type == Gst.MessageType.ELEMENT and message.get_structure().has_name("haptic-motion"):
            motion = message.get_structure()
            if motion.get_value("confidence") > 0:
                time, x = motion.get_value("pts") / Gst.SECOND, tracker.get_property("pointer-x")
                vx, vy, model = (motion.get_value(name) for name in ("vx", "vy", "model"))
                print(f"{time:7.3f} s  at {x:.2f}: {vx:7.1f} {vy:7.1f} px/s  {model}")

    def move_pointer():
        known, position = pipeline.query_position(Gst.Format.TIME)
        if known:
            tracker.set_property("pointer-x", 0.5 + 0.4 * math.sin(2 * math.pi * position / Gst.SECOND / PERIOD))
        return GLib.SOURCE_CONTINUE

    bus = pipeline.get_bus()
    bus.add_signal_watch()
    bus.connect("message", on_message)
    GLib.timeout_add(20, move_pointer)
    GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, signal.SIGINT, lambda: pipeline.send_event(Gst.Event.new_eos()))

    pipeline.set_state(Gst.State.PLAYING)
    loop.run()
    print(f"The sink says: {pipeline.get_by_name('sink').get_property('stats').to_string()}")
    pipeline.set_state(Gst.State.NULL)
    return wrong[0] if wrong else None


if __name__ == "__main__":
    sys.exit(main(sys.argv))
