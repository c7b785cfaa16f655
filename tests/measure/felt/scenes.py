#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws a film of photographs, 640×360 px, with the exact mean motion of roitracker's square at some places.

  rest   leaves, things and faces before a photograph that stands still
  sky    the same before clouds
  flat   discs and cloths without texture
  light  as rest, while the light changes by 10 %, once a second
  grass  a photograph of plants, bent by waves
  pan    as rest, while the camera pans
  shake  as rest, while the camera shakes by 5 px
  still  nothing but a photograph, while the camera pans

The truth is a text line for each frame (docs/formats/text-line.md), in a file for each place. It is the motion of what
each pixel of the square shows since the frame before. With --truth-of pointed it is the motion of those pixels of the
square that move with the one at the place. Ends with status 77 if a package is missing (see photographs.py).
"""
import argparse
import os
import sys

from photographs import SHUTTER, TAU, Album, Layer, cv2, encoder, grey, numpy, outline, photograph, resized, with_noise

WIDTH, HEIGHT = 640, 360
FINE = 2  # the film is drawn so much larger, and made smaller, as the pixels of a camera average
SUBFRAMES = (-0.25, 0.25)  # of the shutter
SCENES = ("rest", "sky", "flat", "light", "grass", "pan", "shake", "still")
NATURE = "/usr/share/backgrounds/mate/nature"
GROUNDS = {
    "sky": (f"{NATURE}/Storm.jpg", f"{NATURE}/Aqua.jpg"),
    "grass": (f"{NATURE}/GreenMeadow.jpg", "/usr/lib/python3/dist-packages/skimage/data/grass.png"),
}
SHAKE = 5.0  # px
# A pixel moves with another one within this and a share of its displacement, as in wind-film.
ALIKE = 0.15  # px
OF_DISPLACEMENT = 0.25


class Ground:
    """The photograph behind the things. Lengths are px of the large picture."""

    def __init__(self, scene, speed, album, random):
        self.scene, self.phases = scene, random.uniform(0, TAU, 6)
        self.large = WIDTH * FINE, HEIGHT * FINE
        least = self.large[0] + 600 * ("pan", "still").count(scene) + 60, self.large[1] + 200
        if scene in GROUNDS:
            image = grey(photograph(GROUNDS[scene][random.integers(len(GROUNDS[scene]))]))
            image = resized(image, max(least[0] / image.shape[1], least[1] / image.shape[0]))
        else:
            image = album.ground(*least)
        self.texture = cv2.GaussianBlur(image, (0, 0), 0.7)
        angle = random.uniform(-0.4, 0.4)
        self.velocity = speed * FINE * numpy.array([numpy.cos(angle), numpy.sin(angle)])  # px a second
        self.room = numpy.array(self.texture.shape[::-1]) - self.large

    def shift(self, time):
        """Where in the texture the corner of the picture is."""
        middle = self.room / 2
        if self.scene in ("pan", "still"):  # there and back
            way = numpy.abs(self.velocity) * time
            return self.room - numpy.abs(self.room - way % (2 * self.room))
        if self.scene == "shake":
            a, b, c, d = self.phases[:4]
            wave = numpy.sin(TAU * 0.4 * time + a) + 0.5 * numpy.sin(TAU * 1.1 * time + b)
            other = numpy.sin(TAU * 0.55 * time + c) + 0.4 * numpy.sin(TAU * 1.5 * time + d)
            return middle + SHAKE * FINE * numpy.array([wave, 0.6 * other])
        return middle

    def bent(self, x, y, time):
        """By how much the plants are bent at x, y."""
        sway = 4 * FINE * (0.3 + 0.7 * numpy.clip(1 - y / self.large[1], 0, 1))
        slow = TAU * (0.7 * time - x / (220 * FINE)) + self.phases[4]
        fast = TAU * (1.3 * time - x / (90 * FINE) + y / (130 * FINE)) + self.phases[5]
        return sway * (numpy.sin(slow) + 0.35 * numpy.sin(fast)), 0.25 * sway * numpy.cos(slow)

    def texel(self, x, y, time):
        left, top = self.shift(time)
        if self.scene != "grass":
            return x + left, y + top
        u, v = self.bent(x, y, time)
        return x + left - u, y + top - v

    def place_of(self, texel, time):
        x, y = texel - self.shift(time).reshape(2, 1)
        place = x, y
        if self.scene == "grass":
            for _ in range(20):  # plants bend by less than their distance
                u, v = self.bent(*place, time)
                place = x + u, y + v
        return numpy.array(place)

    def draw(self, time):
        if self.scene != "grass":
            move = numpy.column_stack([numpy.eye(2), -self.shift(time)])
            return cv2.warpAffine(self.texture, move, self.large, flags=cv2.INTER_CUBIC)
        y, x = numpy.mgrid[0 : self.large[1], 0 : self.large[0]].astype(numpy.float32)
        u, v = self.texel(x, y, time)
        return cv2.remap(self.texture, u.astype(numpy.float32), v.astype(numpy.float32), cv2.INTER_LINEAR)


def make_thing(kind, place, album, random):
    """What a viewer would point at; sizes are px of the large picture, of which 1280 are the width."""
    amplitude, frequency, turn, growth, warp = random.uniform(20, 85), random.uniform(0.3, 1.2), 0.3, 0.1, 0.0
    if kind == "face":
        texture, alpha = album.face(200, 370)
        turn, warp, frequency = 0.1, random.uniform(1.5, 4), random.uniform(0.3, 0.9)
    elif kind == "flat":
        width = int(random.uniform(50, 180))
        height = int(width * random.uniform(0.6, 1))
        slope = random.uniform(-6, 6, 2)
        y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
        texture = random.uniform(40, 210) + slope[0] * x / width + slope[1] * y / height
        alpha = outline(width, height, ("blob", "bar")[random.integers(2)], random)
    else:
        width = int(random.uniform(28, 74) if kind == "leaf" else random.uniform(74, 214))
        height = int(width * (random.uniform(0.4, 0.6) if kind == "leaf" else random.uniform(0.6, 0.95)))
        texture, _ = album.piece(width, height)
        alpha = outline(width, height, "leaf" if kind == "leaf" or random.random() < 0.3 else "blob", random)
    layer = Layer(texture.astype(numpy.float32), alpha, place, random, amplitude, frequency, turn, growth, warp)
    layer.angle *= 0.3 if kind == "face" else 1
    return layer


def make_things(scene, album, random):
    """About thirteen of fifteen squares see something that moves."""
    if scene in ("grass", "still"):
        return []
    kinds = ("flat",) if scene == "flat" else ("leaf", "thing", "leaf", "thing", "face")
    things = []
    for n, cell in enumerate(random.permutation(15)[:13]):
        kind = kinds[n % len(kinds)]
        place = FINE * numpy.array([WIDTH * (cell % 5 + 0.5) / 5, HEIGHT * (cell // 5 + 0.5) / 3])
        place += random.uniform(-0.25, 0.25, 2) * FINE * numpy.array([WIDTH / 5, HEIGHT / 3])
        for _ in range(5 if kind == "leaf" else 1):  # leaves grow in tufts
            beside = random.uniform((-50, -25), (50, 25)) if kind == "leaf" else 0
            things.append(make_thing(kind, place + beside, album, random))
    return things


def square(place):
    """Left, right, top and bottom of roitracker's square in px, as region_at() cuts it."""
    side = round(30 * WIDTH / 352)
    ends = []
    for at, length in zip(place, (WIDTH, HEIGHT)):
        begin = int(numpy.floor(at * length - side / 2 + 0.5))
        ends += [min(max(begin, 0), length - 1), min(max(begin + side, 1), length)]
    return ends


def places_before(seen, ground, things, time, earlier):
    """Where, at the earlier time, what is seen now was; [2, n], px of the large picture."""
    before = ground.place_of(numpy.array(ground.texel(*seen, time)), earlier)
    for thing in things:
        pose = thing.pose(time)
        texel = numpy.array(thing.texels(*numpy.linalg.solve(pose[:, :2], seen - pose[:, 2:]), time))
        alpha = cv2.remap(thing.alpha, *texel.astype(numpy.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        covered = alpha.ravel() > 0.5
        if covered.any():
            before[:, covered] = thing.place_of(texel[:, covered], earlier)
    return before


def mean_motion(area, ground, things, time, earlier, pointed=None):
    """px since the earlier time, of what the pixels of the area show: of all, or of those that move as `pointed` does.

    `pointed`: x and y of a pixel.
    """
    left, right, top, bottom = area
    y, x = numpy.mgrid[top:bottom, left:right].reshape(2, -1)
    seen = FINE * (numpy.array([x, y]) + 0.5) - 0.5  # centres of the pixels in the large picture
    moved = (seen - places_before(seen, ground, things, time, earlier)) / FINE
    if pointed:
        thing = moved[:, (y == pointed[1]) & (x == pointed[0])]
        moved = moved[:, numpy.hypot(*(moved - thing)) <= ALIKE + OF_DISPLACEMENT * numpy.hypot(*thing)]
    return moved.mean(axis=1)


def text_line(number, rate, motion, place, area):
    left, right, top, bottom = area
    vx, vy = motion * rate
    return (
        f"hv1 point t={number / rate:.9f} d={1 / rate:.9f} i={1 / rate:.9f} vx={vx:.6g} vy={vy:.6g} spin=0 div=0 "
        f"x={place[0]:.6g} y={place[1]:.6g} w={(right - left) / WIDTH:.6g} h={(bottom - top) / HEIGHT:.6g} conf=1 "
        f"pic={WIDTH}x{HEIGHT} par=1:1 n=1 model=translation\n"
    )


def read_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", choices=SCENES, required=True)
    parser.add_argument("--seed", type=int, default=1, help="another film (1)")
    parser.add_argument("--rate", type=int, default=60, help="frames a second (60)")
    parser.add_argument("--duration", type=float, default=5, help="s (5)")
    parser.add_argument("--speed", type=float, default=60, help="of a pan, px/s (60)")
    parser.add_argument("--quality", type=int, default=23, help="x264's constant rate factor (23), 0: lossless")
    parser.add_argument("--truth", required=True, metavar="FOLDER", help="a file for each place")
    parser.add_argument("--truth-of", choices=("square", "pointed"), default="square", help="see above (square)")
    parser.add_argument("--places", required=True, metavar="'X,Y X,Y …'", help="0 to 1, from the top left")
    parser.add_argument("film", metavar="OUTPUT", help="ends in .mkv")
    return parser.parse_args()


def main():
    options = read_options()
    cv2.setNumThreads(1)
    cv2.setRNGSeed(options.seed)
    random = numpy.random.default_rng((options.seed, SCENES.index(options.scene)))
    album = Album(random)
    ground = Ground(options.scene, options.speed, album, random)
    things = make_things(options.scene, album, random)
    places = [tuple(map(float, word.split(","))) for word in options.places.split()]
    areas = [square(place) for place in places]
    pixels = [
        (min(int(x * WIDTH), WIDTH - 1), min(int(y * HEIGHT), HEIGHT - 1)) if options.truth_of == "pointed" else None
        for x, y in places
    ]
    lines = ["" for _ in places]
    with encoder(options.film, WIDTH, HEIGHT, options.rate, options.quality) as process:
        for number in range(round(options.duration * options.rate)):
            time, step = number / options.rate, 1 / options.rate
            large = numpy.zeros((HEIGHT * FINE, WIDTH * FINE), numpy.float32)
            for part in SUBFRAMES:
                moment = time + part * SHUTTER * step
                frame = ground.draw(moment)
                for thing in things:
                    thing.draw(frame, moment)
                large += frame / len(SUBFRAMES)
            if options.scene == "light":
                large *= 1 + 0.1 * numpy.sin(TAU * time)
            mean = cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
            # Noise would hide whether a pan is told from rest.
            luma = with_noise(mean) if options.scene != "still" else numpy.rint(mean.clip(16, 235)).astype(numpy.uint8)
            process.stdin.write(luma.tobytes() + bytes([128]) * (WIDTH * HEIGHT // 2))
            for index, (place, area, pixel) in enumerate(zip(places, areas, pixels)):
                motion = mean_motion(area, ground, things, time, time - step, pixel) if number else numpy.zeros(2)
                lines[index] += text_line(number, options.rate, motion, place, area)
    if process.returncode:
        sys.exit("scenes.py: the film could not be written; see above")
    os.makedirs(options.truth, exist_ok=True)
    for place, text in zip(places, lines):
        name = f"{place[0]:g}-{place[1]:g}.txt"
        with open(os.path.join(options.truth, name), "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    main()
