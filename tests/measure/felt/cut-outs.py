#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws a film of cut-outs of photographs that sway, turn and hide, with the true way of points on them.

The photographs are those of the Debian packages opencv-doc, python3-skimage and mate-backgrounds. The table of the
points is described in docs/formats/film-points.md. Ends with status 77 if a package is missing.
"""
import argparse
import glob
import subprocess
import sys

try:
    import cv2
    import numpy
except ImportError:
    print("SKIPPED: Python has no OpenCV (package python3-opencv)")
    sys.exit(77)

WIDTH, HEIGHT = 1920, 1080
SHUTTER = 0.5  # of the frame interval
SUBFRAMES = (-0.375, -0.125, 0.125, 0.375)  # of the shutter
NOISE = 1.5  # grey levels
TAU = 2 * numpy.pi
KINDS = ("leaf", "thing", "face")

TEXTURES = {
    "/usr/share/doc/opencv-doc/examples/data": (
        "aloeL.jpg", "fruits.jpg", "baboon.jpg", "butterfly.jpg", "squirrel_cls.jpg", "graf1.png", "home.jpg",
        "starry_night.jpg", "rubberwhale1.png", "leuvenA.jpg", "building.jpg"),
    "/usr/lib/python3/dist-packages/skimage/data": (
        "grass.png", "gravel.png", "brick.png", "chelsea.png", "coffee.png", "rocket.jpg"),
    "/usr/share/backgrounds/mate/nature": ("Garden.jpg", "GreenMeadow.jpg", "FreshFlower.jpg", "LadyBird.jpg"),
}  # fmt: skip
GROUNDS = "/usr/share/backgrounds/mate/nature/*.jpg"
# Faces and figures: a box that OpenCV's GrabCut cuts a figure from, or an ellipse; both in px: x, y, width, height.
FACES = (
    ("skimage/data/astronaut.png", "figure", (20, 5, 440, 500)),
    ("skimage/data/camera.png", "figure", (60, 60, 260, 450)),
    ("examples/data/messi5.jpg", "figure", (65, 55, 400, 285)),
    ("skimage/data/chelsea.png", "ellipse", (25, 5, 380, 280)),
    ("examples/data/baboon.jpg", "ellipse", (50, 15, 410, 480)),
)


def photograph(path):
    image = cv2.imread(path)
    if image is None:
        print(f"SKIPPED: there is no {path} (packages opencv-doc, python3-skimage, mate-backgrounds)")
        sys.exit(77)
    return image


def grey(image):
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(numpy.float32)


def resized(image, scale):
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return cv2.resize(image, None, fx=scale, fy=scale, interpolation=how)


class Layer:
    """A texture that moves over the frame. Lengths are in px, times in s."""

    def __init__(self, texture, alpha, place, random, amplitude=0.0, frequency=1.0, turn=0.0, growth=0.0, warp=0.0):
        self.texture, self.alpha = texture, alpha
        self.height, self.width = texture.shape
        self.place = numpy.array(place, float)
        self.velocity = numpy.zeros(2)
        self.amplitude, self.frequency, self.turn, self.growth, self.warp = amplitude, frequency, turn, growth, warp
        self.angle = random.uniform(-0.6, 0.6) if turn else random.uniform(-0.25, 0.25)
        self.direction = random.uniform(-0.4, 0.4)
        self.phases = random.uniform(0, TAU, 9)

    def wave(self, index, time, speed):
        return numpy.sin(TAU * self.frequency * speed * time + self.phases[index])

    def pose(self, time):
        """From texels to px, 2×3."""
        gust = 0.7 + 0.3 * numpy.sin(TAU * 0.17 * time + self.phases[0])
        along = gust * (0.8 * self.wave(1, time, 1) + 0.35 * self.wave(2, time, 1.618))
        across = 0.3 * self.wave(3, time, 0.7)
        c, s = numpy.cos(self.direction), numpy.sin(self.direction)
        sway = self.amplitude * numpy.array([along * c - across * s, along * s + across * c])
        angle = self.angle + self.turn * (0.8 * self.wave(1, time, 1.05) + 0.4 * self.wave(4, time, 1.3))
        scale = numpy.exp(self.growth * self.wave(5, time, 0.6))
        shape = scale * numpy.array([[numpy.cos(angle), -numpy.sin(angle)], [numpy.sin(angle), numpy.cos(angle)]])
        origin = self.place + sway + self.velocity * time - shape @ (numpy.array([self.width, self.height]) / 2)
        return numpy.column_stack([shape, origin])

    def texels(self, u, v, time):
        """Which texels a soft thing shows where a rigid one would show u, v."""
        if not self.warp:
            return u, v
        bulge = numpy.exp(-(((u / self.width - 0.5) / 0.45) ** 2) - ((v / self.height - 0.5) / 0.45) ** 2)
        a, b = self.wave(6, time, 1.1), self.wave(7, time, 0.8)
        ripple = numpy.sin(TAU * v / self.height + self.phases[8])
        return u + self.warp * (a * bulge + 0.3 * b * ripple), v + self.warp * 0.5 * b * bulge

    def place_of(self, texel, time):
        rigid = numpy.array(texel, float)
        for _ in range(20):  # a warp is a contraction: it changes by less than its place does
            rigid = rigid + texel - numpy.array(self.texels(*rigid, time))
        pose = self.pose(time)
        return pose[:, :2] @ rigid + pose[:, 2]

    def covers(self, place, time):
        """Whether more than half of what is seen there is this thing."""
        pose = self.pose(time)
        texel = self.texels(*numpy.linalg.solve(pose[:, :2], place - pose[:, 2]), time)
        u, v = (int(round(float(value))) for value in texel)
        return 0 <= u < self.width and 0 <= v < self.height and self.alpha[v, u] > 0.5

    def draw(self, frame, time):
        pose = self.pose(time)
        corners = pose[:, :2] @ [[0, self.width, 0, self.width], [0, 0, self.height, self.height]] + pose[:, 2:]
        margin = 2 + 2 * self.warp
        left, top = numpy.maximum(corners.min(axis=1) - margin, 0).astype(int)
        right, bottom = numpy.minimum(corners.max(axis=1) + margin, (WIDTH, HEIGHT)).astype(int)
        if right <= left or bottom <= top:
            return
        y, x = numpy.mgrid[top:bottom, left:right].astype(numpy.float32) - pose[::-1, 2].reshape(2, 1, 1)
        back = numpy.linalg.inv(pose[:, :2])
        u, v = self.texels(back[0, 0] * x + back[0, 1] * y, back[1, 0] * x + back[1, 1] * y, time)
        u, v = u.astype(numpy.float32), v.astype(numpy.float32)
        alpha = cv2.remap(self.alpha, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        colour = cv2.remap(self.texture, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        part = frame[top:bottom, left:right]
        part += alpha * (colour - part)


class Album:
    def __init__(self, random):
        self.random = random
        self.textures = [grey(photograph(f"{folder}/{name}")) for folder, names in TEXTURES.items() for name in names]
        self.grounds = sorted(glob.glob(GROUNDS))

    def piece(self, width, height, source=None):
        """A part of a photograph with texture, and the photograph."""
        for attempt in range(300):
            image = source
            if source is None or attempt > 50:
                image = self.textures[self.random.integers(len(self.textures))]
            # Large photographs are made smaller, so that a leaf shows more than a blur.
            finest = 1.0 if image.shape[0] <= 1100 else self.random.uniform(0.35, 0.8) * 1100 / image.shape[0]
            scale = max(1.2 * width / image.shape[1], 1.2 * height / image.shape[0], finest)
            scaled = image if scale == 1 else resized(image, scale)
            x = self.random.integers(scaled.shape[1] - width)
            y = self.random.integers(scaled.shape[0] - height)
            cut = scaled[y : y + height, x : x + width]
            if cut.std() > 18:
                break
        return cut.copy(), image

    def ground(self):
        image = grey(photograph(self.grounds[self.random.integers(len(self.grounds))] if self.grounds else GROUNDS))
        return resized(image, max((WIDTH + 240) / image.shape[1], (HEIGHT + 160) / image.shape[0]))

    def face(self):
        ending, how, (x, y, width, height) = FACES[self.random.integers(len(FACES))]
        folder = next(folder for folder in TEXTURES if folder.endswith(ending.rsplit("/", 1)[0]))
        image = photograph(f"{folder}/{ending.rsplit('/', 1)[1]}")
        if how == "figure":
            mask = numpy.zeros(image.shape[:2], numpy.uint8)
            cv2.grabCut(image, mask, (x, y, width, height), None, None, 4, cv2.GC_INIT_WITH_RECT)
            mask = (mask % 2).astype(numpy.float32)  # the odd labels are those of the figure
        else:
            mask = numpy.zeros(image.shape[:2], numpy.float32)
            cv2.ellipse(mask, (x + width // 2, y + height // 2), (width // 2, height // 2), 0, 0, 360, 1, -1)
        cut = slice(y, y + height), slice(x, x + width)
        scale = self.random.uniform(300, 550) / height
        alpha = cv2.copyMakeBorder(mask[cut], 2, 2, 2, 2, cv2.BORDER_CONSTANT)
        texture = cv2.copyMakeBorder(grey(image)[cut], 2, 2, 2, 2, cv2.BORDER_REPLICATE)
        return resized(texture, scale), numpy.clip(cv2.GaussianBlur(resized(alpha, scale), (0, 0), 1), 0, 1)


def outline(width, height, shape, random):
    """Alpha of a leaf, a blob or a bar; its edge is soft."""
    y, x = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
    u, v = (x - width / 2) / (width / 2 - 2), (y - height / 2) / (height / 2 - 2)
    if shape == "leaf":
        inside = numpy.abs(v) < numpy.sqrt(numpy.clip(1 - numpy.abs(u) ** 1.7, 0, 1)) * (0.9 - 0.25 * u)
    elif shape == "blob":
        angle = numpy.arctan2(v, u)
        a, b, c = random.uniform(0, TAU, 3)
        edge = 0.8 + 0.1 * numpy.sin(3 * angle + a) + 0.06 * numpy.sin(5 * angle + b) + 0.04 * numpy.sin(8 * angle + c)
        inside = numpy.hypot(u, v) < edge
    else:
        inside = numpy.maximum(numpy.abs(u), numpy.abs(v)) < 1
    return cv2.GaussianBlur((inside & (numpy.abs(u) < 1)).astype(numpy.float32), (0, 0), 0.8)


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


def encoder(path, rate):
    """Its input takes frames of 4:2:0. As wind-film, it has x264's constant rate factor 23."""
    size = [f"width={WIDTH}", f"height={HEIGHT}", f"framerate={rate}/1"]
    command = ["gst-launch-1.0", "-q", "fdsrc", "!", "rawvideoparse", "format=i420", *size, "!", "x264enc", "pass=qual"]
    command += ["quantizer=23", "speed-preset=veryfast", "!", "h264parse", "!", "matroskamux", "!", "filesink"]
    return subprocess.Popen([*command, f"location={path}"], stdin=subprocess.PIPE)


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
    ground = album.ground()
    drift = random.uniform((-12, -6), (12, 6)) * random.integers(2)  # px/s: half of the grounds stand still
    points = [
        (index, texel)
        for index, texel in choose_points(things, options.kind, random)
        if is_visible(layers, index, things[index].place_of(texel, 0), 0)
    ]
    with encoder(options.film, options.rate) as process, open(options.points, "w", encoding="utf-8") as table:
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
            noise = numpy.empty_like(mean)
            cv2.randn(noise, 0, NOISE)
            luma = numpy.clip(numpy.rint(mean + noise), 16, 235).astype(numpy.uint8)
            process.stdin.write(luma.tobytes() + bytes([128]) * (WIDTH * HEIGHT // 2))
            for point, (index, texel) in enumerate(points):
                place = things[index].place_of(texel, time)
                x, y = place + 0.5  # from the corner of the first pixel, not from its centre
                visible = int(is_visible(layers, index, place, time))
                table.write(f"{number},{point},{options.kind},{x:.3f},{y:.3f},{visible}\n")
    if process.returncode:
        sys.exit("cut-outs.py: the film could not be written; see above")


if __name__ == "__main__":
    main()
