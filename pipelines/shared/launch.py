# SPDX-License-Identifier: LGPL-2.1-or-later
"""gst-launch-1.0 -e for a pipeline with a secret: other users can read the words of a command, but not its environment.
And for RIST, which otherwise never ends.

Usage: [LAUNCH_SECRET=SECRET] /usr/bin/python3 pipelines/shared/launch.py PIPELINE...
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


def kind(element):
    return element.get_factory().get_name()


# The parts of ristsink and ristsrc that send RTCP get no end of stream, so that they, and with them the pipeline, never
# say that they have ended. Calls `ended` when each other sink has, and ristsink has taken its last packet.
def watch_ends(pipeline, ended):
    running = [element for element in pipeline.children
               if element.flags & Gst.ElementFlags.SINK and kind(element) != "ristsrc"]

    def end(element):
        if element in running:
            running.remove(element)
        if not running:
            ended()

    def on_event(pad, info, element):
        if info.get_event().type == Gst.EventType.EOS:
            GLib.idle_add(end, element)
        return Gst.PadProbeReturn.OK

    def on_message(_bus, message):
        structure = message.get_structure()
        if structure and structure.get_name() == "GstBinForwarded":
            inner = structure.get_value("message")
            if inner.type == Gst.MessageType.EOS:
                end(inner.src)

    for element in running:
        if kind(element) == "ristsink":
            element.get_static_pad("sink").add_probe(Gst.PadProbeType.EVENT_DOWNSTREAM, on_event, element)
    pipeline.set_property("message-forward", True)
    pipeline.get_bus().connect("message::element", on_message)


# The end of ristsrc, whose receiver waits for packets, does not come through either: it goes in behind it.
def end_stream(pipeline):
    pipeline.send_event(Gst.Event.new_eos())
    for element in pipeline.children:
        if kind(element) == "ristsrc":
            element.get_static_pad("src").get_peer().send_event(Gst.Event.new_eos())
    return True


def main(words):
    secret = os.environ.pop("LAUNCH_SECRET", "@secret@")
    if not words:
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
    watch_ends(pipeline, loop.quit)
    GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, signal.SIGINT, end_stream, pipeline)
    print("Setting pipeline to PLAYING ...", flush=True)
    pipeline.set_state(Gst.State.PLAYING)
    loop.run()
    pipeline.set_state(Gst.State.NULL)
    return status


sys.exit(main(sys.argv[1:]))
