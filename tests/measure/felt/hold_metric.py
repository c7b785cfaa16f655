# SPDX-License-Identifier: LGPL-2.1-or-later
"""How well a tracker holds points whose true way is known.

δ and the average Jaccard (AJ) are those of TAP-Vid (Doersch et al., 2022) for points that are taken in their first
visible frame ("first"). Both are means over five thresholds. Distances are measured in px of a frame 1080 px high, and
once more after the frame is scaled to 256×256 px, which is TAP-Vid's own scale.
"""
import dataclasses

import numpy

THRESHOLDS = (1, 2, 4, 8, 16)  # px
WRONG = 16  # px of a frame 1080 px high: farther off, it is another thing
RIGHT = 8  # px: within it, a thing counts as found again
SHORTEST, LONGEST = 0.1, 0.7  # s: how long a thing is hidden that should be found again
HELD, ABOUT, HIDDEN = 1, 2, 3  # of HoldState (gst-plugins/common/samples/held-place.hpp)
SETTLED = 0.5  # s after the thing is visible again it is looked for


@dataclasses.dataclass
class Track:
    """One point in each frame: its true place and what a tracker said about it."""

    kind: str
    rate: float  # frames a second
    size: tuple  # width and height of the frame, px
    true: numpy.ndarray  # [frames, 2], px
    visible: numpy.ndarray  # [frames], bool
    said: numpy.ndarray  # [frames, 2], px
    state: numpy.ndarray  # [frames], numbers of HoldState
    microseconds: numpy.ndarray  # [frames]

    def __post_init__(self):
        self.held = self.state == HELD
        self.shown = self.held | (self.state == ABOUT)  # the tracker says that the point is visible

    def start(self):
        """The frame in which the point is taken."""
        return int(numpy.argmax(self.visible))

    def error(self):
        """Distance in each frame, in px of a frame 1080 px high."""
        return numpy.hypot(*(self.said - self.true).T) * 1080 / self.size[1]

    def error256(self):
        """The same on TAP-Vid's scale."""
        return numpy.hypot(*((self.said - self.true) * 256 / numpy.array(self.size)).T)


def delta_and_jaccard(tracks, error):
    """`error` says the distances of a track. Both results are shares, 0..1."""
    within, true_positives, false_positives = (numpy.zeros(len(THRESHOLDS)) for _ in range(3))
    visible = 0
    for track in tracks:
        judged = slice(track.start() + 1, None)
        near = error(track)[judged, None] < numpy.array(THRESHOLDS)
        seen = track.visible[judged, None]
        shown = track.shown[judged, None]
        visible += seen.sum()
        within += (seen & near).sum(axis=0)
        true_positives += (seen & shown & near).sum(axis=0)
        false_positives += (shown & ~(seen & near)).sum(axis=0)
    if not visible:
        return numpy.nan, numpy.nan
    return (within / visible).mean(), (true_positives / (visible + false_positives)).mean()


def gaps(track):
    """First and last frame of each time for which the thing is hidden and after which it should be found again."""
    settled = round(SETTLED * track.rate)
    edges = numpy.diff(track.visible.astype(int))
    for end in numpy.flatnonzero(edges == 1) + 1:
        begins = numpy.flatnonzero(edges[:end] == -1) + 1
        begins = begins[begins < end]
        if not begins.size or end + settled >= len(track.visible):
            continue
        begin = begins[-1]
        if not SHORTEST <= (end - begin) / track.rate <= LONGEST:
            continue
        # A thing that is hidden again at once cannot be asked for.
        if track.visible[end : end + settled + 1].mean() >= 0.8:
            yield begin, end


def found_again(tracks):
    """How many gaps there are before which the thing was held at its place, and in how many it was found or wrong."""
    count = found = wrong = 0
    for track in tracks:
        error = track.error()
        before = round(0.27 * track.rate)
        for begin, end in gaps(track):
            earlier = slice(max(begin - before, track.start()), begin)
            if not (track.shown[earlier] & (error[earlier] < RIGHT)).any():
                continue
            last = end + round(SETTLED * track.rate)
            while not track.visible[last]:
                last -= 1
            count += 1
            found += bool(track.shown[last] and error[last] < RIGHT)
            wrong += bool(track.held[last] and error[last] > WRONG)
    return count, found, wrong


def errors_after(tracks, seconds):
    """Of the points that are visible then."""
    errors = []
    for track in tracks:
        frame = track.start() + round(seconds * track.rate)
        if frame < len(track.visible) and track.visible[frame]:
            errors.append(track.error()[frame])
    return errors


def summary(tracks):
    """All figures of these tracks, as a dictionary."""
    after = [slice(track.start() + 1, None) for track in tracks]
    held = sum(track.held[judged].sum() for track, judged in zip(tracks, after))
    off = sum((track.held[judged] & (track.error()[judged] > WRONG)).sum() for track, judged in zip(tracks, after))
    times = numpy.concatenate([track.microseconds[judged] for track, judged in zip(tracks, after)])
    states = numpy.concatenate([track.state[judged] for track, judged in zip(tracks, after)])
    of_shown, of_hidden = times[(states == HELD) | (states == ABOUT)], times[states == HIDDEN]
    count, found, wrong = found_again(tracks)
    delta, jaccard = delta_and_jaccard(tracks, Track.error)
    delta256, jaccard256 = delta_and_jaccard(tracks, Track.error256)
    median = lambda values: numpy.median(values) if len(values) else numpy.nan
    share = lambda part, whole: part / whole if whole else numpy.nan
    return {
        "points": len(tracks),
        "delta": delta,
        "jaccard": jaccard,
        "delta256": delta256,
        "jaccard256": jaccard256,
        "after2": median(errors_after(tracks, 2)),
        "after10": median(errors_after(tracks, 10)),
        "gaps": count,
        "found": share(found, count),
        "wrong": share(wrong, count),
        "held": share(held, sum(len(track.visible) - track.start() - 1 for track in tracks)),
        "off": share(off, held),
        "median_us": median(of_shown),
        "slowest_us": numpy.quantile(of_shown, 0.999) if len(of_shown) else numpy.nan,
        "hidden_us": median(of_hidden),
    }


COLUMNS = (
    ("points", "points", "{:.0f}", 1),
    ("δ", "delta", "{:.0f}", 100),
    ("AJ", "jaccard", "{:.0f}", 100),
    ("δ 256", "delta256", "{:.0f}", 100),
    ("AJ 256", "jaccard256", "{:.0f}", 100),
    ("error after 2 s, px", "after2", "{:.2f}", 1),
    ("after 10 s, px", "after10", "{:.2f}", 1),
    ("gaps", "gaps", "{:.0f}", 1),
    ("found, %", "found", "{:.0f}", 100),
    ("wrong, %", "wrong", "{:.0f}", 100),
    ("held, % of frames", "held", "{:.0f}", 100),
    ("of these > 16 px off, %", "off", "{:.1f}", 100),
    ("µs, median", "median_us", "{:.0f}", 1),
    ("99.9 %", "slowest_us", "{:.0f}", 1),
    ("hidden", "hidden_us", "{:.0f}", 1),
)


def table(summaries):
    """`summaries`: pairs of a name and a dictionary of summary(). Lines of Markdown."""
    show = lambda value, form, scale: "–" if numpy.isnan(value) else form.format(value * scale)
    yield "| " + " | ".join(["what", *(column[0] for column in COLUMNS)]) + " |"
    yield "|---" * (len(COLUMNS) + 1) + "|"
    for name, of in summaries:
        yield "| " + " | ".join([name, *(show(of[key], form, scale) for _, key, form, scale in COLUMNS)]) + " |"


def by_kind(tracks):
    """Pairs for table(): each kind, and all."""
    kinds = sorted({track.kind for track in tracks})
    of_kinds = [(kind, summary([track for track in tracks if track.kind == kind])) for kind in kinds]
    return [*of_kinds, ("**all**", summary(tracks))]
