#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws a film of cut-outs of photographs that sway, turn and hide, with the true way of points on them.

The photographs are those of the Debian packages opencv-doc, python3-skimage and mate-backgrounds. The table of the
points is described in docs/formats/film-points.md. Ends with status 77 if a package is missing.
"""
import argparse
import sys

from photographs import SHUTTER, Album, Layer, cv2, encoder, numpy, outline, with_noise

WIDTH, HEIGHT = 1920, 1080
SUBFRAMES = (-0.375, -0.125, 0.125, 0.375)  # of the shutter
KINDS = ("leaf", "thing", "face")


def make_leaves_or_things(kind, album, random):
    """On a raster of 4×3 places. Every third thing is cut from the photograph of the one before."""
    layers, source = [], None
    for n, place in enumerate(random.permutation(12)):
        centre = WIDTH * (place % 4 + 0.5) / 4, HEIGHT * (place // 4 + 0.5) / 3
        if kind == "leaf":
            width, flatness, shape = int(random.uniform(42, 110)), random.uniform(0.4, 0.6), "leaf"
            amplitude, frequency = random.uniform(20, 80), random.uniform(0.3, 1.2)
            turn, growth = random.uniform(0.1, 0.5), 0.12
        else:
            width, flatness = int(random.uniform(110, 320)), random.uniform(0.6, 0.95)
            amplitude, frequency = random.uniform(20, 90), random.uniform(0.2, 0.9)
            turn, growth = random.uniform(0.05, 0.35), 0.15
            shape = "blob" if random.random() < 0.7 else "leaf"
        height = int(width * flatness)
        texture, source = album.piece(width, height, source if n % 3 == 2 else None)
        alpha = outline(width, height, shape, random)
        growth *= random.uniform(0.15, 1)
        layers.append(Layer(texture, alpha, centre, random, amplitude, frequency, turn, growth))
        if kind == "leaf":  # a neighbour that looks alike and sways by itself, half over or under it
            beside = centre + width * random.uniform((-1.3, -0.9), (1.3, 0.9))
            twin, _ = album.piece(width, height, source)
            sway = amplitude * random.uniform(0.6, 1.2), frequency * random.uniform(0.8, 1.2)
            layer = Layer(twin, outline(width, height, shape, random), beside, random, *sway, turn, growth)
            layers.insert(len(layers) - int(random.integers(2)), layer)
    return layers


def make_faces(album, random):
    layers = []
    for centre in ((330, 300), (960, 300), (1590, 300), (400, 790), (1000, 800), (1600, 790)):
        texture, alpha = album.face()
        layer = Layer(texture, alpha, centre, random, random.uniform(30, 80), random.uniform(0.2, 0.7),
                      random.uniform(0.03, 0.15), random.uniform(0.02, 0.12), random.uniform(2, 7))  # fmt: skip
        layer.angle *= 0.3
        layers.append(layer)
    return layers


def make_bars(things, kind, album, random, duration):
    """One for each second thing. It hides the middle for 0.15 to 0.6 s."""
    bars = []
    for thing in things[::2]:
        when = random.uniform(min(1.2, 0.4 * duration), max(duration - 1.2, 0.6 * duration))
        hidden = random.choice([0.15, 0.3, 0.3, 0.3, 0.5, 0.6])
        share = random.uniform(0.35, 0.7) if kind == "face" else random.uniform(0.5, 1.2)
        width, height = int(share * thing.width), int(1.9 * max(thing.width, thing.height) + 40)
        texture, _ = album.piece(width, height)
        middle = thing.place_of((thing.width / 2, thing.height / 2), when)
        bar = Layer(texture, outline(width, height, "bar", random), middle, random)
        bar.velocity[0] = random.choice([-1, 1]) * width / hidden
        bar.place -= bar.velocity * when
        bars.append(bar)
    return bars


def choose_points(things, kind, random):
    """Layer and texel of points that a person can point at: inside the thing, where it has some texture."""
    chosen = []
    # px that are the thing all round, contrast in grey levels, points of one thing
    reach, contrast, wanted = {"leaf": (4, 6, 3), "thing": (9, 6, 3), "face": (16, 12, 8)}[kind]
    for index, thing in enumerate(things):
        found = 0
        for _ in range(400):
            u, v = random.uniform((reach, reach), (thing.width - reach, thing.height - reach))
            around = slice(int(v) - reach, int(v) + reach + 1), slice(int(u) - reach, int(u) + reach + 1)
            if found < wanted and thing.alpha[around].min() > 0.9 and thing.texture[around].std() > contrast:
                chosen.append((index, (u, v)))
                found += 1
    return chosen


def is_visible(layers, index, place, time):
    return (
        0 <= place[0] <= WIDTH - 1
        and 0 <= place[1] <= HEIGHT - 1
        and not any(layer.covers(place, time) for layer in layers[index + 1 :])
    )


def read_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--seed", type=int, default=1, help="another film (1)")
    parser.add_argument("--rate", type=int, default=30, help="frames a second (30)")
    parser.add_argument("--duration", type=float, default=5, help="s (5)")
    parser.add_argument("--points", required=True, metavar="FILE", help="table of the points (CSV)")
    parser.add_argument("film", metavar="OUTPUT", help="ends in .mkv")
    return parser.parse_args()


def main():
    options = read_options()
    cv2.setNumThreads(1)
    cv2.setRNGSeed(options.seed)
    random = numpy.random.default_rng((options.seed, KINDS.index(options.kind)))
    album = Album(random)
    things = make_faces(album, random) if options.kind == "face" else make_leaves_or_things(options.kind, album, random)
    layers = things + make_bars(things, options.kind, album, random, options.duration)
    ground = album.ground(WIDTH + 240, HEIGHT + 160)
    drift = random.uniform((-12, -6), (12, 6)) * random.integers(2)  # px/s: half of the grounds stand still
    points = [
        (index, texel)
        for index, texel in choose_points(things, options.kind, random)
        if is_visible(layers, index, things[index].place_of(texel, 0), 0)
    ]
    with encoder(options.film, WIDTH, HEIGHT, options.rate) as process, open(options.points, "w", encoding="utf-8") as table:
        table.write("frame,point,kind,x,y,visible\n")
        for number in range(round(options.duration * options.rate)):
            time = number / options.rate
            mean = numpy.zeros((HEIGHT, WIDTH), numpy.float32)
            for part in SUBFRAMES:
                moment = time + part * SHUTTER / options.rate
                shift = numpy.array([-120.0, -80.0]) + drift * moment
                frame = cv2.warpAffine(ground, numpy.column_stack([numpy.eye(2), shift]), (WIDTH, HEIGHT))
                for layer in layers:
                    layer.draw(frame, moment)
                mean += frame / len(SUBFRAMES)
            process.stdin.write(with_noise(mean).tobytes() + bytes([128]) * (WIDTH * HEIGHT // 2))
            for point, (index, texel) in enumerate(points):
                place = things[index].place_of(texel, time)
                x, y = place + 0.5  # from the corner of the first pixel, not from its centre
                visible = int(is_visible(layers, index, place, time))
                table.write(f"{number},{point},{options.kind},{x:.3f},{y:.3f},{visible}\n")
    if process.returncode:
        sys.exit("cut-outs.py: the film could not be written; see above")


if __name__ == "__main__":
    main()
