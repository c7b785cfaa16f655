#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The truth of the scenes: what a pixel shows has come from where the motion says."""
import sys
import unittest

import scenes
from photographs import Album, cv2, numpy

cv2.setNumThreads(1)
TIME, STEP = 0.7, 1 / 30
CENTRES = numpy.array([(x, y) for x in range(60, 1220, 7) for y in range(60, 660, 7)], float).T


class Drawn:
    """One moment of a scene and the one before, large and without noise."""

    def __init__(self, scene, seed=5):
        cv2.setRNGSeed(seed)
        random = numpy.random.default_rng(seed)
        album = Album(random)
        self.ground = scenes.Ground(scene, 60, album, random)
        self.things = scenes.make_things(scene, album, random)

    def frame(self, time):
        frame = self.ground.draw(time)
        for thing in self.things:
            thing.draw(frame, time)
        return frame

    def change(self, moves):
        """Half of the pixels change by less, in grey levels, along their motion or where they are."""
        now, earlier = self.frame(TIME), self.frame(TIME - STEP)
        before = scenes.places_before(CENTRES, self.ground, self.things, TIME, TIME - STEP) if moves else CENTRES
        shown = [cv2.remap(frame, *at.astype(numpy.float32), cv2.INTER_CUBIC).ravel() for frame, at in ((now, CENTRES), (earlier, before))]
        return numpy.abs(shown[0] - shown[1])


class Truth(unittest.TestCase):
    def test_pixels_come_from_where_the_motion_says(self):
        for scene in ("grass", "pan", "shake", "still"):
            with self.subTest(scene=scene):
                drawn = Drawn(scene)
                along, in_place = drawn.change(True), drawn.change(False)
                # Borders of what moves cover and uncover pixels.
                self.assertLess(numpy.percentile(along, 90), 4)
                self.assertLess(along.mean(), 0.6 * in_place.mean())

    def test_things_move_before_a_ground_at_rest(self):
        drawn = Drawn("rest")
        before = scenes.places_before(CENTRES, drawn.ground, drawn.things, TIME, TIME - STEP)
        moved = numpy.abs(CENTRES - before).max(axis=0) > 1e-6
        self.assertGreater(moved.mean(), 0.05)
        self.assertLess(moved.mean(), 0.6)
        self.assertLess(drawn.change(True)[moved].mean(), 0.6 * drawn.change(False)[moved].mean())

    def test_a_pan_has_its_speed_and_turns_in_time(self):
        drawn = Drawn("still")
        area = scenes.square((0.5, 0.5))
        for time in (0.5, 2.0):
            motion = scenes.mean_motion(area, drawn.ground, [], time, time - STEP)
            self.assertAlmostEqual(numpy.hypot(*motion), 60 * STEP, 5)
        self.assertTrue(all((drawn.ground.shift(time) >= 0).all() for time in numpy.arange(0, 60, 0.1)))

    def test_the_pointed_thing_is_what_moves_with_the_pixel(self):
        drawn = Drawn("rest")
        differ = 0
        for x in range(100, 600, 50):
            area = scenes.square((x / scenes.WIDTH, 0.5))
            of = [drawn.ground, drawn.things, TIME, TIME - STEP]
            pixel = scenes.mean_motion([x, x + 1, 180, 181], *of)
            pointed = scenes.mean_motion(area, *of, (x, 180))
            most = scenes.ALIKE + scenes.OF_DISPLACEMENT * numpy.hypot(*pixel)
            self.assertLessEqual(numpy.hypot(*(pointed - pixel)), most)
            differ += numpy.hypot(*(scenes.mean_motion(area, *of) - pixel)) > most
        self.assertGreater(differ, 0)

    def test_squares_are_those_of_roitracker(self):
        self.assertEqual(scenes.square((0.5, 0.5)), [293, 348, 153, 208])
        self.assertEqual(scenes.square((0, 1)), [0, 28, 333, 360])

    def test_a_line_has_the_velocity(self):
        line = scenes.text_line(3, 60, numpy.array([0.5, -1.0]), (0.1, 0.5), scenes.square((0.1, 0.5)))
        self.assertIn("t=0.050000000", line)
        self.assertIn("vx=30 vy=-60 ", line)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
