#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compares the envelopes of a vibration: live, as WAV and as AHAP.

Usage: envelopes.py LIVE.f32 SOUND.wav PATTERN.ahap: two channels; 48 kHz.
The envelope is the energy of both channels in each 100 ms, 18 periods of the carrier of coils-2, as amplitude.
"""
import array
import json
import math
import sys

RATE = 48000  # Hz
WINDOW = 0.1  # s
WANTED = 0.05  # of the highest amplitude


def envelope(samples):
    size = 2 * int(WINDOW * RATE)
    return [math.sqrt(2 * sum(s * s for s in samples[i:i + size]) * 2 / size)
            for i in range(0, len(samples) - size + 1, size)]


def floats(data):
    samples = array.array("f")
    samples.frombytes(data[:len(data) // 4 * 4])
    return samples


def pattern(path):
    with open(path, encoding="utf-8") as file:
        items = json.load(file)["Pattern"]
    events = [item["Event"] for item in items if "Event" in item]
    points = sorted((c["ParameterCurve"]["Time"] + p["Time"], p["ParameterValue"])
                    for c in items if "ParameterCurve" in c
                    for p in c["ParameterCurve"]["ParameterCurveControlPoints"])

    def at(time):
        if not any(e["Time"] <= time <= e["Time"] + e.get("EventDuration", 0) for e in events):
            return 0
        for (t0, v0), (t1, v1) in zip(points, points[1:]):
            if t0 <= time <= t1:
                return (v0 + (v1 - v0) * (time - t0) / (t1 - t0) if t1 > t0 else v1) ** 2  # as amplitude
        return 0
    return at


def read(path):
    with open(path, "rb") as file:
        return file.read()


live = envelope(floats(read(sys.argv[1])))
wav = read(sys.argv[2])
sound = envelope(floats(wav[wav.index(b"data") + 8:]))
at = pattern(sys.argv[3])
felt = []
for i in range(len(live)):
    times = [(i + (j + 0.5) / 20) * WINDOW for j in range(20)]
    felt.append(math.sqrt(sum(at(time) ** 2 for time in times) / len(times)))
highest = max(live)
count = min(len(live), len(sound)) - 2  # the end is that of the track
of_sound = max(abs(a - b) for a, b in zip(live[:count], sound)) / highest
of_pattern = max(abs(a - b) for a, b in zip(live[:count], felt)) / highest
print(f"{count} windows, highest amplitude {highest:.3f}; off by {100 * of_sound:.1f} % (WAV), "
      f"{100 * of_pattern:.1f} % (AHAP) of it")
sys.exit(not (count >= 25 and highest > 0.2 and of_sound <= WANTED and of_pattern <= WANTED))
