"""What swept spheres and boxes meet, against answers that were worked out by hand and, at random, against fractions."""

import json
import math
import random
import struct
import unittest
from fractions import Fraction

import case_report
from sightline_server import JSON_TYPE, Server

# Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, of "right" with x = 2 + 2i.
# The wall of the clock tower is the plane x = -3 between y = 0 and 24; the spire stands on it, its tip is (0, 32, 0).
BYTES = "application/octet-stream"


AXES = [[1, 1, 0], [-1, 1, 0], [0, 0, 1]]


def sweep(origin, direction, **more):
    return {"origin": origin, "direction": direction, **more}


class Sweeps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town", "--max-rays", 500)
        cls.addClassCleanup(cls.server.end)

    def ask(self, scene, kind, body, *more):
        return self.server.ask(f"/v1/scenes/{scene}/sweeps:{kind}", "-H", JSON_TYPE, *more, body=json.dumps(body))

    def closest(self, scene, *sweeps, **more):
        answer = self.ask(scene, "closest", {"sweeps": sweeps, **more})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["hits"]

    def test_a_sphere_comes_to_a_wall_a_tip_and_an_edge(self):
        fields = ["t", "distance", "position", "node"]
        wall, twice, tip, edge = self.closest(
            "town", sweep([-40, 12, 1], [1, 0, 0], radius=5), sweep([-40, 12, 1], [2, 0, 0], radius=5),
            sweep([0, 50, 0], [0, -1, 0], radius=2), sweep([3, 60, 4], [0, -1, 0], radius=13, tmax=16), fields=fields)
        self.assertEqual(wall, {"t": 32, "distance": 32, "position": [-3, 12, 1], "node": "clock tower"})
        self.assertEqual((twice["t"], twice["distance"]), (16, 32))
        self.assertEqual((tip["t"], tip["position"], tip["node"]), (16, [0, 32, 0], "spire"))
        # 3 and 4 beside the tip, 12 above it: 13.
        self.assertEqual((edge["t"], edge["position"], edge["node"]), (16, [0, 32, 0], "spire"))
        self.assertEqual(self.closest("town", sweep([3, 60, 4], [0, -1, 0], radius=13, tmax=15.999999999999998)), [None])

    def test_a_box_comes_to_a_wall_and_a_tip(self):
        wall, tip, flat = self.closest(
            "town", sweep([-40, 12, 1], [1, 0, 0], half=[2, 1, 1]), sweep([0.5, 50, 0.25], [0, -2, 0], half=[1, 2, 1]),
            sweep([0.5, 50, 0.25], [0, -2, 0], half=[0, 0, 0.25]), fields=["t", "position", "node"])
        # Of the points that the box and the wall share the one with the least y, then z.
        self.assertEqual(wall, {"t": 35, "position": [-3, 11, 0], "node": "clock tower"})
        self.assertEqual(tip, {"t": 8, "position": [0, 32, 0], "node": "spire"})
        self.assertGreater(flat["t"], 9)

    def test_capsules_and_turned_boxes_have_contact_normals(self):
        """Against the wall x = -3 and the tip (0, 32, 0)."""
        down, right = [0, -1, 0], [1, 0, 0]
        standing = {"from": [-40, 14, 1], "to": [-36, 10, 1], "direction": right, "radius": 2}
        cube = sweep([-40, 12, 1], right, half=[1, 1, 1], axes=AXES)
        asked = [sweep([3, 60, 4], down, radius=13), standing, {**standing, "tmin": 32}, cube, {**cube, "tmin": 37.5, "tmax": 40},
                 {"from": [-9, 60, 5], "to": [9, 60, 5], "direction": down, "radius": 13},
                 sweep([-40, 12, 1], right, half=[1, 1, 1], rotation=[0, 0, 0.6, 0.8])]
        ball, capsule, begun, box, within, lying, turned = self.closest("town", *asked, fields=["t", "position", "normal"])
        self.assertEqual(ball, {"t": 16, "position": [0, 32, 0], "normal": [3 / 13, 12 / 13, 4 / 13]})
        self.assertEqual(capsule, {"t": 31, "position": [-3, 10, 1], "normal": [-1, 0, 0]})
        self.assertEqual((begun["t"], begun["normal"]), (32, None))
        self.assertEqual(box, {"t": 36, "position": [-3, 12, 0], "normal": [-1, 0, 0]})
        self.assertEqual((within["t"], within["normal"]), (37.5, None))
        self.assertEqual(lying, {"t": 16, "position": [0, 32, 0], "normal": [0, 12 / 13, 5 / 13]})
        # By the formula of rotated_axes: rows 0.28 0.96 0, -0.96 0.28 0; the corner is 1.24 ahead, and 0.68 above or below.
        self.assertAlmostEqual(turned["t"], 37 - 1.24, delta=1e-13)
        self.assertEqual(turned["normal"], [-1, 0, 0])

    def test_contact_at_the_beginning_and_at_the_end(self):
        beside = sweep([-8, 12, 1], [0, 1, 0], radius=5, tmax=2)
        self.assertEqual(self.closest("town", beside, {**beside, "radius": 4.999999999999999}, {**beside, "tmin": 0.25},
                                      fields=["t", "position"]),
                         [{"t": 0, "position": [-3, 12, 1]}, None, {"t": 0.25, "position": [-3, 12.25, 1]}])
        to_wall = sweep([-40, 12, 1], [1, 0, 0], half=[2, 1, 1])
        self.assertEqual(self.ask("town", "any", {"sweeps": [{**to_wall, "tmax": 35}, {**to_wall, "tmax": 34.99999999999999},
                                                             {**to_wall, "tmin": 36, "tmax": 37}]}).json(), {"hits": [True, False, True]})

    def test_what_counts_is_chosen(self):
        left = sweep([-20, 1, 0], [1, 0, 0], radius=0.5)
        self.assertEqual([hit["node"] for hit in self.closest("six", left, fields=["node"])], ["left"])
        self.assertEqual([hit["node"] for hit in self.closest("six", left, fields=["node"], exclude={"names": ["left"]})], ["right"])
        self.assertEqual(self.ask("six", "any", {"sweeps": [left], "include": {"names": ["nobody"]}}).json()["hits"], [False])
        work = self.ask("six", "closest", {"sweeps": [left], "work": True}).json()["work"]
        self.assertGreater(work["exact"], 0)

    def test_bytes_say_the_same(self):
        rows = [([-20, 1, 0], [1, 0, 0], 0.5), ([0, 9, 0], [0, -1, 0.125], 1.25), ([0, 90, 0], [0, 1, 0], 1)]
        hits = self.closest("six", *(sweep(o, d, radius=r, tmax=30) for o, d, r in rows))

        def body(flags, columns, options=b'{"fields":["t","triangle","position"]}'):
            text = struct.pack("<4sIQII", b"SLW1", flags, len(rows), len(options), 0) + options
            text += b" " * (-len(text) % 8)
            return text + b"".join(struct.pack(f"<{len(rows)}d", *column) for column in columns)

        def columns_of(data):
            found = {}
            for i in range(struct.unpack_from("<I", data, 4)[0]):
                name, kind, width, at, count = struct.unpack_from("<16sIIQQ", data, 16 + 40 * i)
                found[name.rstrip(b"\0").decode()] = struct.unpack_from(f"<{width * count}{'?dIBQq'[kind]}", data, at)
            return found

        way = [[row[0][k] for row in rows] for k in range(3)] + [[row[1][k] for row in rows] for k in range(3)]
        ask = lambda kind, data: self.server.ask(f"/v1/scenes/six/sweeps:{kind}", "-H", f"Content-Type: {BYTES}", body=data)
        answer = ask("closest", body(1 | 4, way + [[30] * 3, [row[2] for row in rows]]))
        self.assertEqual(answer.status, 200, answer.body)
        found = columns_of(answer.body)
        self.assertEqual([None if t == math.inf else t for t in found["t"]], [hit and hit["t"] for hit in hits])
        self.assertEqual(list(found["position"][:6]), hits[0]["position"] + hits[1]["position"])
        boxes = body(1 | 8, way + [[1] * 3, [0.5] * 3, [1] * 3], b"")
        as_json = self.closest("six", *(sweep(o, d, half=[1, 0.5, 1]) for o, d, _ in rows))
        self.assertEqual([None if t == math.inf else t for t in columns_of(ask("closest", boxes).body)["t"]],
                         [hit and hit["t"] for hit in as_json])
        self.assertEqual(list(columns_of(ask("any", boxes).body)["hits"]), [int(hit is not None) for hit in as_json])
        ends = [[row[0][k] + k for row in rows] for k in range(3)]
        as_json = self.closest("six", *({"from": o, "to": [o[k] + k for k in range(3)], "direction": d, "radius": r} for o, d, r in rows),
                               fields=["t", "normal"])
        found = columns_of(ask("closest", body(1 | 16, way + [[row[2] for row in rows]] + ends, b'{"fields":["t","normal"]}')).body)
        self.assertEqual([None if t == math.inf else t for t in found["t"]], [hit and hit["t"] for hit in as_json])
        self.assertEqual(list(found["normal"][:6]), as_json[0]["normal"] + as_json[1]["normal"])
        as_json = self.closest("six", *(sweep(o, d, half=[1, 0.5, 1], axes=AXES) for o, d, _ in rows))
        turned = body(1 | 8 | 16, way + [[1] * 3, [0.5] * 3, [1] * 3] + [[x] * 3 for axis in AXES for x in axis], b"")
        self.assertEqual([None if t == math.inf else t for t in columns_of(ask("closest", turned).body)["t"]],
                         [hit and hit["t"] for hit in as_json])
        self.assertEqual(ask("any", body(1, way + [[1, -1, 1]], b"")).json()["errors"][0]["pointer"], "/sweeps/1/radius")
        self.assertEqual(ask("any", body(16 | 1, way + [[1] * 3], b"")).json()["code"], "BINARY_MALFORMED")

    def test_a_wrong_request_is_answered_with_its_place(self):
        good = sweep([0, 0, 0], [1, 0, 0], radius=1)
        box = lambda **more: sweep([0, 0, 0], [1, 0, 0], half=[1, 1, 1], **more)
        for row, code, pointer in [({**good, "radius": -1}, "SWEEP_SIZE_NEGATIVE", "/sweeps/1/radius"),
                                   ({**good, "half": [1, 1, 1]}, "KEYS_MIXED", "/sweeps/1"),
                                   (sweep([0, 0, 0], [1, 0, 0]), "KEY_MISSING", "/sweeps/1"),
                                   ({"from": [0, 0, 0], "direction": [1, 0, 0], "radius": 1}, "KEY_MISSING", "/sweeps/1"),
                                   ({**good, "to": [1, 0, 0]}, "KEYS_MIXED", "/sweeps/1"),
                                   ({**good, "axes": AXES}, "KEYS_MIXED", "/sweeps/1"),
                                   (box(rotation=[0, 0, 0, 1], axes=AXES), "KEYS_MIXED", "/sweeps/1"),
                                   (box(rotation=[0, 0, 0, 2]), "BOX_ROTATION_NOT_UNIT", "/sweeps/1/rotation"),
                                   (box(axes=[[1, 0, 0], [0, 1, 0], [1, 1, 0]]), "BOX_AXES_DEPENDENT", "/sweeps/1/axes"),
                                   (box(axes=[[1, 0, 0], [0, 0, 0], [1, 1, 0]]), "BOX_AXIS_ZERO", "/sweeps/1/axes/1"),
                                   (box(axes=[[1, 0, 0], [0, 1, 0]]), "LENGTH_WRONG", "/sweeps/1/axes"),
                                   (sweep([0, 0, 0], [1, 0, 0], half=[1, -1, 1]), "SWEEP_SIZE_NEGATIVE", "/sweeps/1/half/1"),
                                   (sweep([0, 0, 0], [1, 0, 0], half=[1, 1]), "LENGTH_WRONG", "/sweeps/1/half"),
                                   (sweep([0, 0, 0], [0, 0, 0], radius=1), "RAY_DIRECTION_ZERO", "/sweeps/1/direction"),
                                   ({**good, "tmin": 2, "tmax": 1}, "RAY_LIMITS_REVERSED", "/sweeps/1/tmin"),
                                   ({**good, "colour": 1}, "KEY_UNKNOWN", "/sweeps/1/colour"), (7, "TYPE_WRONG", "/sweeps/1")]:
            with self.subTest(row=row):
                answer = self.ask("six", "any", {"sweeps": [good, row]})
                self.assertEqual((answer.status, answer.json()["code"]), (422, code))
                self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)
        for body, status, code in [({}, 422, "KEY_MISSING"), ({"sweeps": [good] * 501}, 413, "SWEEPS_TOO_MANY"),
                                   ({"sweeps": [good], "fields": ["uv"]}, 422, "FIELD_UNKNOWN"),
                                   ({"sweeps": [good], "cull": "back"}, 422, "KEY_UNKNOWN")]:
            answer = self.ask("six", "closest", body)
            self.assertEqual((answer.status, answer.json()["code"]), (status, code))
        self.assertEqual(self.ask("none", "any", {"sweeps": []}).status, 404)

    def test_boxes_meet_what_fractions_say(self):
        """Swept along x past "left" and "right": in the plane z of its sides a box of half z is a slab, and the triangles are prisms."""
        seed, rng = 181, random.Random(181)
        sweeps, expected = [], []
        for _ in range(200):
            # A triangle's section at height y is the segment |z| <= 2 - y / 2 at X = x + y / 2, so a box of half extents h at (X, y, z)
            # going along +x with |z| - h_z <= 2 - low / 2 is met first at the least height that it has in common: low = max(0, y - h_y).
            y, z, h = rng.randint(-8, 40) / 8, rng.randint(-24, 24) / 8, [rng.randint(0, 16) / 8 for _ in range(3)]
            low, high = max(Fraction(0), Fraction(y) - Fraction(h[1])), min(Fraction(4), Fraction(y) + Fraction(h[1]))
            sweeps.append(sweep([-50, y, z], [1, 0, 0], half=h))
            width = 2 - low / 2
            is_met = low <= high and Fraction(abs(z)) - Fraction(h[2]) <= width
            expected.append(float(-6 + low / 2 - Fraction(h[0]) + 50) if is_met else None)
        hits = self.closest("six", *sweeps, fields=["t", "triangle"])
        print(f"seed {seed}, met {sum(t is not None for t in expected)} of {len(expected)}")
        self.assertEqual([hit and hit["t"] for hit in hits], expected)
        self.assertEqual({hit["triangle"] for hit in hits if hit}, {0})


if __name__ == "__main__":
    case_report.main()
