"""How far the scene is from points, against answers that were worked out by hand and, at random, against fractions."""

import json
import math
import random
import struct
import unittest
from fractions import Fraction

import case_report
from sightline_server import Server

# Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, of "right" with x = 2 + 2i. Their planes
# are 2 (X - x) = Y: a step of (2,-1,0) from each leads straight away from them.
BYTES = "application/octet-stream"
# The walls of the clock tower are |x| <= 3, |z| <= 3, its top is at 24, its ledge from 18 to 18.5.
TOWER = {"include": {"names": ["clock tower", "spire"]}}


def triangles():
    for instance, begin in ((0, -6), (1, 2)):
        for i in range(3):
            x = begin + 2 * i
            yield (instance, i), [[Fraction(c) for c in corner] for corner in ((x, 0, 2), (x + 2, 4, 0), (x, 0, -2))]


def square_distance(p, corners):
    """The least of: corners, feet on edges that lie between their ends, the foot on the plane if it is inside."""
    def minus(a, b):
        return [x - y for x, y in zip(a, b)]

    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))

    best = min(dot(minus(p, c), minus(p, c)) for c in corners)
    for a, b in zip(corners, corners[1:] + corners[:1]):
        e = minus(b, a)
        s = dot(minus(p, a), e) / dot(e, e)
        if 0 < s < 1:
            away = minus(minus(p, a), [s * x for x in e])
            best = min(best, dot(away, away))
    ab, ac, ap = minus(corners[1], corners[0]), minus(corners[2], corners[0]), minus(p, corners[0])
    d = dot(ab, ab) * dot(ac, ac) - dot(ab, ac) ** 2
    u = (dot(ap, ab) * dot(ac, ac) - dot(ap, ac) * dot(ab, ac)) / d
    v = (dot(ap, ac) * dot(ab, ab) - dot(ap, ab) * dot(ab, ac)) / d
    if u > 0 and v > 0 and u + v < 1:
        away = [x - u * y - v * z for x, y, z in zip(ap, ab, ac)]
        best = min(best, dot(away, away))
    return best


def is_rounded_root(x, square):
    low, high = (Fraction(x) + Fraction(math.nextafter(x, to)) for to in (0, math.inf))
    return low * low <= 4 * square <= high * high


def packed(points, **options):
    text = json.dumps(options).encode() if options else b""
    head = struct.pack("<4sIQII", b"SLP1", 1, len(points), len(text), 0) + text
    return head + bytes(-len(head) % 8) + b"".join(struct.pack(f"<{len(points)}d", *(p[k] for p in points)) for k in range(3))


def unpacked(body):
    magic, count = struct.unpack_from("<4sI", body)
    assert magic == b"SLA1"
    columns = {}
    for i in range(count):
        name, kind, width, at, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        columns[name.rstrip(b"\0").decode()] = list(struct.unpack_from(f"<{rows * width}{' dIBQq'[kind]}", body, at))
    return columns


class Points(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)

    def send(self, scene, what, *points, **options):
        return self.server.ask(f"/v1/scenes/{scene}/points:{what}", "-H", "Content-Type: application/json",
                               body=json.dumps({"points": list(points), **options}))

    def ask(self, scene, what, *points, **options):
        answer = self.send(scene, what, *points, **options)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def ask_bytes(self, scene, what, points, **options):
        answer = self.server.ask(f"/v1/scenes/{scene}/points:{what}", "-H", f"Content-Type: {BYTES}", body=packed(points, **options))
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, BYTES), answer.body)
        return answer, unpacked(answer.body)

    def test_the_closest_point(self):
        # (-5,2,0) lies on left's triangle 0, for 2 (-5 + 6) = 2, and (-7,3,0) is one step from it.
        hits = self.ask("six", "closest", [-7, 3, 0], [-6, -5, 12], [-5, 2, 0], [100, 0, 0], max_distance=13,
                        fields=["distance", "position", "triangle", "node", "front", "on_edge", "barycentrics"])["hits"]
        self.assertEqual(hits[0], {"distance": math.sqrt(5), "triangle": 0, "position": [-5, 2, 0], "barycentrics": [0.5, 0.25],
                                   "front": True, "on_edge": False, "node": "left"})
        # From the corner (-6,0,2) it is (0,-5,10) away: more than 11 but less than 13.
        self.assertEqual((hits[1]["distance"], hits[1]["position"], hits[1]["on_edge"]), (math.sqrt(125), [-6, 0, 2], True))
        self.assertEqual((hits[2]["distance"], hits[2]["front"]), (0, False))
        self.assertIsNone(hits[3])

    def test_max_distance_is_closed(self):
        for most, there in ((5, True), (math.nextafter(5, 0), False)):
            hits = self.ask("six", "closest", [-6, -3, 6], max_distance=most, fields=["distance"])["hits"]
            self.assertEqual(hits[0], {"distance": 5} if there else None)

    def test_the_nearest_triangles_stand_in_order(self):
        # (1,2,0) is 0.8 steps from (2.6,1.2,0) on right's triangle 0 and as many from (-0.6,2.8,0) on left's triangle 2: the
        # smaller id comes first.
        results = self.ask("six", "nearest", [1, 2, 0], [1, 50, 0], count=2, fields=["distance", "instance", "triangle"])["results"]
        first, second = results[0]["hits"]
        self.assertTrue(is_rounded_root(first["distance"], Fraction(16, 5)))
        self.assertEqual((first["instance"], first["triangle"]), (0, 2))
        self.assertEqual(second, {**first, "instance": 1, "triangle": 0})
        self.assertEqual(len(results[1]["hits"]), 2)
        self.assertEqual(len(self.ask("six", "nearest", [0, 0, 0], count=10)["results"][0]["hits"]), 6)

    def test_signed_distances_of_a_building(self):
        answer = self.ask("town", "distance", [0, 10, 0.5], [-3, 12, 1], [-7, 9, 0], [0, 34, 0], **TOWER)
        self.assertEqual(answer["distance"], [-2.5, 0, 4, 2])
        self.assertEqual((answer["method"], answer["reliable"]), ("parity", [True] * 4))
        self.assertNotIn("unreliable", answer)
        winding = self.ask("town", "distance", [0.5, 18.25, 1], method="winding", **TOWER)
        self.assertEqual((winding["distance"], winding["winding"]), ([-0.25], [2]))
        self.assertEqual(self.ask("town", "distance", [-7, 9, 0], max_distance=3, **TOWER)["distance"], [None])

    def test_open_edges_make_it_unreliable(self):
        # Six triangles that share no edge: 18 open ones.
        for what in ("distance", "inside"):
            answer = self.ask("six", what, [0, 50, 0])
            self.assertEqual(answer["unreliable"], {"reason": "OPEN_EDGES", "open_edges": 18})
        answer, columns = self.ask_bytes("six", "distance", [(-5, 2, 0)])
        self.assertEqual(json.loads(answer.headers["x-sightline-unreliable"])["open_edges"], 18)
        self.assertEqual(columns["distance"], [0])

    def test_random_points_agree_with_fractions(self):
        print("seed 85")
        source = random.Random(85)
        points = [[source.choice([source.randint(-10, 10), source.uniform(-10, 10)]) for _ in range(3)] for _ in range(200)]
        rows = self.ask("six", "nearest", *points, count=6, fields=["distance", "instance", "triangle"])["results"]
        closest = self.ask("six", "closest", *points, fields=["distance", "triangle", "instance"])["hits"]
        _, columns = self.ask_bytes("six", "nearest", points, count=6)
        all_triangles = list(triangles())
        for i, point in enumerate(points):
            exact = sorted((square_distance([Fraction(x) for x in point], corners), name) for name, corners in all_triangles)
            hits = rows[i]["hits"]
            self.assertEqual([(hit["instance"], hit["triangle"]) for hit in hits], [name for _, name in exact])
            for hit, (square, _) in zip(hits, exact):
                self.assertTrue(is_rounded_root(hit["distance"], square), (point, hit, float(square)))
            self.assertEqual(closest[i], hits[0])
        self.assertEqual(columns["first"], list(range(0, 1201, 6)))
        self.assertEqual(columns["distance"], [hit["distance"] for row in rows for hit in row["hits"]])
        self.assertEqual(columns["triangle"], [hit["triangle"] for row in rows for hit in row["hits"]])

    def test_bytes_say_the_same(self):
        points = [(-7, 3, 0), (0, 10, 0.5), (-3, 12, 1), (500, 500, 500)]
        for what, options in (("closest", {"max_distance": 400, "fields": ["distance", "position", "node_id"]}),
                              ("distance", {**TOWER, "method": "winding"}), ("inside", TOWER)):
            text = self.ask("town", what, *points, **options)
            _, columns = self.ask_bytes("town", what, points, **options)
            accepted = self.server.ask(f"/v1/scenes/town/points:{what}", "-H", "Content-Type: application/json", "-H", f"Accept: {BYTES}",
                                       body=json.dumps({"points": points, **options}))
            self.assertEqual(unpacked(accepted.body).keys(), columns.keys())
            with self.subTest(what=what):
                if what == "closest":
                    self.assertEqual(columns["distance"], [hit["distance"] if hit else math.inf for hit in text["hits"]])
                    self.assertEqual(columns["position"][:3], text["hits"][0]["position"])
                elif what == "distance":
                    self.assertEqual((columns["distance"], columns["winding"]), (text["distance"], text["winding"]))
                else:
                    self.assertEqual(columns["inside"], [255 if x is None else int(x) for x in text["inside"]])

    def test_work_filters_and_no_points(self):
        self.assertEqual(self.ask("six", "closest")["hits"], [])
        self.assertEqual(self.ask("six", "nearest", count=3)["results"], [])
        answer = self.ask("six", "closest", [-7, 3, 0], work=True, exclude={"names": ["left"]}, fields=["node"])
        self.assertEqual(answer["hits"], [{"node": "right"}])
        self.assertGreater(answer["work"]["blocks"], 0)
        self.assertEqual(self.ask("six", "closest", [0, 0, 0], include={"names": ["nobody"]})["hits"], [None])

    def test_faults_are_named(self):
        for what, body, code, pointer in [("closest", {"max_distance": -1}, "DISTANCE_NEGATIVE", "/max_distance"),
                                          ("closest", {"count": 2}, "KEY_UNKNOWN", "/count"),
                                          ("closest", {"fields": ["t"]}, "FIELD_UNKNOWN", "/fields/0"),
                                          ("nearest", {"count": 0}, "COUNT_ZERO", "/count"),
                                          ("nearest", {"count": 1001}, "NUMBER_OUT_OF_RANGE", "/count"),
                                          ("distance", {"method": "luck"}, "VALUE_UNKNOWN", "/method"),
                                          ("distance", {"fields": ["node"]}, "KEY_UNKNOWN", "/fields")]:
            with self.subTest(what=what, body=body):
                answer = self.send("six", what, [0, 0, 0], **body)
                self.assertEqual((answer.status, answer.json()["code"], answer.json()["errors"][0]["pointer"]), (422, code, pointer))
        for body, code in [(packed([(0, 0, math.nan)]), "POINT_NOT_FINITE"), (packed([(0, 0, 0)])[:-1], "BINARY_MALFORMED"),
                           (b"SLR1" + packed([])[4:], "BINARY_MALFORMED"), (packed([], fields=["node"]), "FIELD_IS_TEXT")]:
            answer = self.server.ask("/v1/scenes/six/points:closest", "-H", f"Content-Type: {BYTES}", body=body)
            self.assertEqual(answer.json()["code"], code)


if __name__ == "__main__":
    case_report.main()
