"""Cameras of the file, and pictures: pixels that are known by hand, and the same as columns."""

import json
import math
import random
import struct
import unittest
import zlib

import case_report
from patch_test import patch
from sightline_server import Server, demo_glb, with_document

# Above "six": looks down on the triangles of "right", whose slopes are y = 2 (x - left edge).
TOP = {"kind": "orthographic", "position": [3.5, 10, 0], "forward": [0, -1, 0], "up": [0, 0, -1], "extent_y": 1, "width": 3, "height": 1}


def read_png(data):
    """(width, height, rows of samples) of a PNG with 16 bits a sample, by the format's own text."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0] == zlib.crc32(kind + body)
        if kind == b"IHDR":
            size = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    width, height, bits, colour = size[:4]
    assert bits == 16 and size[6] == 0
    bytes_each = 2 * {0: 1, 2: 3}[colour]
    raw, rows, above = zlib.decompress(packed), [], bytes(width * bytes_each)
    for y in range(height):
        begin = y * (1 + width * bytes_each)
        line, row = raw[begin + 1:begin + 1 + width * bytes_each], bytearray()
        for i, byte in enumerate(line):
            left = row[i - bytes_each] if i >= bytes_each else 0
            corner = above[i - bytes_each] if i >= bytes_each else 0
            guess = left + above[i] - corner
            paeth = min((left, above[i], corner), key=lambda x: (abs(guess - x), (left, above[i], corner).index(x)))
            row.append((byte + [0, left, above[i], (left + above[i]) // 2, paeth][raw[begin]]) % 256)
        rows.append(list(struct.unpack(f">{len(row) // 2}H", row)))
        above = bytes(row)
    return width, height, rows


def read_floats(data):
    """The same of a PFM, rows from the top."""
    kind, size, scale, rest = data.split(b"\n", 3)
    width, height = map(int, size.split())
    assert scale == b"-1.0"
    each = {b"Pf": 1, b"PF": 3}[kind]
    numbers = struct.unpack(f"<{width * height * each}f", rest)
    rows = [list(numbers[y * width * each:(y + 1) * width * each]) for y in range(height)]
    return width, height, rows[::-1]


class Images(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)

        def add_cameras(document):
            document["cameras"] = [{"type": "perspective", "name": "eye", "perspective": {"yfov": math.pi / 2, "znear": 0.25}},
                                   {"type": "orthographic", "orthographic": {"xmag": 9, "ymag": 0.5, "znear": 0, "zfar": 100}},
                                   {"type": "perspective"}]
            # Both look down, turned a quarter about x; the scale must not matter.
            down = {"rotation": [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)], "scale": [2, 2, 2]}
            first = len(document["nodes"])
            document["nodes"] += [{"name": "mast", "translation": [3.5, 10, 0], "camera": 0, **down},
                                  {"name": "crane", "translation": [3.5, 10, 0], "camera": 1, **down},
                                  {"name": "broken", "camera": 2}]
            document["scenes"][0]["nodes"] += [first, first + 1, first + 2]

        put = cls.server.put("seen", with_document(demo_glb("six"), add_cameras))
        assert put.status == 201, put.body
        cls.warnings = put.json()["warnings"]

    def closest(self, scene, body, *arguments):
        return self.server.query(scene, "closest", body, *arguments)

    def image(self, scene, body, floats=False):
        kind = "image/x-portable-floatmap" if floats else "image/png"
        answer = self.closest(scene, body, *(("-H", "Accept: " + kind) if floats else ()))
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, kind), answer.body[:300])
        return (read_floats if floats else read_png)(answer.body)

    def test_visits_are_the_boxes_that_explain_lists(self):
        # Trees that are built meanwhile would change what is visited.
        server = Server("--skip", "none", "--preload", "six=demo:six", "--preload", "town=demo:town")
        self.addCleanup(server.end)
        for scene, generator in (("six", TOP), ("town", {"kind": "pinhole", "position": [90, 60, 120], "look_at": [0, 10, 0], "width": 9, "height": 7})):
            body = {"generator": generator, "image": "visits"}
            rays = server.ask("/v1/rays:generate", "-H", "Content-Type: application/json", body=json.dumps({"generator": generator})).json()
            wanted = []
            for i in range(len(rays["origins"]) // 3):
                ray = {"origin": rays["origins"][3 * i:3 * i + 3], "direction": rays["directions"][3 * i:3 * i + 3]}
                wanted.append(len(server.query(scene, "closest", {"rays": [ray], "explain": True}).json()["explain"]["boxes"]))
            rows = [wanted[k:k + generator["width"]] for k in range(0, len(wanted), generator["width"])]
            self.assertEqual(read_png(server.query(scene, "closest", body).body)[2], rows)
            self.assertEqual(read_floats(server.query(scene, "closest", body, "-H", "Accept: image/x-portable-floatmap").body)[2], rows)
        self.assertGreater(len(set(wanted)), 5)

    def test_pixels_that_are_known(self):
        # Columns at x = 2.5, 3.5 and 4.5: heights 1, 3 and 1, and so depths 9, 7 and 9.
        self.assertEqual(self.image("six", {"generator": TOP, "image": "depth"}), (3, 1, [[9000, 7000, 9000]]))
        self.assertEqual(self.image("six", {"generator": TOP, "image": "depth", "image_unit": 2}), (3, 1, [[4, 4, 4]]), "to even")
        self.assertEqual(self.image("six", {"generator": TOP, "image": "depth", "image_unit": 1e-9})[2], [[65535] * 3])
        self.assertEqual(self.image("six", {"generator": TOP, "image": "depth"}, True), (3, 1, [[9, 7, 9]]))
        self.assertEqual(self.image("six", {"generator": TOP, "image": "node"}), (3, 1, [[3, 3, 3]]))
        self.assertEqual(self.image("six", {"generator": TOP, "image": "node"}, True), (3, 1, [[2, 2, 2]]))
        # All slopes face (-2, 1, 0) / sqrt(5).
        normal = [-2 / math.sqrt(5), 1 / math.sqrt(5), 0]
        expected = [round(65535 * (n + 1) / 2) for n in normal]
        self.assertEqual(self.image("six", {"generator": TOP, "image": "normal"})[2][0][:3], expected)
        floats = self.image("six", {"generator": TOP, "image": "normal"}, True)[2][0]
        self.assertEqual(floats[:3], list(struct.unpack("<3f", struct.pack("<3f", *normal))))

    def test_rows_come_from_the_top_and_misses_are_zero(self):
        # The triangle at x = 3.5 reaches from z = -1/2 to 1/2; the middles of the rows are z = 0, 1 and 2.
        near = {**TOP, "position": [3.5, 10, 1], "extent_y": 3, "width": 1, "height": 3}
        self.assertEqual(self.image("six", {"generator": near, "image": "depth"})[2], [[7000], [0], [0]])
        self.assertEqual(self.image("six", {"generator": near, "image": "depth"}, True)[2], [[7], [math.inf], [math.inf]])
        self.assertEqual(self.image("six", {"generator": near, "image": "node"}, True)[2], [[2], [-1], [-1]])

    def test_a_picture_of_the_town_is_what_columns_say(self):
        made = random.Random(3)
        for kind in ("pinhole", "orthographic", "equirectangular"):
            generator = {"kind": kind, "position": [made.uniform(-60, 60), 30, made.uniform(-60, 60)], "look_at": [0, 8, 0],
                         "width": 40, "height": 23}
            if kind == "orthographic":
                generator["extent_y"] = 70
            answer = self.closest("town", {"generator": generator, "fields": ["t", "node_id", "normal"]}).json()
            depth = [0 if t is None else min(max(round(t / 0.01), 1), 65535) for t in answer["t"]]
            png = self.image("town", {"generator": generator, "image": "depth", "image_unit": 0.01})[2]
            self.assertEqual([value for row in png for value in row], depth)
            nodes = self.image("town", {"generator": generator, "image": "node"})[2]
            self.assertEqual([value - 1 for row in nodes for value in row], answer["node_id"])
            floats = self.image("town", {"generator": generator, "image": "normal"}, True)[2]
            expected = [struct.unpack("<f", struct.pack("<f", n or 0))[0] for n in answer["normal"]]
            self.assertEqual([value for row in floats for value in row], expected)

    def test_cameras_of_the_file(self):
        self.assertTrue(any("camera 2" in warning for warning in self.warnings), self.warnings)
        crane = {"kind": "camera", "camera": "crane", "width": 3, "height": 1}
        for camera in ("crane", 1):
            hits = self.closest("seen", {"generator": {**crane, "camera": camera}, "fields": ["t", "node_id"]}).json()
            self.assertEqual(hits["node_id"], [2, 2, 2])
            for t, expected in zip(hits["t"], [9, 7, 9]):
                self.assertAlmostEqual(t, expected, places=12)
        # A field of 90 degrees: the middle pixel of three looks straight down, where y = 3.
        for camera in ("eye", "mast", 0):
            eye = {"generator": {"kind": "camera", "camera": camera, "width": 3, "height": 3}, "fields": ["t"]}
            self.assertAlmostEqual(self.closest("seen", eye).json()["t"][4], 7, places=12)
        eye["generator"]["range"] = [0, 6]
        self.assertEqual(self.closest("seen", eye).json()["t"][4], None)
        self.assertEqual(patch(self.server, 4, {"translation": [3.5, 9, 0], "rotation": [-1, 0, 0, 1]}, scene="seen").status, 200)
        moved = self.closest("seen", {"generator": crane, "fields": ["node_id"]})
        self.assertEqual(moved.status, 200)

    def test_what_is_no_picture_is_refused(self):
        rays = {"rays": [{"origin": [0, 0, 0], "direction": [1, 0, 0]}]}
        lidar = {"kind": "lidar", "elevations": [0], "azimuths": 2}
        unknown = {"kind": "camera", "camera": "nobody", "width": 2, "height": 2}
        for body, code, pointer in [({**rays, "image": "depth"}, "IMAGE_WITHOUT_PIXELS", "/image"),
                                    ({"generator": lidar, "image": "node"}, "IMAGE_WITHOUT_PIXELS", "/image"),
                                    ({"generator": TOP, "image": "colour"}, "VALUE_UNKNOWN", "/image"),
                                    ({"generator": TOP, "image": "depth", "image_unit": 0}, "NUMBER_OUT_OF_RANGE", "/image_unit"),
                                    ({"generator": TOP, "image_unit": 1}, "KEY_MISSING", None),
                                    ({"generator": unknown}, "CAMERA_UNKNOWN", "/generator/camera")]:
            with self.subTest(body=body):
                problem = self.closest("six", body)
                self.assertEqual((problem.status, problem.json()["code"]), (422, code))
                if pointer:
                    self.assertEqual(problem.json()["errors"][0]["pointer"], pointer)
        made = self.server.ask("/v1/rays:generate", "-H", "Content-Type: application/json", body=json.dumps({"generator": unknown}))
        self.assertEqual(made.json()["code"], "CAMERA_UNKNOWN")


if __name__ == "__main__":
    case_report.main()
