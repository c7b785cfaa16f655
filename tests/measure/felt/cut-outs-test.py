#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The points of the cut-outs are where they are drawn, and visible where they are seen."""
import importlib.util
import pathlib
import sys
import unittest

try:
    import cv2
    import numpy
except ImportError:
    print("SKIPPED: Python has no OpenCV (package python3-opencv)")
    sys.exit(77)

spec = importlib.util.spec_from_file_location("cut_outs", pathlib.Path(__file__).with_name("cut-outs.py"))
cut_outs = importlib.util.module_from_spec(spec)
spec.loader.exec_module(cut_outs)

SIZE = 320, 240  # width and height of a thing, px


def soft_layer(texture, alpha=None, seed=1):
    """A face as wild as they get."""
    alpha = numpy.ones_like(texture) if alpha is None else alpha
    random = numpy.random.default_rng(seed)
    return cut_outs.Layer(texture, alpha, (700, 500), random, 80, 0.7, 0.15, 0.12, 7)


def value_at(image, place):
    return float(cv2.getRectSubPix(image, (1, 1), tuple(float(value) for value in place))[0, 0])


class CutOuts(unittest.TestCase):
    def test_a_point_is_where_its_texel_is_drawn(self):
        v, u = numpy.mgrid[0 : SIZE[1], 0 : SIZE[0]].astype(numpy.float32)
        for time in (0, 0.7, 2.9):
            drawn = []
            for ramp in (u, v):
                frame = numpy.zeros((cut_outs.HEIGHT, cut_outs.WIDTH), numpy.float32)
                soft_layer(ramp).draw(frame, time)
                drawn.append(frame)
            for texel in ((20, 30), (160.5, 120.25), (300, 200), (40, 219)):
                place = soft_layer(u).place_of(texel, time)
                for frame, expected in zip(drawn, texel):
                    # OpenCV's cubic interpolation bends a ramp by up to 0.06 between texels.
                    self.assertAlmostEqual(value_at(frame, place), expected, delta=0.07)

    def test_what_covers_a_place_is_what_is_seen_there(self):
        random = numpy.random.default_rng(2)
        for shape in ("leaf", "blob", "bar"):
            white = numpy.ones((SIZE[1], SIZE[0]), numpy.float32)
            layer = soft_layer(white, cut_outs.outline(*SIZE, shape, random), seed=3)
            frame = numpy.zeros((cut_outs.HEIGHT, cut_outs.WIDTH), numpy.float32)
            layer.draw(frame, 1.3)
            covered = 0
            for y in range(250, 750, 7):
                for x in range(400, 1000, 7):
                    if abs(frame[y, x] - 0.5) > 0.45:  # not at the edge
                        covers = layer.covers(numpy.array([x, y]), 1.3)
                        self.assertEqual(covers, frame[y, x] > 0.5, (shape, x, y))
                        covered += covers
            self.assertGreater(covered, 300)

    def test_what_lies_above_hides(self):
        texture = numpy.ones((SIZE[1], SIZE[0]), numpy.float32)
        below, above = soft_layer(texture, seed=4), soft_layer(texture, seed=5)
        place = below.place_of((SIZE[0] / 2, SIZE[1] / 2), 0)
        self.assertFalse(cut_outs.is_visible([below, above], 0, place, 0))
        self.assertTrue(cut_outs.is_visible([above, below], 1, place, 0))
        self.assertFalse(cut_outs.is_visible([below], 0, numpy.array([-1.0, 500.0]), 0))

    def test_a_bar_hides_the_middle_for_the_time_that_it_should(self):
        class Photographs:
            def piece(self, width, height):
                return numpy.ones((height, width), numpy.float32), None

        things = [soft_layer(numpy.ones((60, 90), numpy.float32), seed=seed) for seed in range(8)]
        for thing in things:
            thing.amplitude = thing.warp = 0  # so that the bar alone decides
        random = numpy.random.default_rng(6)
        bars = cut_outs.make_bars(things, "thing", Photographs(), random, 5)
        self.assertEqual(len(bars), 4)
        for thing, bar in zip(things[::2], bars):
            times = numpy.arange(0, 5, 1 / 120)
            hidden = [not cut_outs.is_visible([thing, bar], 0, thing.place_of((45, 30), t), t) for t in times]
            self.assertTrue(0.13 < sum(hidden) / 120 < 0.66, sum(hidden) / 120)
            self.assertFalse(hidden[0] or hidden[-1])


unittest.main()
