# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cut-outs of photographs that sway, turn and bend, for films whose motion is known.

The photographs are those of the Debian packages opencv-doc, python3-skimage and mate-backgrounds. Whoever imports this
ends with status 77 if a package is missing.
"""
import glob
import subprocess
import sys

try:
    import cv2
    import numpy
except ImportError:
    print("SKIPPED: Python has no OpenCV (package python3-opencv)")
    sys.exit(77)

SHUTTER = 0.5  # of the frame interval
NOISE = 1.5  # grey levels
TAU = 2 * numpy.pi

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
        return numpy.tensordot(pose[:, :2], rigid, 1) + pose[:, 2].reshape(2, *[1] * (rigid.ndim - 1))

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
        right, bottom = numpy.minimum(corners.max(axis=1) + margin, frame.shape[::-1]).astype(int)
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

    def ground(self, width, height):
        """A whole photograph that is at least so large."""
        image = grey(photograph(self.grounds[self.random.integers(len(self.grounds))] if self.grounds else GROUNDS))
        return resized(image, max(width / image.shape[1], height / image.shape[0]))

    def face(self, least=300, most=550):
        """Texture and alpha of a face or a figure, with a height in px between both."""
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
        scale = self.random.uniform(least, most) / height
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


def encoder(path, width, height, rate, quality=23):
    """Its input takes frames of 4:2:0. The quality is x264's constant rate factor; 23 is that of wind-film."""
    size = [f"width={width}", f"height={height}", f"framerate={rate}/1"]
    command = ["gst-launch-1.0", "-q", "fdsrc", "!", "rawvideoparse", "format=i420", *size, "!", "x264enc", "pass=qual"]
    command += [f"quantizer={quality}", "speed-preset=veryfast", "!", "h264parse", "!", "matroskamux", "!", "filesink"]
    return subprocess.Popen([*command, f"location={path}"], stdin=subprocess.PIPE)


def with_noise(mean):
    """What a camera of 8 bits makes of a picture in grey levels."""
    noise = numpy.empty_like(mean)
    cv2.randn(noise, 0, NOISE)
    return numpy.clip(numpy.rint(mean + noise), 16, 235).astype(numpy.uint8)
