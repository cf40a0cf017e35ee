"""How far selections are from each other, against answers that were worked out by hand."""

import csv
import io
import json
import math
import struct
import unittest
from fractions import Fraction

import case_report
from made_scene import glb
from sightline_server import JSON_TYPE, Server

# Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, of "right" with x = 2 + 2i. All of them are
# parallel: steps of (2,-1,0) lead straight away. The tip of the spire is (0, 32, 0).
LEFT, RIGHT = {"names": ["left"]}, {"names": ["right"]}


def boxes_glb(boxes, open_ones=()):
    """A scene with a node for each box (least and greatest corner); the open ones lack a triangle."""
    faces = [(0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6)]
    data, views, accessors, meshes, nodes = b"", [], [], [], []
    for name, (low, high) in boxes.items():
        corners = [[(high if i >> k & 1 else low)[k] for k in range(3)] for i in range(8)]
        indices = [i for face in faces[:-1 if name in open_ones else None] for i in face]
        for part, kind, count, shape in ((struct.pack("<24f", *(x for corner in corners for x in corner)), 5126, 8, "VEC3"),
                                         (struct.pack(f"<{len(indices)}I", *indices), 5125, len(indices), "SCALAR")):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
            accessors.append({"bufferView": len(accessors), "componentType": kind, "count": count, "type": shape})
            data += part
        accessors[-2].update(min=list(low), max=list(high))
        meshes.append({"primitives": [{"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1}]})
        nodes.append({"name": name, "mesh": len(nodes)})
    return glb({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
                "buffers": [{"byteLength": len(data)}], "bufferViews": views, "accessors": accessors}, data)


class Clearance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town", "--max-hits", 5000)
        cls.addClassCleanup(cls.server.end)

    def post(self, scene, body):
        return self.server.ask(f"/v1/scenes/{scene}/clearance", "-H", JSON_TYPE, body=json.dumps(body))

    def ask(self, /, scene, a, b, **more):
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

    def test_both_ends_have_the_fields_that_are_asked_for(self):
        names = ["instance", "primitive", "triangle", "position", "node", "node_id", "node_path", "mesh", "mesh_id", "material", "material_id",
                 "node_instance"]
        pair = self.ask("six", LEFT, RIGHT, fields=names)["pair"]
        self.assertEqual(list(pair["a"]), names)
        self.assertEqual((pair["a"]["node_id"], pair["a"]["node_path"], pair["b"]["node_path"]), (1, "/root/left", "/root/right"))
        self.assertEqual(self.ask("six", LEFT, RIGHT, fields=["node_id"])["pair"]["b"], {"node_id": 2})
        self.assertEqual(self.ask("six", LEFT, RIGHT)["pair"]["b"]["node_id"], 2)

    def test_each_side_leaves_out_its_own(self):
        everything = {"names": ["*"]}
        pairs = self.ask("town", {"names": ["spire"]}, {**everything, "exclude": {"names": ["spire"]}}, pairs="nodes", max_distance=30)["pairs"]
        self.assertEqual({pair["a"]["node"] for pair in pairs}, {"spire"})
        self.assertNotIn("spire", {pair["b"]["node"] for pair in pairs})
        self.assertIn("clock tower", {pair["b"]["node"] for pair in pairs})
        # "exclude" beside the sides holds for both.
        self.assertEqual(self.ask("town", {"names": ["spire"]}, everything, exclude={"names": ["spire"]})["pair"], None)
        self.assertEqual(self.ask("six", {"exclude": LEFT}, LEFT)["pair"]["a"]["node"], "right")

    def test_a_node_with_itself_and_with_its_parent_can_be_left_out(self):
        parents = {node["node_id"]: node["parent"] for node in self.server.ask("/v1/scenes/town/nodes?limit=5000").json()["nodes"]}
        some = {"names": ["clock tower", "market square", "street*", "avenue*"]}
        for pairs in ("triangles", "nodes"):
            def ask(**more):
                answer = self.ask("town", some, some, pairs=pairs, max_distance=0.5, limit=5000, **more)
                self.assertEqual(answer["total"], len(answer["pairs"]))
                return answer["pairs"]

            def is_family(pair):
                a, b = pair["a"]["node_id"], pair["b"]["node_id"]
                return parents[a] == b or parents[b] == a

            whole = ask()
            others = [pair for pair in whole if pair["a"]["instance"] < pair["b"]["instance"]]
            self.assertEqual(ask(self=False), others)
            self.assertEqual(ask(adjacent=False), [pair for pair in whole if not is_family(pair)])
            self.assertEqual(ask(self=False, adjacent=False), [pair for pair in others if not is_family(pair)])
            self.assertTrue(any(map(is_family, others)))
            self.assertLess(len(others), len(whole))
        closest = self.ask("town", {"names": ["clock tower"]}, {"names": ["clock tower"]}, **{"self": False})["pair"]
        self.assertEqual((closest["a"]["node"], closest["b"]["node"], closest["distance"]), ("clock tower", "spire", 0))
        self.assertIsNone(self.ask("town", {"names": ["clock tower"]}, {"names": ["clock tower"]}, self=False, adjacent=False)["pair"])

    def test_each_kind_of_pair(self):
        boxes = {"room": ((0, 0, 0), (20, 20, 20)), "table": ((5, 5, 5), (7, 7, 7)), "same table": ((5, 5, 5), (7, 7, 7)),
                 "stack": ((5, 5, 7), (7, 7, 8)), "lamp": ((6, 6, 7.5), (9, 9, 9)), "beside": ((10, 5, 5), (11, 7, 7)),
                 "crate": ((18, 18, 18), (22, 22, 22)), "far": ((50, 0, 0), (51, 1, 1)), "slab": ((6, 5, 5), (9, 7, 7))}
        self.server.put("boxes", boxes_glb(boxes))
        everything = {"names": ["*"]}
        question = {"a": everything, "b": everything, "pairs": "nodes", "max_distance": 3, "self": False, "kinds": True, "fields": ["node"]}
        answer = self.post("boxes", question).json()
        found = {(pair["a"]["node"], pair["b"]["node"]): (pair["kind"], pair["depth"], pair["distance"]) for pair in answer["pairs"]}
        self.assertEqual(found[("table", "same table")], ("duplicate", 2, 0))
        self.assertEqual(found[("room", "table")], ("b_in_a", 7, 5))
        self.assertEqual(found[("room", "crate")], ("crossing", 2, 0))
        self.assertEqual(found[("table", "stack")], ("touching", 0, 0))
        self.assertEqual(found[("stack", "lamp")], ("crossing", 0.5, 0))
        self.assertEqual(found[("table", "beside")], ("near", None, 3))
        # Their faces are in common planes, so that no triangles cross, but the bodies overlap.
        self.assertEqual(found[("table", "slab")], ("crossing", 1, 0))
        self.assertNotIn(("table", "far"), found)
        self.assertEqual(sum(answer["kinds"].values()), 9 * 8 // 2)
        self.assertEqual(answer["kinds"]["apart"], 36 - len(found))
        for kind, count in answer["kinds"].items():
            if kind != "apart":
                self.assertEqual(count, sum(each[0] == kind for each in found.values()), kind)
        cut = self.post("boxes", {**question, "limit": 2}).json()
        self.assertEqual((cut["total"], cut["kinds"], cut["pairs"]), (answer["total"], answer["kinds"], answer["pairs"][:2]))
        self.assertEqual(list(answer["kinds"]), ["duplicate", "a_in_b", "b_in_a", "crossing", "touching", "near", "apart"])
        # With two sides the node of side `a` is `a`, also if it comes later in the file.
        turned = self.post("boxes", {**question, "a": {"names": ["table", "lamp"]}, "b": {"names": ["room"]}}).json()
        self.assertEqual([(pair["a"]["node"], pair["b"]["node"], pair["kind"], pair["depth"]) for pair in turned["pairs"]],
                         [("table", "room", "a_in_b", 7), ("lamp", "room", "a_in_b", 9)])
        self.assertEqual(turned["kinds"], {**dict.fromkeys(answer["kinds"], 0), "a_in_b": 2})
        # An open room has no inside.
        self.server.put("boxes", boxes_glb(boxes, open_ones=("room",)))
        pairs = self.post("boxes", {**question, "max_distance": 30}).json()["pairs"]
        kinds = {(pair["a"]["node"], pair["b"]["node"]): (pair["kind"], pair["depth"]) for pair in pairs}
        self.assertEqual((kinds[("room", "table")], kinds[("room", "crate")]), (("near", None), ("crossing", None)))

    def test_pairs_as_csv(self):
        names = {"a, \"b\"": ((0, 0, 0), (1, 1, 1)), "c": ((1, 0, 0), (2, 1, 1)), "d": ((0.5, 0.5, 0.5), (3, 3, 3))}
        self.server.put("few", boxes_glb(names))
        question = {"a": {"names": ["*"]}, "b": {"names": ["*"]}, "pairs": "nodes", "max_distance": 1, "self": False, "kinds": True,
                    "fields": ["node", "node_id", "material", "position"]}
        pairs = self.post("few", question).json()["pairs"]
        told = self.server.ask("/v1/scenes/few/clearance", "-H", JSON_TYPE, "-H", "Accept: text/csv", body=json.dumps(question))
        self.assertEqual((told.status, told.headers["content-type"]), (200, "text/csv"))
        rows = list(csv.DictReader(io.StringIO(told.body.decode(), newline="")))
        self.assertEqual(len(rows), 3)
        for row, pair in zip(rows, pairs):
            self.assertEqual((row["kind"], float(row["depth"]), float(row["distance"])), (pair["kind"], pair["depth"], pair["distance"]))
            for side in "ab":
                self.assertEqual((row[f"{side}.node"], int(row[f"{side}.node_id"]), row[f"{side}.material"]),
                                 (pair[side]["node"], pair[side]["node_id"], ""))
                self.assertEqual([float(row[f"{side}.position_{k}"]) for k in "xyz"], pair[side]["position"])
        closest = self.server.ask("/v1/scenes/six/clearance", "-H", JSON_TYPE, "-H", "Accept: text/csv",
                                  body=json.dumps({"a": LEFT, "b": RIGHT, "fields": ["node"]}))
        self.assertEqual(closest.body, b"distance,a.node,b.node\r\n3.5777087639996634,left,right\r\n")

    def test_a_wrong_request_is_answered_with_its_place(self):
        for body, status, code, pointer in [
                ({"a": LEFT}, 422, "KEY_MISSING", None), ({"a": LEFT, "b": {}}, 422, "KEY_MISSING", "/b"),
                ({"a": {"nodes": [0, 99]}, "b": RIGHT}, 422, "FILTER_NODE_UNKNOWN", "/a/nodes/1"),
                ({"a": LEFT, "b": RIGHT, "max_distance": -1}, 422, "DISTANCE_NEGATIVE", "/max_distance"),
                ({"a": LEFT, "b": RIGHT, "pairs": "nodes"}, 422, "DISTANCE_MISSING", "/pairs"),
                ({"a": LEFT, "b": RIGHT, "pairs": "meshes"}, 422, "VALUE_UNKNOWN", "/pairs"),
                ({"a": LEFT, "b": RIGHT, "limit": 5001}, 422, "NUMBER_OUT_OF_RANGE", "/limit"),
                ({"a": LEFT, "b": RIGHT, "fields": ["node_id", "t"]}, 422, "FIELD_UNKNOWN", "/fields/1"),
                ({"a": LEFT, "b": RIGHT, "kinds": True}, 422, "KEYS_MIXED", "/kinds"),
                ({"a": LEFT, "b": RIGHT, "kinds": True, "pairs": "triangles", "max_distance": 1}, 422, "KEYS_MIXED", "/kinds"),
                ({"a": LEFT, "b": RIGHT, "self": 1}, 422, "TYPE_WRONG", "/self"),
                ({"a": LEFT, "b": {"names": ["*"], "exclude": {"nodes": [99]}}}, 422, "FILTER_NODE_UNKNOWN", "/b/exclude/nodes/0"),
                ({"a": LEFT, "b": {"names": ["*"], "exclude": {}}}, 422, "KEY_MISSING", "/b/exclude"),
                ({"a": LEFT, "b": RIGHT, "include": {"names": ["*"], "exclude": LEFT}}, 422, "KEY_UNKNOWN", "/include/exclude")]:
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
