#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How far the haptic track of a copy has moved against its picture, felt as play-track.sh plays it.

  track-shift.py ORIGINAL DEMUXER STREAM COPY DEMUXER STREAM

Each frame of the original must look different. Prints the number of samples that have a frame beside them in both
files, the largest distance in ms between a sample and its frame in the copy, and what hapticconvert warns of.
"""

import hashlib
import re
import sys

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstApp", "1.0")
from gi.repository import Gst, GstApp  # noqa: E402

Gst.init(None)


def running_times(sink, key):
    """Returns the running time of each buffer at an appsink, ns, by key(bytes).

    matroskademux begins the segment anew when a later packet is before the first one. What it sent until then has a
    running time of its own.
    """
    times, start = {}, None
    while sample := sink.pull_sample():
        buffer, segment = sample.get_buffer(), sample.get_segment()
        if segment.start != start:
            times, start = {}, segment.start
        time = segment.to_running_time(Gst.Format.TIME, buffer.pts)
        if time != Gst.CLOCK_TIME_NONE:
            times[key(buffer.extract_dup(0, buffer.get_size()))] = time
    return times


def play(path, demuxer, stream):
    """Returns the times of the frames by their content, those of the samples by their own time, and the warnings."""
    pipeline = Gst.parse_launch(
        f'filesrc location="{path}" ! {demuxer} name=d d.{stream} ! queue max-size-time=0 max-size-buffers=0 '
        f"! hapticconvert ! text/x-raw ! appsink name=track sync=false async=false "
        f'filesrc location="{path}" ! decodebin caps="video/x-raw(ANY)" expose-all-streams=false ! videoconvert '
        f"! video/x-raw,format=GRAY8 ! appsink name=film sync=false async=false"
    )
    pipeline.set_state(Gst.State.PLAYING)
    frames = running_times(pipeline.get_by_name("film"), lambda data: hashlib.sha256(data).hexdigest())
    samples = running_times(
        pipeline.get_by_name("track"), lambda data: re.search(rb" t=([0-9.]+) ", data + b" ")[1].decode()
    )
    warnings = []
    bus = pipeline.get_bus()
    while message := bus.pop_filtered(Gst.MessageType.WARNING | Gst.MessageType.ERROR):
        parse = message.parse_warning if message.type == Gst.MessageType.WARNING else message.parse_error
        warnings.append(parse()[0].message)
    pipeline.set_state(Gst.State.NULL)
    return frames, samples, warnings


def main():
    frames, samples, _ = play(*sys.argv[1:4])
    by_time = {round(time / 1e6): frame for frame, time in frames.items()}
    pairs = [(own, by_time.get(round(time / 1e6))) for own, time in samples.items()]
    copied_frames, copied_samples, warnings = play(*sys.argv[4:7])
    shifts = [
        abs(copied_samples[own] - copied_frames[frame]) / 1e6
        for own, frame in pairs
        if own in copied_samples and frame in copied_frames
    ]
    print(f"{len(shifts)} samples {max(shifts, default=0):.3f} ms")
    print(*warnings, sep="\n")


main()
