#!/usr/bin/env python3
"""Draws docs/images/town-rays.png: a LiDAR scan of the demo town, computed by a server of this build.

    scripts/picture_rays.py [BINARY] [OUTPUT.png]

The picture shows the town from a camera, lit by a sun with shadows. Orange lines are the rays of a LiDAR sensor beside
the market square; dots mark their hits. All of it comes from three questions: the camera's hits (rays:closest), whether
each of them sees the sun (rays:any), and the hits of the scan. Standard library only.
"""

import math
import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "proto/python"))
from sightline import Sightline

WIDTH, HEIGHT, FOV = 1000, 560, 42.0
EYE, TARGET = (62.0, 40.0, 66.0), (0.0, 8.0, -4.0)
SENSOR = (14.0, 6.0, 17.0)
SUN = (0.55, 0.72, 0.42)
COLOURS = {"grass": (150, 172, 118), "cobbles": (188, 182, 170), "sandstone": (214, 192, 150), "slate": (96, 104, 116),
           "asphalt": (128, 130, 136), "iron": (70, 72, 78), "brick": (178, 104, 84), "roof tiles": (168, 84, 62),
           "plaster": (226, 218, 200), "timber": (140, 106, 76), "leaves": (98, 142, 78), "needles": (66, 108, 76)}


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


FORWARD = unit(sub(TARGET, EYE))
LEFT = unit(cross((0, 1, 0), FORWARD))
UP = cross(FORWARD, LEFT)
TANGENT = math.tan(math.radians(FOV) / 2)


def project(point):
    """Column, row and depth of a point: the inverse of the pinhole camera of docs/reference/generators.md."""
    at = sub(point, EYE)
    depth = dot(at, FORWARD)
    x = -dot(at, LEFT) / (depth * TANGENT * WIDTH / HEIGHT)
    y = dot(at, UP) / (depth * TANGENT)
    return (x + 1) / 2 * WIDTH, (1 - y) / 2 * HEIGHT, depth


class Picture:
    def __init__(self):
        self.rows = [[(225, 235, 245)] * WIDTH for _ in range(HEIGHT)]
        self.depth = [[math.inf] * WIDTH for _ in range(HEIGHT)]

    def blend(self, column, row, depth, colour, share):
        if 0 <= column < WIDTH and 0 <= row < HEIGHT and depth <= self.depth[row][column] + 0.15:
            old = self.rows[row][column]
            self.rows[row][column] = tuple(round(o + (c - o) * share) for o, c in zip(old, colour))

    def line(self, start, end, colour, share):
        """Depth is interpolated in the picture by its inverse, as perspective demands."""
        (c0, r0, d0), (c1, r1, d1) = project(start), project(end)
        steps = max(1, round(max(abs(c1 - c0), abs(r1 - r0))))
        for step in range(steps + 1):
            s = step / steps
            self.blend(round(c0 + (c1 - c0) * s), round(r0 + (r1 - r0) * s), 1 / (1 / d0 + (1 / d1 - 1 / d0) * s), colour, share)

    def disc(self, point, radius, colour):
        column, row, depth = project(point)
        for r in range(round(row - radius), round(row + radius) + 1):
            for c in range(round(column - radius), round(column + radius) + 1):
                if (c - column) ** 2 + (r - row) ** 2 <= radius * radius:
                    self.blend(c, r, depth, colour, 1.0)

    def png(self):
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        raw = b"".join(b"\0" + bytes(sample for pixel in row for sample in pixel) for row in self.rows)
        head = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b"")


def draw(server):
    picture = Picture()
    camera = {"kind": "pinhole", "position": EYE, "look_at": TARGET, "fov_y": FOV, "width": WIDTH, "height": HEIGHT}
    seen = server.closest("town", generator=camera, fields=["t", "position", "normal", "material"])
    flat = {name: [each for row in seen[name] for each in row] for name in ("t", "position", "normal", "material")}
    hits = [i for i, t in enumerate(flat["t"]) if not math.isinf(t)]
    # A shadow ray begins at the rounded hit point, so it starts a little on the sun's side.
    starts = [[float(p + 1e-6 * s) for p, s in zip(flat["position"][i], SUN)] for i in hits]
    shadow = server.any("town", starts, [list(SUN)] * len(starts))
    for i, dark in zip(hits, shadow):
        row, column = divmod(i, WIDTH)
        normal = flat["normal"][i]
        if dot(normal, sub(flat["position"][i], EYE)) > 0:  # The file's normal may point away from the camera.
            normal = [-x for x in normal]
        light = 0.45 + (0 if dark else 0.55 * max(0.0, dot(normal, unit(SUN))))
        depth = float(flat["t"][i])
        haze = min(0.75, depth / 700)
        picture.rows[row][column] = tuple(round(c * light * (1 - haze) + s * haze) for c, s in zip(COLOURS[flat["material"][i]], (225, 235, 245)))
        picture.depth[row][column] = depth
    scan = {"kind": "lidar", "position": SENSOR, "elevations": [-18, -10, -4, 1], "azimuths": 96, "range": [0, 60]}
    found = server.closest("town", generator=scan, fields=["t", "position"])
    points = [[float(x) for x in p] for t, p in zip(found["t"], found["position"]) if not math.isinf(t)]
    for point in points:
        picture.line(SENSOR, point, (235, 105, 10), 0.5)
    for point in points:
        picture.disc(point, 1.8, (200, 30, 30))
    picture.disc(SENSOR, 6, (20, 30, 60))
    print(f"{len(hits)} pixels with a hit, {len(points)} hits of {4 * 96} rays of the scan")
    return picture.png()


def main():
    binary = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/sightline"
    output = Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "docs/images/town-rays.png"
    process = subprocess.Popen([str(binary), "serve", "--listen", "127.0.0.1:0", "--preload", "town=demo:town"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        url = re.search(r"http://\S+", process.stdout.readline())[0]
        with Sightline(url, timeout=600) as server:
            server._ask("GET", "/v1/scenes/town?wait=60")
            output.write_bytes(draw(server))
    finally:
        process.terminate()
        process.wait()


if __name__ == "__main__":
    main()
