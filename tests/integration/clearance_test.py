"""How far selections are from each other, against answers that were worked out by hand."""

import json
import math
import unittest
from fractions import Fraction

import case_report
from sightline_server import JSON_TYPE, Server

# Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, of "right" with x = 2 + 2i. All of them are
# parallel: steps of (2,-1,0) lead straight away. The tip of the spire is (0, 32, 0).
LEFT, RIGHT = {"names": ["left"]}, {"names": ["right"]}


class Clearance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town", "--max-hits", 5000)
        cls.addClassCleanup(cls.server.end)

    def post(self, scene, body):
        return self.server.ask(f"/v1/scenes/{scene}/clearance", "-H", JSON_TYPE, body=json.dumps(body))

    def ask(self, scene, a, b, **more):
        answer = self.post(scene, {"a": a, "b": b, **more})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def test_the_closest_pair(self):
        # The last of "left" leans from x = -2 to 0, the first of "right" begins at x = 2: planes 2 (X + 2) = Y and 2 (X - 2) = Y are
        # 8 / sqrt(5) apart, but the feet of those do not lie in the triangles. The nearest points are the tip (0, 4, 0) and the middle of
        # the other's face: from (0, 4, 0) 8 / sqrt(5) = 3.58 along (2, -1, 0) / sqrt(5) to (3.2, 2.4, 0).
        pair = self.ask("six", LEFT, RIGHT)["pair"]
        self.assertEqual((pair["a"]["triangle"], pair["b"]["triangle"], pair["a"]["node"], pair["b"]["node"]), (2, 0, "left", "right"))
        self.assertEqual(pair["a"]["position"], [0, 4, 0])
        self.assertEqual(pair["b"]["position"], [3.2, 2.4, 0])
        self.assertEqual(pair["distance"], (64 / 5) ** 0.5)
        back = self.ask("six", RIGHT, LEFT)["pair"]
        self.assertEqual((back["distance"], back["b"]), (pair["distance"], pair["a"]))
        # The float64 numbers on both sides of the root.
        below = pair["distance"] if Fraction(pair["distance"]) ** 2 < Fraction(64, 5) else math.nextafter(pair["distance"], 0)
        self.assertEqual(self.ask("six", LEFT, RIGHT, max_distance=math.nextafter(below, 9)), {"pair": pair})
        self.assertEqual(self.ask("six", LEFT, RIGHT, max_distance=below), {"pair": None})
        nobody = self.ask("six", LEFT, {"names": ["nobody"]})
        self.assertEqual((nobody["pair"], [each["pointer"] for each in nobody["warnings"]]), (None, ["/b/names/0"]))

    def test_what_meets_is_at_no_distance(self):
        # The spire stands on the clock tower.
        pair = self.ask("town", {"names": ["spire"]}, {"names": ["clock tower"]})["pair"]
        self.assertEqual((pair["distance"], pair["a"]["position"]), (0, pair["b"]["position"]))
        self.assertEqual(pair["a"]["position"][1], 24)
        self.assertEqual(self.ask("six", LEFT, LEFT)["pair"]["distance"], 0)

    def test_all_pairs_within_a_distance(self):
        # Neighbours of "left" are 4 / sqrt(5) = 1.79 apart, the next but one 3.58, if their feet allow it.
        answer = self.ask("six", LEFT, {"names": ["left", "right"]}, max_distance=2, pairs="triangles")
        ids = [(p["a"]["triangle"], p["b"]["node"], p["b"]["triangle"]) for p in answer["pairs"]]
        self.assertEqual(ids, [(0, "left", 0), (0, "left", 1), (1, "left", 0), (1, "left", 1), (1, "left", 2), (2, "left", 1), (2, "left", 2)])
        self.assertEqual(answer["total"], 7)
        self.assertEqual([p["distance"] for p in answer["pairs"] if p["a"]["triangle"] == p["b"]["triangle"]], [0, 0, 0])
        cut = self.ask("six", LEFT, {"names": ["left", "right"]}, max_distance=2, pairs="triangles", limit=3)
        self.assertEqual(cut, {"total": 7, "pairs": answer["pairs"][:3]})
        nodes = self.ask("six", LEFT, {"names": ["left", "right"]}, max_distance=4, pairs="nodes")
        self.assertEqual([(p["a"]["node"], p["b"]["node"]) for p in nodes["pairs"]], [("left", "left"), ("left", "right")])
        self.assertEqual([p["distance"] for p in nodes["pairs"]], [0, (64 / 5) ** 0.5])
        self.assertEqual(self.ask("six", LEFT, {"names": ["left", "right"]}, max_distance=4, pairs="nodes", exclude=LEFT),
                         {"total": 0, "pairs": []})

    def test_a_wrong_request_is_answered_with_its_place(self):
        for body, status, code, pointer in [
                ({"a": LEFT}, 422, "KEY_MISSING", None), ({"a": LEFT, "b": {}}, 422, "KEY_MISSING", "/b"),
                ({"a": {"nodes": [0, 99]}, "b": RIGHT}, 422, "FILTER_NODE_UNKNOWN", "/a/nodes/1"),
                ({"a": LEFT, "b": RIGHT, "max_distance": -1}, 422, "DISTANCE_NEGATIVE", "/max_distance"),
                ({"a": LEFT, "b": RIGHT, "pairs": "nodes"}, 422, "DISTANCE_MISSING", "/pairs"),
                ({"a": LEFT, "b": RIGHT, "pairs": "meshes"}, 422, "VALUE_UNKNOWN", "/pairs"),
                ({"a": LEFT, "b": RIGHT, "limit": 5001}, 422, "NUMBER_OUT_OF_RANGE", "/limit"),
                ({"a": LEFT, "b": RIGHT, "fields": ["t"]}, 422, "KEY_UNKNOWN", "/fields")]:
            with self.subTest(body=body):
                answer = self.post("six", body)
                self.assertEqual((answer.status, answer.json()["code"]), (status, code))
                if pointer:
                    self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)
        everything = {"names": ["terrain"]}
        answer = self.post("town", {"a": everything, "b": everything, "max_distance": 1, "pairs": "triangles"})
        self.assertEqual((answer.status, answer.json()["code"]), (413, "TOO_MANY_HITS"))


if __name__ == "__main__":
    case_report.main()
