"""Filters of single rays: the answers are those of one request for each filter, byte by byte."""

import json
import random
import struct
import sys
import unittest

import case_report
from made_scene import tiles
from sightline_server import SOURCE, Server

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)

NODES = 64
FILTERS = [{}, {"include": {"nodes": list(range(0, NODES, 2))}}, {"exclude": {"names": ["tile 1*", "tile 2*"]}}, {"cull": "front"},
           {"cull": "back", "mask": 3, "exclude": {"nodes": [0, 1]}}, {"include": {"nodes": []}}]


def made_rays(count, seed=7):
    made = random.Random(seed)
    return [{"origin": [made.uniform(0, 320), 9, made.uniform(0, 20)], "direction": [made.uniform(-1, 1), -1, made.uniform(-1, 1)]}
            for _ in range(count)]


class RayFilters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server(memory=None)
        cls.addClassCleanup(cls.server.end)
        answer = cls.server.put("tiles", tiles(4, NODES))
        assert answer.status == 201, answer.body
        for node in range(0, NODES, 3):
            cls.server.ask(f"/v1/scenes/tiles/nodes/{node}", "-X", "PATCH", "-H", "Content-Type: application/json",
                           body=json.dumps({"mask": 4 if node % 2 else 2}))

    def ask(self, kind, body, *arguments):
        answer = self.server.query("tiles", kind, body, *arguments)
        self.assertEqual(answer.status, 200, answer.body)
        return answer

    def test_the_answers_are_those_of_one_request_for_each_filter(self):
        rays, made = made_rays(1500), random.Random(1)
        for masked in (False, True):
            if masked:
                for ray in rays:
                    ray["mask"] = made.choice([1, 2, 4, 6, 4294967295])
            numbers = [made.randrange(len(FILTERS)) for _ in rays]
            for kind, member, more in (("closest", "hits", {"fields": ["t", "node_id", "triangle", "normal", "position"]}), ("any", "hits", {}),
                                       ("count", "counts", {}), ("all", "results", {"fields": ["t", "instance", "triangle"], "max_hits": 2}),
                                       ("closest", "hits", {"alpha": "cutoff"})):
                with self.subTest(kind=kind, masked=masked):
                    together = self.ask(kind, {"rays": rays, "filters": {"list": FILTERS, "rays": numbers}, **more}).json()
                    expected = [None] * len(rays)
                    for k, each in enumerate(FILTERS):
                        own = [i for i, number in enumerate(numbers) if number == k]
                        answer = self.ask(kind, {"rays": [rays[i] for i in own], **each, **more}).json()
                        for place, i in enumerate(own):
                            expected[i] = answer[member][place]
                    self.assertEqual(json.dumps(together[member]), json.dumps(expected))

    def test_columns_bytes_and_generators_have_filters_too(self):
        rays, numbers = made_rays(200), [i % 3 for i in range(200)]
        filters = {"list": FILTERS[:3], "rays": numbers}
        rows = self.ask("closest", {"rays": rays, "filters": filters, "fields": ["t", "instance", "triangle"]}).json()["hits"]
        columns = self.ask("closest", {"origins": [x for ray in rays for x in ray["origin"]], "filters": filters,
                                       "directions": [x for ray in rays for x in ray["direction"]], "fields": ["t", "instance", "triangle"]}).json()
        for name in ("t", "instance", "triangle"):
            self.assertEqual(columns[name], [hit[name] if hit else {"t": None}.get(name, -1) for hit in rows])
        options = json.dumps({"filters": filters, "fields": ["t"]}).encode()
        options += b" " * (-len(options) % 8)
        column = [struct.pack(f"<{len(rays)}d", *(ray[part][k] for ray in rays)) for part in ("origin", "direction") for k in range(3)]
        body = b"SLR1" + struct.pack("<IQII", 1, len(rays), len(options), 0) + options + b"".join(column)
        answer = self.server.ask("/v1/scenes/tiles/rays:closest", "-H", "Content-Type: application/octet-stream", body=body)
        self.assertEqual(answer.status, 200, answer.body)
        self.assertIn(struct.pack(f"<{len(rays)}d", *(hit["t"] if hit else float("inf") for hit in rows)), answer.body)
        pinhole = {"kind": "pinhole", "position": [100, 60, 10], "look_at": [100, 0, 11], "fov_y": 60, "width": 8, "height": 8}
        plain = self.ask("closest", {"generator": pinhole, "exclude": {"nodes": [9]}, "fields": ["t"]}).body
        same = self.ask("closest", {"generator": pinhole, "filters": {"list": [{"exclude": {"nodes": [9]}}], "rays": [0] * 64},
                                    "fields": ["t"]}).body
        self.assertEqual(plain, same)

    def test_the_python_client_cuts_the_numbers_with_the_rays(self):
        made = random.Random(3)
        count = 70_000  # More than a slice.
        origins = [[made.uniform(0, 320), 9, made.uniform(0, 20)] for _ in range(count)]
        numbers = [i * 7 % 3 for i in range(count)]
        with sightline.Sightline(self.server.url) as client:
            arguments = (origins, [[0, -1, 0]] * count)
            found = client.closest("tiles", *arguments, fields=["instance"], filters={"list": FILTERS[:3], "rays": numbers})["instance"]
            each = [client.closest("tiles", *arguments, fields=["instance"], **options)["instance"] for options in FILTERS[:3]]
            self.assertEqual(list(found), [each[number][i] for i, number in enumerate(numbers)])
            with self.assertRaises(ValueError):
                client.any("tiles", *arguments, filters={"list": [{}], "rays": [0]})

    def test_errors_and_warnings_name_the_place(self):
        rays = made_rays(2)
        good = {"list": [{}, {"cull": "back"}], "rays": [0, 1]}
        for filters, more, code, pointer in [
                ({**good, "rays": [0]}, {}, "LENGTH_WRONG", "/filters/rays"),
                ({**good, "rays": [0, 2]}, {}, "NUMBER_OUT_OF_RANGE", "/filters/rays/1"),
                ({**good, "rays": [0, -1]}, {}, "NUMBER_OUT_OF_RANGE", "/filters/rays/1"),
                ({"list": [{}]}, {}, "KEY_MISSING", "/filters"),
                ({"list": [], "rays": []}, {}, "KEY_MISSING", "/filters"),
                ({**good, "each": 1}, {}, "KEY_UNKNOWN", "/filters/each"),
                ({**good, "list": [{}, {"colour": 1}]}, {}, "KEY_UNKNOWN", "/filters/list/1/colour"),
                ({**good, "list": [{}, {"include": {"nodes": ["a"]}}]}, {}, "TYPE_WRONG", "/filters/list/1/include/nodes/0"),
                ({**good, "list": [{}, {"include": {"nodes": [999]}}]}, {}, "FILTER_NODE_UNKNOWN", "/filters/list/1/include/nodes/0"),
                ({**good, "list": [{}, {"include": {"names": ["tree"]}}]}, {"strict": True}, "SELECTION_EMPTY", "/filters/list/1/include/names/0"),
                (good, {"cull": "back"}, "KEYS_MIXED", "/filters"),
                (good, {"mask": 1}, "KEYS_MIXED", "/filters"),
                (good, {"exclude": {"nodes": [1]}}, "KEYS_MIXED", "/filters"),
                (good, {"fields": ["t", "cost_nodes"]}, "KEYS_MIXED", "/filters")]:
            with self.subTest(filters=filters, more=more):
                answer = self.server.query("tiles", "closest", {"rays": rays, "filters": filters, **more})
                self.assertGreaterEqual(answer.status, 400, answer.body)
                self.assertEqual((answer.json()["code"], answer.json()["errors"][0]["pointer"]), (code, pointer))
        warned = self.ask("closest", {"rays": rays, "filters": {**good, "list": [{}, {"include": {"names": ["tree"]}}]}}).json()
        self.assertEqual([warning["pointer"] for warning in warned["warnings"]], ["/filters/list/1/include/names/0"])
        self.assertEqual(self.server.query("tiles", "nearest", {"points": [[0, 0, 0]], "filters": good}).status, 404)
        points = self.server.ask("/v1/scenes/tiles/points:nearest", "-H", "Content-Type: application/json",
                                 body=json.dumps({"points": [[0, 0, 0]], "filters": good}))
        self.assertEqual(points.json()["code"], "KEY_UNKNOWN")


if __name__ == "__main__":
    case_report.main()
