"""Hits left out by side, node and material, against answers that were worked out by hand."""


import array
import json
import unittest

import case_report
from made_scene import triangle_glb
from sightline_server import Server
from two_scenes import TwoScenes

# Triangle i of "left" stands at x + y/2 with x = -6 + 2i, of "right" with x = 2 + 2i, see rays_test.py. Both show
# their fronts to a ray along +x, their backs to one along -x.
THROUGH = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
BACK = {"origin": [10, 1, 0], "direction": [-1, 0, 0]}
# Down the axis of the clock tower: the tip of the spire, the top of the tower, see lists_test.py.
DOWN = {"origin": [0, 100, 0], "direction": [0, -1, 0], "tmax": 99}


class Filters(TwoScenes):
    def hits(self, scene, *rays, **options):
        answer = self.server.query(scene, "closest", {"rays": list(rays), "fields": ["t", "node"], **options})
        self.assertEqual(answer.status, 200, answer.body)
        return [hit and (hit["t"], hit["node"]) for hit in answer.json()["hits"]]

    def test_sides(self):
        for cull, expected in [("none", [(4.5, "left"), (3.5, "right")]), ("back", [(4.5, "left"), None]),
                               ("front", [None, (3.5, "right")]), ("material", [(4.5, "left"), None])]:
            with self.subTest(cull=cull):
                self.assertEqual(self.hits("six", THROUGH, BACK, cull=cull), expected)

    def test_what_is_left_out_hides_nothing(self):
        self.assertEqual(self.hits("six", THROUGH, exclude={"names": ["left"]}), [(12.5, "right")])
        self.assertEqual(self.hits("six", THROUGH, include={"names": ["r?ght"]}), [(12.5, "right")])
        self.assertEqual(self.hits("six", THROUGH, include={"names": []}), [None])
        self.assertEqual(self.hits("town", DOWN), [(68, "spire")])
        self.assertEqual(self.hits("town", DOWN, exclude={"names": ["sp*"]}), [(76, "clock tower")])

    def test_a_node_stands_for_all_below_it(self):
        ids = self.server.closest("six", ([-10, 1, 0], [1, 0, 0]), ([3, 10, 0], [0, -1, 0]), fields=["node_id", "node_path"])
        self.assertEqual([hit["node_path"].count("/") for hit in ids], [2, 2])
        left, right = (hit["node_id"] for hit in ids)
        (root,) = {0, 1, 2} - {left, right}
        self.assertEqual(self.hits("six", THROUGH, exclude={"nodes": [left]}), [(12.5, "right")])
        self.assertEqual(self.hits("six", THROUGH, exclude={"nodes": [root]}), [None])
        self.assertEqual(self.hits("six", THROUGH, include={"nodes": [root]}, exclude={"nodes": [left]}), [(12.5, "right")])

    def explained(self, ray, **options):
        answer = self.server.query("six", "closest", {"rays": [ray], "explain": True, **options})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["explain"]

    def test_which_filter_left_a_hit_out(self):
        for by, options in [("exclude", {"exclude": {"names": ["left"]}}), ("include", {"include": {"names": ["right"]}}),
                            ("cull", {"cull": "front"}), ("include", {"include": {"names": ["right"]}, "exclude": {"names": ["left"]}})]:
            with self.subTest(by=by):
                seen = [triangle for box in self.explained(THROUGH, **options)["boxes"] for triangle in box.get("triangles", [])]
                first = [triangle for triangle in seen if (triangle["instance"], triangle["triangle"]) == (0, 0)]
                self.assertEqual([(each["verdict"], each["by"], each["t"]) for each in first], [("filtered", by, 4.5)])
                self.assertTrue(all(("by" in each) == (each["verdict"] == "filtered") for each in seen))

    def test_what_a_ray_comes_nearest_to(self):
        # Between the tips of "left" at (0, 4, 0) and the feet of "right" at (2, 0, z), nearer to the first.
        between = {"origin": [0.75, 10, 0], "direction": [0, -1, 0]}
        for options, near, distance in [({}, (0, 2, "left"), 0.75), ({"exclude": {"names": ["left"]}}, (1, 0, "right"), 1.25)]:
            miss = self.explained(between, **options)["nearest_miss"]
            self.assertEqual((miss["instance"], miss["triangle"], miss["node"]), near)
            self.assertAlmostEqual(miss["distance"], distance, places=12)
        # It ends 3 above the tip.
        miss = self.explained({**between, "tmax": 3})["nearest_miss"]
        self.assertAlmostEqual(miss["distance"], (0.75 ** 2 + 9) ** 0.5, places=12)
        self.assertNotIn("nearest_miss", self.explained(THROUGH))
        self.assertIsNone(self.explained(THROUGH, include={"names": []})["nearest_miss"])

    def test_materials(self):
        # A tree of the town seen from above: its first hit is made of leaves.
        rays = [{"origin": [x, 60, z], "direction": [0, -1, 0]} for x in range(-200, 200, 20) for z in range(-200, 200, 20)]
        fields = ["material", "node", "t"]

        def ask(**options):
            return self.server.query("town", "closest", {"rays": rays, "fields": fields, **options}).json()["hits"]

        plain, bare, leaves = ask(), ask(exclude={"materials": ["leaves"]}), ask(include={"materials": ["leaves"]})
        met = [i for i, hit in enumerate(plain) if hit and hit["material"] == "leaves"]
        self.assertTrue(met)
        for i, hit in enumerate(plain):
            if i in met:
                self.assertEqual(leaves[i], hit)
                self.assertTrue(bare[i] is None or bare[i]["t"] > hit["t"] and bare[i]["material"] != "leaves")
            else:
                self.assertEqual(bare[i], hit)

    def test_every_kind_of_ray_query_filters(self):
        options = {"rays": [THROUGH], "exclude": {"names": ["left"]}}
        self.assertEqual(self.server.query("six", "any", options).json(), {"hits": [True]})
        self.assertEqual(self.server.query("six", "any", {**options, "cull": "front"}).json(), {"hits": [False]})
        self.assertEqual(self.server.query("six", "count", options).json(), {"counts": [3]})
        (result,) = self.server.query("six", "all", {**options, "fields": ["t"]}).json()["results"]
        self.assertEqual(result, {"total": 3, "hits": [{"t": 12.5}, {"t": 14.5}, {"t": 16.5}]})

    def test_faults_are_named(self):
        for options, status, code, pointer in [
                ({"cull": "both"}, 422, "VALUE_UNKNOWN", "/cull"),
                ({"include": {}}, 422, "KEY_MISSING", "/include"),
                ({"include": {"node": [1]}}, 422, "KEY_UNKNOWN", "/include/node"),
                ({"exclude": {"nodes": [0, 99]}}, 422, "FILTER_NODE_UNKNOWN", "/exclude/nodes/1"),
                ({"exclude": {"nodes": [-1]}}, 422, "NUMBER_OUT_OF_RANGE", "/exclude/nodes/0"),
                ({"exclude": {"names": [7]}}, 422, "TYPE_WRONG", "/exclude/names/0"),
                ({"exclude": {"names": ["*"] * 65}}, 413, "FILTER_TOO_LARGE", "/exclude/names/64"),
                ({"exclude": {"materials": ["x" * 257]}}, 413, "FILTER_TOO_LARGE", "/exclude/materials/0")]:
            with self.subTest(options=options):
                answer = self.server.query("six", "closest", {"rays": [THROUGH], **options})
                self.assertEqual((answer.status, answer.json()["code"]), (status, code))
                self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)


# One triangle at each place; a ray down to the one at the origin.
DOWN_TO_IT = {"rays": [{"origin": [0.2, 0.2, 20], "direction": [0, 0, -1]}], "fields": ["t"]}


class LongFilters(unittest.TestCase):
    """To work a filter out is part of the request: it ends with its time, and its memory is counted."""

    def serve(self, *options):
        server = Server(*options)
        self.addCleanup(server.end)
        return server

    def send(self, server, path, body):
        return server.ask(f"/v1/scenes/long/{path}", "-H", "Content-Type: application/json", body=json.dumps(body))

    def test_patterns_end_with_the_time_of_their_request(self):
        server = self.serve()
        # Whole, each pattern would take 250 steps for each letter of the name.
        self.assertEqual(server.put("long", triangle_glb([{"mesh": 0, "name": "a" * (1 << 20)}])).status, 201)
        slow = {"names": ["*" + "a" * 250 + f"b{i}" for i in range(32)]}
        for path, body in [("rays:closest", {**DOWN_TO_IT, "exclude": slow}), ("rays:closest", {**DOWN_TO_IT, "include": slow}),
                           ("points:inside", {"points": [[0, 0, 1]], "exclude": slow}),
                           ("clearance", {"a": slow, "b": {"names": ["*"]}})]:
            with self.subTest(path=path):
                answer = self.send(server, path, {**body, "timeout_ms": 20})
                self.assertEqual((answer.status, answer.json()["code"]), (504, "DEADLINE"), answer.body[:300])
        lines = json.dumps({"options": {"exclude": slow, "timeout_ms": 20}}) + "\n" + json.dumps(DOWN_TO_IT["rays"][0]) + "\n"
        answer = server.ask("/v1/scenes/long/rays:closest", "-H", "Content-Type: application/x-ndjson", body=lines)
        self.assertEqual((answer.status, answer.json()["code"]), (504, "DEADLINE"), answer.body[:300])

    def test_what_a_filter_takes_for_each_placement_is_counted(self):
        server = self.serve("--max-request-memory", 1 << 20)
        places = array.array("f", (value for i in range(120000) for value in (i % 1000 * 2, i // 1000 * 2, 0)))
        self.assertEqual(server.put("long", triangle_glb([{"mesh": 0}], places)).status, 201)
        self.assertEqual(self.send(server, "rays:closest", DOWN_TO_IT).status, 200)
        mask = {**DOWN_TO_IT["rays"][0], "mask": 3}
        for path, body in [("rays:closest", {**DOWN_TO_IT, "cull": "back"}), ("rays:any", {"rays": [mask]}),
                           ("rays:count", {"rays": DOWN_TO_IT["rays"], "exclude": {"names": ["x"]}}),
                           ("points:inside", {"points": [[0, 0, 1]], "method": "winding"})]:
            with self.subTest(path=path):
                answer = self.send(server, path, body)
                self.assertEqual((answer.status, answer.json()["code"]), (413, "REQUEST_TOO_LARGE"), answer.body[:300])


if __name__ == "__main__":
    case_report.main()
