#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The judge of hold.sh, on tracks that are so short that the figures can be worked out by hand."""
import io
import os
import pathlib
import pickle
import sys
import tempfile
import unittest

try:
    import numpy
except ImportError:
    print("SKIPPED: Python has no numpy (package python3-numpy)")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import films_with_points
import hold_metric

HD = (1920, 1080)


def track(visible, errors, shown=None, held=None, rate=10, size=HD, kind="leaf", microseconds=0):
    """A point that stays at 500, 500 and is said to be so many px to the right of it."""
    visible = numpy.array(visible, bool)
    shown = visible if shown is None else numpy.array(shown, bool)
    true = numpy.full((len(visible), 2), 500.0)
    said = true + numpy.stack([numpy.array(errors, float), numpy.zeros(len(visible))], axis=1)
    held = shown if held is None else numpy.array(held, bool)
    state = numpy.where(held, hold_metric.HELD, numpy.where(shown, hold_metric.ABOUT, hold_metric.HIDDEN))
    return hold_metric.Track(kind, rate, size, true, visible, said, state, numpy.zeros(len(visible)) + microseconds)


class Metric(unittest.TestCase):
    def of(self, *tracks):
        return hold_metric.delta_and_jaccard(tracks, hold_metric.Track.error)

    def test_whoever_is_always_right_gets_everything(self):
        self.assertEqual(self.of(track([1, 1, 0, 1], [0, 0.9, 300, 0])), (1, 1))

    def test_delta_is_the_mean_over_five_thresholds(self):
        # 3 px off: within 4, 8 and 16.
        delta, jaccard = self.of(track([1, 1], [0, 3]))
        self.assertAlmostEqual(delta, 3 / 5)
        # Where it is not near enough, it is a false positive beside a missed point: 0 of 2.
        self.assertAlmostEqual(jaccard, 3 / 5)

    def test_delta_asks_for_the_place_alone_jaccard_for_what_is_said_too(self):
        # One of two visible frames is called hidden, at the right place.
        delta, jaccard = self.of(track([1, 1, 1], [0, 0, 0], shown=[1, 1, 0]))
        self.assertEqual((delta, jaccard), (1, 0.5))

    def test_to_show_what_is_hidden_is_a_false_positive(self):
        # One visible frame that is right, and one hidden that is shown: 1 of (1 + 1).
        delta, jaccard = self.of(track([1, 1, 0], [0, 0, 0], shown=[1, 1, 1]))
        self.assertEqual((delta, jaccard), (1, 0.5))

    def test_to_say_nothing_gets_nothing_of_the_jaccard(self):
        self.assertEqual(self.of(track([1, 1, 1], [0, 0, 0], shown=[0, 0, 0])), (1, 0))

    def test_the_frame_of_the_press_does_not_count_and_nothing_before_it(self):
        self.assertEqual(self.of(track([0, 0, 1, 1], [90, 90, 90, 0.5], shown=[1, 1, 1, 1])), (1, 1))

    def test_px_are_those_of_a_frame_1080_px_high_or_of_256(self):
        small = track([1, 1], [0, 1.5], size=(960, 540))
        self.assertAlmostEqual(small.error()[1], 3)
        self.assertAlmostEqual(small.error256()[1], 0.4)
        down = track([1, 1], [0, 0])
        down.said[1, 1] += 4.21875  # 1 px of 256 rows
        self.assertAlmostEqual(down.error256()[1], 1)

    def test_longer_tracks_weigh_more(self):
        delta, _ = self.of(track([1, 1, 1, 1], [0, 0, 0, 0]), track([1, 1], [0, 100]))
        self.assertEqual(delta, 3 / 4)


class Gaps(unittest.TestCase):
    # Ten frames a second: hidden for 0.3 s, then asked for half a second later.
    VISIBLE = [1] * 4 + [0] * 3 + [1] * 7

    def found(self, errors=None, **said):
        return hold_metric.found_again([track(self.VISIBLE, errors or [0] * 14, **said)])

    def test_a_thing_that_is_held_again_is_found(self):
        self.assertEqual(self.found(), (1, 1, 0))

    def test_a_thing_that_is_said_to_be_hidden_is_neither_found_nor_wrong(self):
        self.assertEqual(self.found(shown=[1] * 4 + [0] * 10), (1, 0, 0))

    def test_another_thing_is_wrong(self):
        self.assertEqual(self.found(errors=[0] * 7 + [17] * 7), (1, 0, 1))

    def test_about_is_never_wrong(self):
        self.assertEqual(self.found(errors=[0] * 7 + [17] * 7, held=[1] * 4 + [0] * 10), (1, 0, 0))

    def test_what_was_not_held_before_does_not_count(self):
        self.assertEqual(self.found(errors=[0] + [9] * 13), (0, 0, 0))

    def test_a_gap_that_is_too_short_or_too_long_or_ends_too_late_does_not_count(self):
        for visible in ([1] * 4 + [0] * 8 + [1] * 7, [1] * 4 + [0] * 3 + [1] * 5, [1] * 14):
            self.assertEqual(hold_metric.found_again([track(visible, [0] * len(visible))]), (0, 0, 0))
        brief = track([1] * 9 + [0] * 2 + [1] * 20, [0] * 31, rate=30)
        self.assertEqual(hold_metric.found_again([brief]), (0, 0, 0))

    def test_a_thing_that_is_hidden_again_at_once_does_not_count(self):
        visible = [1] * 4 + [0] * 3 + [1, 0, 1, 0, 1, 1, 1]
        self.assertEqual(hold_metric.found_again([track(visible, [0] * 14)])[0], 0)


class Summary(unittest.TestCase):
    def test_off_is_a_share_of_what_is_called_the_thing_itself(self):
        # Four frames after the press: two held, one of these 20 px off; one about and 20 px off; one hidden.
        made = track([1, 1, 1, 1, 1], [0, 0, 20, 20, 20], shown=[1, 1, 1, 1, 0], held=[1, 1, 1, 0, 0])
        figures = hold_metric.summary([made])
        self.assertEqual((figures["held"], figures["off"]), (0.5, 0.5))

    def test_times_of_what_is_seen_and_of_what_is_searched_stand_apart(self):
        spent = [500, 10, 20, 30, 100, 200, 900]
        shown, held = [1, 1, 1, 1, 0, 0, 0], [1, 1, 1, 0, 0, 0, 0]
        figures = hold_metric.summary([track([1] * 7, [0] * 7, shown, held, microseconds=spent)])
        self.assertEqual((figures["median_us"], figures["hidden_us"]), (20, 200))

    def test_the_error_after_a_time_is_a_median_of_the_visible_points(self):
        tracks = [track([1] * 21, [0] * 20 + [error]) for error in (1, 2, 50)]
        tracks.append(track([1] * 20 + [0], [0] * 20 + [99]))
        self.assertEqual(hold_metric.summary(tracks)["after2"], 2)

    def test_the_table_has_a_row_for_each_kind_and_one_for_all(self):
        tracks = [track([1, 1], [0, 0]), track([1, 1], [0, 100], kind="grass")]
        rows = list(hold_metric.table(hold_metric.by_kind(tracks)))
        self.assertEqual([row.split(" | ")[0] for row in rows[2:]], ["| grass", "| leaf", "| **all**"])
        self.assertEqual(rows[3].split(" | ")[:4], ["| leaf", "1", "100", "100"])
        self.assertIn("–", rows[2])


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def pickled(self, value):
        with open(self.path("videos.pkl"), "wb") as file:
            pickle.dump(value, file)
        return self.path("videos.pkl")

    def test_points_of_a_film_are_read(self):
        with open(self.path("film.csv"), "w", encoding="utf-8") as file:
            file.write("frame,point,kind,x,y,visible\n")
            file.write("0,0,leaf,1.5,2,1\n0,1,grass,3,4,0\n1,0,leaf,5,6,0\n1,1,grass,7,8,1\n")
        kinds, true, visible = films_with_points.read_points(self.path("film.csv"))
        self.assertEqual(kinds, ["leaf", "grass"])
        self.assertEqual(true.tolist(), [[[1.5, 2], [5, 6]], [[3, 4], [7, 8]]])
        self.assertEqual(visible.tolist(), [[True, False], [False, True]])
        self.assertEqual(films_with_points.starts_of(true, visible), [(0, 1.5, 2), (1, 7, 8)])

    def test_a_file_of_tap_vid_is_read(self):
        video = numpy.zeros((3, 90, 160, 3), numpy.uint8)
        video[:, :, :, 1] = 100
        points = numpy.array([[[0.5, 0.5], [0.25, 0.1], [0, 1]]])
        occluded = numpy.array([[False, True, False]])
        path = self.pickled({"dog": {"video": video, "points": points, "occluded": occluded}})
        ((name, luma, true, visible),) = films_with_points.read_tap_vid(path)
        self.assertEqual((name, luma.shape, luma[0, 0, 0]), ("dog", (3, 90, 160), 59))
        self.assertEqual(true.tolist(), [[[80, 45], [40, 9], [0, 90]]])
        self.assertEqual(visible.tolist(), [[True, False, True]])

    def test_a_file_that_would_run_code_is_not_opened(self):
        class Attack:
            def __reduce__(self):
                return os.mkdir, (made,)

        made = self.path("made")
        for value in (Attack(), {"dog": Attack()}):
            with self.assertRaisesRegex(films_with_points.Refused, "mkdir.*not opened"):
                list(films_with_points.read_tap_vid(self.pickled(value)))
        self.assertFalse(os.path.exists(made))

    def test_a_video_of_packed_frames_is_refused(self):
        with self.assertRaisesRegex(films_with_points.Refused, "no array of frames"):
            packed = {"dog": {"video": [b"jpeg"], "points": [], "occluded": []}}
            list(films_with_points.read_tap_vid(self.pickled(packed)))

    def test_films_are_handed_over_as_they_are(self):
        frames = numpy.arange(2 * 3 * 5).reshape(2, 3, 5)
        films_with_points.write_mono(self.path("film.y4m"), frames, 23.976)
        with open(self.path("film.y4m"), "rb") as file:
            stream = io.BytesIO(file.read())
        self.assertEqual(films_with_points.header_of(stream), (5, 3, 23.976, 15))
        self.assertEqual(stream.read(), b"FRAME\n" + bytes(range(15)) + b"FRAME\n" + bytes(range(15, 30)))

    def test_what_is_said_of_frames_before_the_press_is_nothing(self):
        said = numpy.array([[1, 0, 7, 8, 2, 30.0], [2, 0, 7, 9, 3, 40], [3, 0, 0, 0, 1, 0]])
        visible = numpy.array([[False, True, True]])
        (made,) = films_with_points.tracks_of(said, ["leaf"], numpy.zeros((1, 3, 2)), visible, 30, HD)
        self.assertEqual(made.said.tolist(), [[0, 0], [7, 8], [7, 9]])
        self.assertEqual((made.shown.tolist(), made.held.any()), ([False, True, False], False))
        self.assertEqual((made.start(), made.microseconds.tolist()), (1, [0, 30, 40]))


unittest.main()
