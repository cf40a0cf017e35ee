"""Rays and hits as bytes, read and written here by docs/reference/binary.md and by nothing else."""

import json
import math
import random
import struct

import case_report
from two_scenes import TwoScenes

BINARY = "Content-Type: application/octet-stream"
TYPES = {1: ("d", 8), 2: ("I", 4), 3: ("B", 1), 4: ("Q", 8)}
NONE = 0xFFFFFFFF

# See rays_test.py.
RAYS = [([-10, 1, 0], [1, 0, 0]), ([1, 10, 0], [0, -1, 0]), ([3, 10, 0], [0, -1, 0])]


def pack(rays, options=None, letter="d", tmin=None, tmax=None):
    text = json.dumps(options).encode() if options is not None else b""
    flags = (letter == "d") | 2 * (tmin is not None) | 4 * (tmax is not None)
    head = struct.pack("<4sIQII", b"SLR1", flags, len(rays), len(text), 0) + text
    head += bytes(-len(head) % 8)
    columns = [[o[k] for o, _ in rays] for k in range(3)] + [[d[k] for _, d in rays] for k in range(3)]
    columns += [column for column in (tmin, tmax) if column is not None]
    return head + b"".join(struct.pack(f"<{len(rays)}{letter}", *column) for column in columns)


def unpack(body):
    magic, count, zero = struct.unpack_from("<4sIQ", body)
    assert magic == b"SLA1" and zero == 0, body[:16]
    columns = {}
    for i in range(count):
        name, kind, width, at, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        letter, size = TYPES[kind]
        assert at % 8 == 0 and at + rows * width * size <= len(body)
        numbers = struct.unpack_from(f"<{rows * width}{letter}", body, at)
        columns[name.rstrip(b"\0").decode()] = [numbers[j:j + width] for j in range(0, len(numbers), width)] if width > 1 else list(numbers)
    return columns


class Binary(TwoScenes):
    def send(self, scene, kind, body):
        return self.server.ask(f"/v1/scenes/{scene}/rays:{kind}", "-H", BINARY, body=body)

    def ask(self, scene, kind, rays, *arguments, **options):
        answer = self.send(scene, kind, pack(rays, *arguments, **options))
        self.assertEqual(answer.status, 200, answer.body)
        self.assertEqual(answer.headers["content-type"], "application/octet-stream")
        return unpack(answer.body)

    def test_every_kind(self):
        closest = self.ask("six", "closest", RAYS)
        self.assertEqual(closest, {"t": [4.5, math.inf, 8], "instance": [0, NONE, 1], "primitive": [0, NONE, 0],
                                   "triangle": [0, NONE, 0]})
        self.assertEqual(self.ask("six", "any", RAYS), {"hits": [1, 0, 1]})
        self.assertEqual(self.ask("six", "count", RAYS), {"counts": [6, 0, 1]})
        lists = self.ask("six", "all", RAYS, {"fields": ["t"], "max_hits": 2})
        self.assertEqual(lists, {"totals": [6, 0, 1], "first": [0, 2, 2, 3], "t": [4.5, 6.5, 8]})

    def test_limits_and_both_sizes_of_numbers(self):
        for letter in "fd":
            with self.subTest(letter=letter):
                limits = {"tmin": [0, 0, -1], "tmax": [4.25, math.inf, 8]}
                self.assertEqual(self.ask("six", "closest", RAYS, {"fields": ["t"]}, letter, **limits),
                                 {"t": [math.inf, math.inf, 8]})
                self.assertEqual(self.ask("six", "any", RAYS, None, letter, tmax=[4.5, 1, 1]), {"hits": [1, 0, 0]})

    def test_every_field_is_what_json_says(self):
        random.seed(5)
        rays = [([random.uniform(-300, 300), 60, random.uniform(-300, 300)],
                 [random.uniform(-1, 1), -random.random(), random.uniform(-1, 1)]) for _ in range(2000)]
        fields = ["t", "distance", "instance", "primitive", "triangle", "position", "normal", "barycentrics", "front",
                  "on_edge", "node_id", "mesh_id", "material_id"]
        for options in ({}, {"cull": "back", "normalize": True}):
            with self.subTest(options=options):
                binary = self.ask("town", "closest", rays, {"fields": fields, **options})
                body = {"rays": [{"origin": o, "direction": d} for o, d in rays], "fields": fields, **options}
                rows = self.server.query("town", "closest", body).json()["hits"]
                self.assertEqual(sorted(binary), sorted(fields))
                self.assertGreater(sum(row is not None for row in rows), 500)
                for i, row in enumerate(rows):
                    if row is None:
                        self.assertEqual((binary["t"][i], binary["instance"][i], binary["front"][i]), (math.inf, NONE, 255))
                        self.assertTrue(math.isnan(binary["position"][i][0]))
                        continue
                    got = {field: binary[field][i] for field in fields}
                    for field, value in got.items():
                        if isinstance(row[field], list):
                            value = list(value)
                        self.assertEqual(NONE if row[field] is None else row[field], value)

    def test_bad_rays_are_refused_or_marked(self):
        bad = [([-10, 1, 0], [1, 0, 0]), ([0, math.nan, 0], [1, 0, 0]), ([0, 0, 0], [0, -0.0, 0]), RAYS[2], RAYS[0]]
        tmin, tmax = [0, 0, 0, math.nan, 5], [9] * 3 + [9, 4]
        answer = self.send("six", "closest", pack(bad))
        self.assertEqual((answer.status, answer.json()["code"]), (422, "RAY_NOT_FINITE"))
        self.assertEqual(answer.json()["errors"][0]["pointer"], "/rays/1/origin")
        marked = self.ask("six", "closest", bad, {"on_invalid": "mark", "fields": ["t"]}, tmin=tmin, tmax=tmax)
        self.assertEqual(marked, {"t": [4.5] + [math.inf] * 4, "invalid": [0, 1, 2, 3, 4]})
        self.assertEqual(self.ask("six", "any", bad, {"on_invalid": "mark"}, tmin=tmin, tmax=tmax),
                         {"hits": [1, 0, 0, 0, 0], "invalid": [0, 1, 2, 3, 4]})

    def test_json_marks_them_too(self):
        rays = [{"origin": [-10, 1, 0], "direction": [1, 0, 0]}, {"origin": [0, 0, 0], "direction": [0, 0, 0]},
                {"origin": [-10, 1, 0], "direction": [1, 0, 0], "tmin": 5, "tmax": 4}]
        invalid = [{"ray": 1, "code": "RAY_DIRECTION_ZERO"}, {"ray": 2, "code": "RAY_LIMITS_REVERSED"}]
        body = {"rays": rays, "on_invalid": "mark"}
        self.assertEqual(self.server.query("six", "closest", {**body, "fields": ["t"]}).json(),
                         {"hits": [{"t": 4.5}, None, None], "invalid": invalid})
        self.assertEqual(self.server.query("six", "any", body).json(), {"hits": [True, False, False], "invalid": invalid})
        self.assertEqual(self.server.query("six", "count", body).json(), {"counts": [6, 0, 0], "invalid": invalid})
        results = self.server.query("six", "all", {**body, "fields": ["t"], "max_hits": 1}).json()
        self.assertEqual(results, {"results": [{"total": 6, "hits": [{"t": 4.5}]}] + [{"total": 0, "hits": []}] * 2,
                                   "invalid": invalid})
        good = {"rays": rays[:1], "on_invalid": "mark"}
        self.assertEqual(self.server.query("six", "any", good).json(), {"hits": [True], "invalid": []})
        self.assertEqual(self.server.query("six", "any", {**body, "on_invalid": "refuse"}).status, 422)

    def test_work_is_told_on_request(self):
        rays = {"rays": [{"origin": o, "direction": d} for o, d in RAYS], "work": True}
        for kind in ("closest", "any", "all", "count"):
            with self.subTest(kind=kind):
                work = self.server.query("six", kind, rays).json()["work"]
                self.assertGreater(work["blocks"], 0)
                self.assertEqual(sorted(work["microseconds"]), ["describe", "parse", "print", "trace"])
                answer = self.send("six", kind, pack(RAYS, {"work": True}))
                self.assertGreater(json.loads(answer.headers["x-sightline-work"])["blocks"], 0)

    def test_no_rays(self):
        self.assertEqual(self.ask("six", "any", []), {"hits": []})
        self.assertEqual(self.ask("six", "all", [], {"fields": ["t"]}), {"totals": [], "first": [0], "t": []})

    def test_whatever_is_not_as_announced_is_refused(self):
        good = pack(RAYS, {"fields": ["t"]})
        self.assertEqual(self.send("six", "closest", good).status, 200)

        def refused(body, status=400, code="BINARY_MALFORMED"):
            answer = self.send("six", "closest", body)
            self.assertEqual((answer.status, answer.json()["code"]), (status, code), body[:40])

        for length in [*range(0, 24), len(good) - 1, len(good) - 8]:
            refused(good[:length])
        refused(good + bytes(8))
        refused(b"SLR2" + good[4:])
        refused(good[:4] + struct.pack("<I", 9) + good[8:])
        refused(good[:20] + b"\1" + good[21:])
        refused(good[:8] + struct.pack("<Q", 4) + good[16:])
        refused(good[:8] + struct.pack("<Q", 2**61) + good[16:], 413, "RAYS_TOO_MANY")
        refused(good[:16] + struct.pack("<I", 2**32 - 1) + good[20:])
        refused(pack(RAYS, {"fields": ["node"]}), 422, "FIELD_IS_TEXT")
        refused(pack(RAYS, {"rays": []}), 422, "KEY_UNKNOWN")
        refused(pack(RAYS, {"max_hits": 1}), 422, "KEY_UNKNOWN")
        refused(pack(RAYS, ["fields"]), 422, "TYPE_WRONG")


if __name__ == "__main__":
    case_report.main()
