# SPDX-License-Identifier: LGPL-2.1-or-later
"""Films whose points are known (docs/formats/film-points.md), files of TAP-Vid, and what a tracker says about them."""
import contextlib
import csv
import os
import pathlib
import pickle
import subprocess
import tempfile

import numpy

import hold_metric


class Refused(Exception):
    """The text contains the cure."""


def read_points(path):
    """Kind of each point, true places [points, frames, 2] and visibility [points, frames]."""
    kinds, rows = {}, []
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            kinds[int(row["point"])] = row["kind"]
            rows.append((int(row["point"]), int(row["frame"]), float(row["x"]), float(row["y"]), int(row["visible"])))
    table = numpy.array(rows)
    points, frames = table[:, 0].astype(int), table[:, 1].astype(int)
    shape = points.max() + 1, frames.max() + 1
    true, visible = numpy.zeros((*shape, 2)), numpy.zeros(shape, bool)
    true[points, frames] = table[:, 2:4]
    visible[points, frames] = table[:, 4] > 0
    return [kinds[point] for point in range(shape[0])], true, visible


@contextlib.contextmanager
def frames_of(path):
    """The frames of a film as a stream of YUV4MPEG2.

    GStreamer's y4menc writes the padding of avdec_h264's frames with them.
    """
    command = ["ffmpeg", "-nostdin", "-v", "error", "-i", str(path), "-map", "0:v:0", "-fps_mode", "passthrough"]
    command += ["-pix_fmt", "yuv420p", "-f", "yuv4mpegpipe", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as decoder:
        yield decoder.stdout
        decoder.stdout.close()


def header_of(stream):
    """Width, height, frames a second, and bytes of a frame, from the first line of YUV4MPEG2."""
    words = {word[:1]: word[1:] for word in stream.readline().decode().split()[1:] if word[0] != "X"}
    if "W" not in words:
        raise Refused("a film cannot be read; ffmpeg must be able to play it")
    width, height = int(words["W"]), int(words["H"])
    numerator, denominator = map(int, words["F"].split(":"))
    chroma = 0 if words.get("C") == "mono" else 2 * ((width + 1) // 2) * ((height + 1) // 2)
    return width, height, numerator / denominator, width * height + chroma


def write_mono(path, frames, rate):
    """`frames`: luma [frames, height, width]."""
    with open(path, "wb") as file:
        height, width = frames.shape[1:]
        file.write(f"YUV4MPEG2 W{width} H{height} F{round(1000 * rate)}:1000 Ip A1:1 Cmono\n".encode())
        for frame in frames:
            file.write(b"FRAME\n" + frame.astype(numpy.uint8).tobytes())


def run(program, tracker, stream, starts, again=None):
    """What hold-run says of a film."""
    return run_program([program, tracker], starts, [str(again)] if again is not None else [], stream)


def run_program(command, starts, more=(), stream=None):
    """What the tracker says, by rows: frame, point, x, y, state, µs. `starts`: frame, x and y of each point."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "starts"
        path.write_text("".join(f"{frame},{x:.3f},{y:.3f}\n" for frame, x, y in starts), encoding="utf-8")
        said = subprocess.run([*command, str(path), *more], stdin=stream, stdout=subprocess.PIPE, check=False)
    if said.returncode:
        raise Refused(f"{command[0]} ended with status {said.returncode}; see above")
    lines = said.stdout.decode().splitlines()[1:]
    return numpy.array([line.split(",") for line in lines], float).reshape(-1, 6)


def tracks_of(said, kinds, true, visible, rate, size):
    """`said`: of run(). Points without a visible frame are left out."""
    by_point = numpy.zeros((*visible.shape, 4))
    inside = said[:, 0] < visible.shape[1]  # a decoder may give one frame more
    said = said[inside]
    by_point[said[:, 1].astype(int), said[:, 0].astype(int)] = said[:, 2:]
    return [
        hold_metric.Track(kind, rate, size, true[i], visible[i], of[:, :2], of[:, 2], of[:, 3])
        for i, (kind, of) in enumerate(zip(kinds, by_point))
    ]


def starts_of(true, visible):
    first = visible.argmax(axis=1)
    return [(frame, *true[point, frame]) for point, frame in enumerate(first)]


def points_of(film, every):
    """Kinds, places and visibility of each `every`-th point that is seen, frames a second, and size."""
    kinds, true, visible = read_points(pathlib.Path(film).with_suffix(".csv"))
    chosen = [point for point in range(0, len(kinds), every) if visible[point].any()]
    with frames_of(film) as stream:
        width, height, rate, _ = header_of(stream)
    return [kinds[point] for point in chosen], true[chosen], visible[chosen], rate, (width, height)


def follow_film(program, tracker, film, every=1):
    """Tracks of each `every`-th point of a film, which has NAME.csv beside NAME.mkv."""
    kinds, true, visible, rate, size = points_of(film, every)
    with frames_of(film) as stream:
        said = run(program, tracker, stream, starts_of(true, visible))
    last = int(said[:, 0].max(initial=-1)) + 1
    if last < visible.shape[1]:
        raise Refused(f"{film} ends after {last} of {visible.shape[1]} frames")
    return tracks_of(said, kinds, true, visible, rate, size)


def follow_authored(program, author, chooses, film, every=1):
    """The same, of copies that `author` (haptic-track) makes, with these points or with things that it chooses."""
    kinds, true, visible, rate, size = points_of(film, every)
    starts = starts_of(true, visible)
    group = len(starts) if chooses else 32  # a field holds no more things
    said = []
    for first in range(0, len(starts), group):
        pressed = starts[first : first + group]
        # Half a frame early: the times of the film are rounded.
        held = [f"{x / size[0]:.6f},{y / size[1]:.6f}@{max(frame - 0.5, 0) / rate:.4f}" for frame, x, y in pressed]
        with tempfile.TemporaryDirectory() as folder:
            alone = os.path.join(folder, "film.mkv")  # a film that has a track already is not authored
            decoder = ["ffmpeg", "-nostdin", "-v", "error", "-i", str(film), "-map", "0:v:0", "-c", "copy", alone]
            subprocess.run(decoder, check=True)
            command = [author, "author"]
            for place in ["auto"] if chooses else held:
                command += ["--hold", place]
            subprocess.run([*command, alone], stdout=subprocess.DEVNULL, check=True)
            (copy,) = pathlib.Path(folder).glob("film.haptic.*")
            rows = run_program([program, str(copy), str(rate)], pressed)
        rows[:, 1] += first
        said.append(rows)
    return tracks_of(numpy.concatenate(said), kinds, true, visible, rate, size)


class ArraysOnly(pickle.Unpickler):
    """A pickle can name any function to be called. Only what makes arrays of numbers is let through."""

    NAMES = {
        (module, name)
        for core in ("numpy.core", "numpy._core")
        for module, name in (
            ("numpy", "ndarray"),
            ("numpy", "dtype"),
            (f"{core}.multiarray", "_reconstruct"),
            (f"{core}.multiarray", "scalar"),
            (f"{core}.numeric", "_frombuffer"),
        )
    }

    def find_class(self, module, name):
        if (module, name) not in self.NAMES:
            raise Refused(f"the file names {module}.{name}, which no file of TAP-Vid needs; it is not opened")
        return super().find_class(module, name)


def read_tap_vid(path):
    """Yields name, luma [frames, height, width], places [points, frames, 2] in px, visibility [points, frames]."""
    with open(path, "rb") as file:
        videos = ArraysOnly(file).load()
    if isinstance(videos, list):  # of RGB-Stacking; DAVIS has names
        videos = {str(number): video for number, video in enumerate(videos)}
    for name, video in videos.items():
        frames = numpy.asarray(video["video"])
        if frames.ndim != 4 or frames.shape[3] != 3 or frames.dtype != numpy.uint8:
            raise Refused(f"the video '{name}' is no array of frames; use the files of DAVIS or RGB-stacking")
        luma = frames @ numpy.array([0.299, 0.587, 0.114])  # BT.601
        size = numpy.array([frames.shape[2], frames.shape[1]])
        places = numpy.asarray(video["points"], float) * size
        yield name, numpy.rint(luma), places, ~numpy.asarray(video["occluded"], bool)


def follow_tap_vid(program, tracker, path, rate=24):
    """The tracks of each video. DAVIS has 24 frames a second; the files do not say so."""
    for name, luma, true, visible in read_tap_vid(path):
        seen = visible.any(axis=1)
        true, visible = true[seen], visible[seen]
        with tempfile.TemporaryDirectory() as folder:
            film = os.path.join(folder, "film.y4m")
            write_mono(film, luma, rate)
            with open(film, "rb") as stream:
                said = run(program, tracker, stream, starts_of(true, visible))
        yield tracks_of(said, [name] * len(true), true, visible, rate, (luma.shape[2], luma.shape[1]))


def luma_of(film, most=600):
    """Luma of up to `most` frames [frames, height, width], and frames a second."""
    frames = []
    with frames_of(film) as stream:
        width, height, rate, size = header_of(stream)
        while len(frames) < most and stream.readline().startswith(b"FRAME"):
            frames.append(numpy.frombuffer(stream.read(size), numpy.uint8, width * height).reshape(height, width))
    return numpy.array(frames), rate


def places_to_press(first, later):
    """Places on a raster of 48 px where a thing with texture moves: x and y, px."""
    for y in range(36, first.shape[0] - 36, 48):
        for x in range(36, first.shape[1] - 36, 48):
            patch = first[y - 10 : y + 11, x - 10 : x + 11].astype(float)
            change = numpy.abs(patch - later[y - 10 : y + 11, x - 10 : x + 11]).mean()
            if patch.std() > 8 and change > 4:  # grey levels; noise of 1.5 changes a patch by 1.7
                yield x + 0.5, y + 0.5


def round_trips(program, tracker, film, length=60):
    """Each place is held for `length` frames, taken anew, and held back to where it began.

    Returns how many places were pressed, in how many a thing was taken, in how many of these it was held at both ends,
    and the distances there from the beginning, in px of a frame 1080 px high.
    """
    luma, rate = luma_of(film)
    pressed = taken = 0
    distances = []
    for begin in range(0, len(luma) - length, length):
        window = luma[begin : begin + length + 1]
        places = list(places_to_press(window[0], window[10]))
        if not places:
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "film.y4m")
            write_mono(path, numpy.concatenate([window, window[-2::-1]]), rate)
            with open(path, "rb") as stream:
                said = run(program, tracker, stream, [(0, x, y) for x, y in places], again=length)
        at = {frame: said[said[:, 0] == frame] for frame in (0, length, 2 * length)}
        is_taken = at[0][:, 4] == hold_metric.HELD
        is_held = is_taken & (at[length][:, 4] == hold_metric.HELD) & (at[2 * length][:, 4] == hold_metric.HELD)
        pressed += len(places)
        taken += is_taken.sum()
        distances.extend(numpy.hypot(*(at[2 * length][:, 2:4] - numpy.array(places)).T)[is_held] * 1080 / luma.shape[1])
    return pressed, taken, len(distances), numpy.array(distances)
