"""Rays that the server makes: by hand, by the formulas of docs/reference/generators.md, and sent back as rays."""

import json
import math
import struct

import case_report
from binary_test import unpack
from two_scenes import TwoScenes

BINARY = "Content-Type: application/octet-stream"
ALL = [{"kind": "pinhole", "position": [120, 40, 120], "look_at": [0, 10, 0], "fov_y": 45, "width": 40, "height": 30},
       {"kind": "orthographic", "position": [0, 300, 0], "forward": [0, -1, 0], "up": [0, 0, -1], "extent_y": 400, "width": 40,
        "height": 40},
       {"kind": "equirectangular", "position": [30, 20, 30], "width": 60, "height": 30, "range": [0, 500]},
       {"kind": "lidar", "poses": [{"position": [30, 2, 30]}, {"position": [40, 2, 30], "look_at": [0, 2, 0]}],
        "elevations": [-20, -10, 0, 10], "azimuths": 90, "range": [0.5, 120]},
       {"kind": "hemisphere", "points": [[3, 0.5, 5], [20, 60, 20]], "normals": [[0, 1, 0], [1, 2, 3]], "count": 300, "seed": 7},
       {"kind": "hemisphere", "points": [[3, 0.5, 5]], "normals": [[0, 1, 0]], "count": 300, "distribution": "uniform",
        "range": [0, None]}]


class Generators(TwoScenes):
    def send(self, body, *arguments):
        return self.server.ask("/v1/rays:generate", "-H", "Content-Type: application/json", *arguments, body=json.dumps(body))

    def make(self, **generator):
        answer = self.send({"generator": generator})
        self.assertEqual(answer.status, 200, answer.body)
        rays = answer.json()
        triples = [[numbers[i:i + 3] for i in range(0, len(numbers), 3)] for numbers in (rays["origins"], rays["directions"])]
        return list(zip(*triples))

    def test_a_pinhole_of_four_pixels(self):
        half = 0.5  # tan 45 at the middles of 2 x 2 pixels; an angle of 90 is exact
        rays = self.make(kind="pinhole", fov_y=90, width=2, height=2)
        for (origin, direction), expected in zip(rays, [(-half, half, -1), (half, half, -1), (-half, -half, -1), (half, -half, -1)]):
            self.assertEqual(origin, [0, 0, 0])
            for got, exact in zip(direction, expected):
                self.assertAlmostEqual(got, exact, delta=4e-16)

    def test_parallel_rays_stand_on_a_grid(self):
        rays = self.make(kind="orthographic", position=[1, 2, 3], extent_y=4, width=4, height=2)
        self.assertEqual([o for o, _ in rays], [[x, y, 3] for y in (3, 1) for x in (-2, 0, 2, 4)])
        self.assertEqual({tuple(d) for _, d in rays}, {(0, 0, -1)})

    def test_a_scanner_turns_to_the_left(self):
        rays = self.make(kind="lidar", position=[1, 1, 1], elevations=[0, 90], azimuths=4)
        flat = [d for _, d in rays[::2]]
        self.assertEqual(flat, [[0, 0, -1], [-1, 0, 0], [0, 0, 1], [1, 0, 0]])
        self.assertEqual([d for _, d in rays[1::2]], [[0, 1, 0]] * 4)

    def test_a_panorama_looks_forward_in_its_middle(self):
        rays = self.make(kind="equirectangular", width=8, height=4)
        for i, (_, d) in enumerate(rays):
            azimuth, elevation = math.pi * (1 - 2 * (i % 8 + 0.5) / 8), math.pi / 2 * (1 - 2 * (i // 8 + 0.5) / 4)
            expected = [-math.cos(elevation) * math.sin(azimuth), math.sin(elevation), -math.cos(elevation) * math.cos(azimuth)]
            for got, exact in zip(d, expected):
                self.assertAlmostEqual(got, exact, delta=4e-16)

    def test_a_hemisphere_is_seeded_and_distributed_as_told(self):
        base = {"kind": "hemisphere", "points": [[0, 0, 0]], "normals": [[0, 0, 5]], "count": 20000}
        for distribution, mean in [("cosine", 2 / 3), ("uniform", 1 / 2)]:
            rays = self.make(**base, distribution=distribution, seed=3)
            self.assertEqual(rays, self.make(**base, distribution=distribution, seed=3))
            self.assertNotEqual(rays[0], self.make(**base, distribution=distribution, seed=4)[0])
            self.assertTrue(all(d[2] >= 0 for _, d in rays))
            self.assertTrue(all(abs(math.hypot(*d) - 1) < 1e-15 for _, d in rays))
            self.assertAlmostEqual(sum(d[2] for _, d in rays) / len(rays), mean, delta=0.01)
            self.assertAlmostEqual(sum(d[0] for _, d in rays) / len(rays), 0, delta=0.02)

    def test_answers_are_those_of_the_same_rays_sent(self):
        for generator in ALL:
            with self.subTest(generator=generator["kind"]):
                rays = self.send({"generator": generator}).body
                for kind, options in [("closest", {"fields": ["t", "triangle", "node"]}), ("any", {}), ("count", {"cull": "back"}),
                                      ("all", {"fields": ["t"], "max_hits": 3})]:
                    made = self.server.query("town", kind, {"generator": generator, **options})
                    self.assertEqual(made.status, 200, made.body)
                    sent = self.server.query("town", kind, {**json.loads(rays), **options})
                    self.assertEqual(made.body, sent.body)
                self.assertIn(b"true", self.server.query("town", "any", {"generator": generator}).body)

    def test_returns_of_a_scanner_are_the_first_of_all_hits(self):
        # By hand: through the six triangles at x = -5.5, -3.5, -1.5, 2.5, 4.5, 6.5, and back from x = -10, where nothing is.
        lidar = {"kind": "lidar", "position": [-10, 1, 0], "forward": [1, 0, 0], "elevations": [0], "azimuths": 2, "returns": 4}
        answer = self.server.query("six", "closest", {"generator": lidar, "fields": ["t", "node", "triangle", "position"]}).json()
        self.assertEqual(answer["t"], [4.5, 6.5, 8.5, 12.5] + [None] * 4)
        self.assertEqual(answer["node"], ["left"] * 3 + ["right"] + [None] * 4)
        self.assertEqual(answer["triangle"], [0, 1, 2, 0] + [-1] * 4)
        self.assertEqual(answer["position"][:6], [-5.5, 1, 0, -3.5, 1, 0])
        scan = {"kind": "lidar", "position": [60, 12, 70], "elevations": [-20, -5, 0, 9], "azimuths": 300, "range": [1, 400]}
        fields = ["t", "instance", "triangle", "position", "distance"]
        lists = self.server.query("town", "all", {"generator": scan, "fields": fields, "max_hits": 3, "cull": "back"}).json()
        for returns in (1, 2, 3):
            body = {"generator": {**scan, "returns": returns}, "fields": fields, "cull": "back"}
            rows = self.server.query("town", "closest", body).json()
            for ray, (begin, end) in enumerate(zip(lists["first"], lists["first"][1:])):
                for k in range(returns):
                    got = [rows[field][ray * returns + k] for field in ("t", "instance", "triangle", "distance")]
                    got += rows["position"][3 * (ray * returns + k):][:3]
                    at = begin + k
                    expected = [lists[field][at] for field in ("t", "instance", "triangle", "distance")] + lists["position"][3 * at:3 * at + 3] \
                        if at < end else [None, -1, -1, None] + [None] * 3
                    self.assertEqual(got, expected)
            binary = unpack(self.server.query("town", "closest", body, "-H", "Accept: application/octet-stream").body)
            self.assertEqual([None if math.isinf(t) else t for t in binary["t"]], rows["t"])
        for kind in ("any", "all", "count"):
            answer = self.server.query("six", kind, {"generator": lidar})
            self.assertEqual((answer.status, answer.json()["code"], answer.json()["errors"][0]["pointer"]), (422, "KEY_UNKNOWN", "/generator/returns"))
        for generator, status, code, pointer in (({**lidar, "returns": 0}, 422, "NUMBER_OUT_OF_RANGE", "/generator/returns"),
                                                 ({**lidar, "returns": 3_000_000}, 413, "RAYS_TOO_MANY", "/generator"),
                                                 ({"kind": "pinhole", "width": 2, "height": 2, "returns": 2}, 422, "KEY_UNKNOWN", "/generator/returns")):
            answer = self.server.query("six", "closest", {"generator": generator})
            self.assertEqual((answer.status, answer.json()["code"], answer.json()["errors"][0]["pointer"]), (status, code, pointer))

    def test_bytes_out(self):
        for generator in ALL:
            with self.subTest(generator=generator["kind"]):
                rays = self.send({"generator": generator}, "-H", "Accept: application/octet-stream")
                self.assertEqual(rays.headers["content-type"], "application/octet-stream")
                self.assertEqual(rays.body[:4], b"SLR1")
                count = struct.unpack_from("<Q", rays.body, 8)[0]
                self.assertEqual(len(rays.body), 24 + 64 * count)
                sent = self.server.ask("/v1/scenes/town/rays:closest", "-H", BINARY, body=rays.body)
                made = self.server.query("town", "closest", {"generator": generator}, "-H", "Accept: application/octet-stream")
                self.assertEqual(made.body, sent.body)
                self.assertEqual(len(unpack(made.body)["t"]), count)

    def test_depth_is_t_of_a_pinhole(self):
        # Straight down from 200 m above the market square, whose top is at 0.25.
        body = {"generator": {"kind": "pinhole", "position": [3, 200, 5], "forward": [0, -1, 0], "up": [0, 0, -1], "fov_y": 0.5,
                              "width": 5, "height": 5}, "fields": ["t", "node"]}
        answer = self.server.query("town", "closest", body).json()
        self.assertEqual(set(answer["node"]), {"market square"})
        for t in answer["t"]:
            self.assertAlmostEqual(t, 199.75, delta=1e-12)

    def test_faults_are_named(self):
        pinhole = {"kind": "pinhole", "width": 2, "height": 2}
        for generator, status, code, pointer in [
                ({}, 422, "KEY_MISSING", "/generator"),
                ({"kind": "fisheye"}, 422, "VALUE_UNKNOWN", "/generator/kind"),
                ({"kind": "pinhole", "width": 2}, 422, "KEY_MISSING", "/generator"),
                ({**pinhole, "azimuths": 2}, 422, "KEY_UNKNOWN", "/generator/azimuths"),
                ({**pinhole, "zoom": 2}, 422, "KEY_UNKNOWN", "/generator/zoom"),
                ({**pinhole, "fov_y": 180}, 422, "NUMBER_OUT_OF_RANGE", "/generator/fov_y"),
                ({**pinhole, "up": [0, 0, 1]}, 422, "GENERATOR_POSE", "/generator"),
                ({**pinhole, "look_at": [0, 0, 0]}, 422, "GENERATOR_POSE", "/generator"),
                ({**pinhole, "look_at": [1, 0, 0], "forward": [1, 0, 0]}, 422, "KEYS_MIXED", "/generator"),
                ({**pinhole, "range": [2, 1]}, 422, "RAY_LIMITS_REVERSED", "/generator/range"),
                ({**pinhole, "width": 3_000_000, "height": 3_000_000}, 413, "RAYS_TOO_MANY", "/generator"),
                ({"kind": "lidar", "azimuths": 5, "elevations": ["up"]}, 422, "TYPE_WRONG", "/generator/elevations/0"),
                ({"kind": "lidar", "azimuths": 5, "elevations": [0], "poses": [{"angle": 1}]}, 422, "KEY_UNKNOWN",
                 "/generator/poses/0/angle"),
                ({"kind": "hemisphere", "points": [[0, 0, 0]], "normals": [], "count": 1}, 422, "LENGTH_WRONG", "/generator/normals"),
                ({"kind": "orthographic", "width": 2, "height": 2, "extent_y": 1e308, "position": [1.7e308, 1.7e308, 0]}, 422,
                 "GENERATOR_RANGE", "/generator")]:
            with self.subTest(generator=generator):
                answer = self.send({"generator": generator})
                self.assertEqual((answer.status, answer.json()["code"]), (status, code), answer.body)
                self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)
        mixed = self.send({"generator": pinhole, "rays": []})
        self.assertEqual(mixed.json()["code"], "KEYS_MIXED")


if __name__ == "__main__":
    case_report.main()
