#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""gst-launch-1.0 -e for a pipeline with a secret: other users can read the words of a command, but not its environment.

Usage: LAUNCH_SECRET=SECRET pipelines/launch.py PIPELINE...
  @secret@ in PIPELINE stands for SECRET. Packages: python3-gi, gir1.2-gstreamer-1.0.
"""

import os
import signal
import sys

import gi

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402


def show(kind, source, error, details):
    print(f"{kind}: from element {source.get_path_string()}: {error.message}", file=sys.stderr)
    print(f"Additional debug info:\n{details}", file=sys.stderr, flush=True)


def main(words):
    secret = os.environ.pop("LAUNCH_SECRET", None)
    if not words or secret is None:
        return __doc__
    Gst.init(None)
    try:
        pipeline = Gst.parse_launchv([word.replace("@secret@", secret) for word in words])
    except GLib.Error as error:
        return f"ERROR: {error.message}".replace(secret, "@secret@")
    loop = GLib.MainLoop()
    status = 0

    def on_message(_bus, message):
        nonlocal status
        if message.type == Gst.MessageType.WARNING:
            show("WARNING", message.src, *message.parse_warning())
        elif message.type == Gst.MessageType.ERROR:
            show("ERROR", message.src, *message.parse_error())
            status = 1
            loop.quit()
        elif message.type == Gst.MessageType.EOS:
            loop.quit()
        elif message.type == Gst.MessageType.LATENCY:
            pipeline.recalculate_latency()
        elif message.type == Gst.MessageType.NEW_CLOCK:
            print(f"New clock: {message.parse_new_clock().get_name()}", flush=True)
        elif message.type == Gst.MessageType.CLOCK_LOST:
            pipeline.set_state(Gst.State.PAUSED)
            pipeline.set_state(Gst.State.PLAYING)

    bus = pipeline.get_bus()
    bus.add_signal_watch()
    bus.connect("message", on_message)
    GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, signal.SIGINT, lambda: pipeline.send_event(Gst.Event.new_eos()))
    print("Setting pipeline to PLAYING ...", flush=True)
    pipeline.set_state(Gst.State.PLAYING)
    loop.run()
    pipeline.set_state(Gst.State.NULL)
    return status


sys.exit(main(sys.argv[1:]))
