#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The application behind pull-character.sh, which has its usage (package python3-gi).

The leash needs no force law of its own. A level relief with friction is what the character is to the hand: a hand that
presses into it sticks, and contact pulls it back to where it took hold with stiffness times distance, 1000 times a
second and behind every limit. This program only moves the layer as far as the hand has gone since.
"""

import math
import os
import pathlib
import signal
import struct
import sys

import gi

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

WIDTH, HEIGHT = 640, 360  # px, of what is shown
FRAME = f"video/x-raw,width={WIDTH},height={HEIGHT},framerate=30/1,pixel-aspect-ratio=1/1"
SIZE = 96  # px, of the character
PERIOD = 1 / 30  # s, of reliefs and of the character's way back
STIFFNESS = 60  # N/m: 1 N at 17 mm
FRICTION = 10  # more than a hand overcomes
HELD = 0.02  # N of pressing
RETURN = 0.1  # s, time constant
CELLS = 16
BELOW = -0.025  # m: no hand gets there


def drawn_character():
    """A round face as RGBA."""
    pixels = bytearray()
    for y in range(SIZE):
        for x in range(SIZE):
            u, v = 2 * x / SIZE - 1, 2 * y / SIZE - 1
            eye = math.hypot(abs(u) - 0.35, v + 0.25) < 0.13
            mouth = 0.45 < math.hypot(u, v) < 0.58 and v > 0.2
            inside = math.hypot(u, v) < 0.95
            pixels += bytes((40, 30, 20, 255) if inside and (eye or mouth) else (240, 180, 40, 255 if inside else 0))
    return bytes(pixels)


def relief(held):
    """The level z = 0 under the character's place; under all of the frame while it is held."""
    header = struct.pack(
        "<4sBBHQIIIIHHI", b"HMSP", 1, 2, 0, int(PERIOD * 1e9), WIDTH, HEIGHT, 1, 1, CELLS, CELLS, 0
    )
    cells = b""
    for i in range(CELLS * CELLS):
        middle = all(abs((n + 0.5) / CELLS - 0.5) < 0.2 for n in (i % CELLS, i // CELLS))
        cells += struct.pack("<4f", 0 if held or middle else BELOW, STIFFNESS, FRICTION, 1)
    return header + cells


class Leash:
    """How far the character is from its place, in parts of the frame."""

    def __init__(self):
        self.offset = (0.0, 0.0)
        self.held_at = None

    def move(self, x, y, pressing):
        if not pressing:
            self.held_at = None
        elif self.held_at is None:
            self.held_at = (x - self.offset[0], y - self.offset[1])
        if self.held_at:
            self.offset = (x - self.held_at[0], y - self.held_at[1])

    def step(self):
        if not self.held_at:
            left = math.exp(-PERIOD / RETURN)
            self.offset = tuple(part * left if abs(part) > 1e-4 else 0.0 for part in self.offset)


def read(arguments):
    options, sink = arguments[1:], []
    if "--" in options:
        at = options.index("--")
        options, sink = options[:at], options[at + 1 :]
    named = {}
    while len(options) > 1 and options[-2] in ("--output", "--story"):
        value, name = options.pop(), options.pop()
        named[name] = value
    if len(options) != 1 or not pathlib.Path(options[0]).is_file():
        sys.exit(f"pull-character.sh: there is no file '{' '.join(options)}'; see --help")
    for option, path in named.items():
        if os.path.exists(path) and os.path.samefile(path, options[0]):
            sys.exit(f"pull-character.sh: {option} would overwrite the film; give another name")
    return options[0], named, sink


def main(arguments):
    film, named, sink_options = read(arguments)
    Gst.init(None)
    shown = "autovideosink"
    if "--output" in named:
        shown = "jpegenc ! matroskamux ! filesink name=output"
    line = (
        'uridecodebin name=film caps="video/x-raw(ANY)" expose-all-streams=false ! videoconvert'
        " ! video/x-raw,format=I420 ! clocksync ! tee name=story story. ! queue ! videoscale ! videorate"
        f" ! {FRAME} ! compositor name=layers sink_1::repeat-after-eos=true ! {FRAME} ! videoconvert ! " + shown + " appsrc name=character"
        f" caps=video/x-raw,format=RGBA,width={SIZE},height={SIZE},framerate=30/1 format=time ! layers.sink_1"
    )
    # Not in one pipeline: beside a live source, compositor does not wait for frames that come late.
    feels = "appsrc name=reliefs format=time is-live=true do-timestamp=true caps=haptics/x-field,kind=relief ! hapticsink touch=surface"
    try:
        hand = Gst.parse_launchv([*feels.split(), *sink_options])
    except GLib.Error as error:
        sys.exit(f"pull-character.sh: hapticsink: {error.message}")
    reliefs = hand.get_by_name("reliefs")
    if "--story" in named:
        line += " story. ! queue ! filesink name=story-file"
    pipeline = Gst.parse_launch(line)
    element = pipeline.get_by_name
    element("film").set_property("uri", Gst.filename_to_uri(film))
    for option, name in (("--output", "output"), ("--story", "story-file")):
        if option in named:
            element(name).set_property("location", named[option])
    pad = element("layers").get_static_pad("sink_1")
    pad.set_property("xpos", (WIDTH - SIZE) // 2)
    pad.set_property("ypos", (HEIGHT - SIZE) // 2)
    drawing = Gst.Buffer.new_wrapped(drawn_character())
    drawing.pts, drawing.duration = 0, Gst.SECOND // 30
    element("character").emit("push-buffer", drawing)
    element("character").emit("end-of-stream")
    leash, loop, wrong = Leash(), GLib.MainLoop(), []

    def on_pointer(_pad, info):
        pointer = info.get_event().get_structure()
        if pointer and pointer.has_name("haptic-pointer"):
            # Without a force there is no such field.
            force = pointer.get_value("force-z") if pointer.has_field("force-z") else 0
            GLib.idle_add(leash.move, pointer.get_value("x"), pointer.get_value("y"), force > HELD)
        return Gst.PadProbeReturn.OK

    def tick():
        reliefs.emit("push-buffer", Gst.Buffer.new_wrapped(relief(leash.held_at is not None)))
        leash.step()
        x, y = (round((0.5 + part) * side - SIZE / 2) for part, side in zip(leash.offset, (WIDTH, HEIGHT)))
        pad.set_property("xpos", x)
        pad.set_property("ypos", y)
        print(x, y, "held" if leash.held_at else "free", flush=True)
        return GLib.SOURCE_CONTINUE

    def on_message(_bus, message):
        if message.type == Gst.MessageType.ERROR:
            wrong.append("pull-character.sh: " + message.parse_error().gerror.message)
        if message.type in (Gst.MessageType.ERROR, Gst.MessageType.EOS):
            loop.quit()

    reliefs.get_static_pad("src").add_probe(Gst.PadProbeType.EVENT_UPSTREAM, on_pointer)
    for bus in (pipeline.get_bus(), hand.get_bus()):
        bus.add_signal_watch()
        bus.connect("message", on_message)
    GLib.timeout_add(int(PERIOD * 1000), tick)
    GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, signal.SIGINT, lambda: pipeline.send_event(Gst.Event.new_eos()))
    hand.set_state(Gst.State.PLAYING)
    pipeline.set_state(Gst.State.PLAYING)
    loop.run()
    hand.set_state(Gst.State.NULL)
    pipeline.set_state(Gst.State.NULL)
    return wrong[0] if wrong else None


if __name__ == "__main__":
    sys.exit(main(sys.argv))
